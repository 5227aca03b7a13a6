use super::*;
use crate::mechanics::frames::{Reference, Settings, features};
use crate::scene::{Elastic, scan_preset};

#[test]
fn probe() {
    let mut loaded = scan_preset("frames-galea").unwrap();
    let env = |name: &str, default: f64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    loaded.scene.scan.positions_mm.count = env("COUNT", 9.0) as u32;
    loaded.scene.scan.resolution = env("RES", 1.0);
    loaded.scene.phantom.inclusion[0].depth_mm = env("TOP", 5.0);
    let law = |youngs_kpa: f64| match env("LAW", 0.0) as u32 {
        0 => Elastic::Linear { youngs_kpa, poisson: 0.4999, relaxation: vec![] },
        1 => Elastic::NeoHookean { youngs_kpa, poisson: 0.4999, relaxation: vec![] },
        _ => Elastic::Exponential { modulus_kpa: youngs_kpa, exponent: env("M", 9.0), poisson: 0.4999, relaxation: vec![] },
    };
    loaded.scene.phantom.material = law(env("ET", 5.0));
    loaded.scene.phantom.inclusion[0].material = law(env("EI", 50.0));
    let setup = ScanSetup::from_scene(&loaded).unwrap();
    let done = match scan(&setup, ScanSettings { shown_mm: 0.0, estimate_error: true }, &|_| true) { Ok(d) => d, Err(e) => { println!("{e}"); return } };
    println!("one {} unknowns {} iterations {} seconds {:.2} + {:.2} {:?}", done.one_factorisation, done.unknowns, done.iterations, done.seconds, done.error_seconds, done.error);
    if std::env::var_os("FULL").is_some() {
        let mut full = setup.clone();
        full.grip = crate::mechanics::contact::Grip::Coulomb(0.0);
        let full = scan(&full, ScanSettings { shown_mm: 0.0, estimate_error: false }, &|_| true).unwrap();
        println!("full: seconds {:.2} iterations {}", full.seconds, full.iterations);
        let worst = |a: &crate::mechanics::frames::Frames, b: &crate::mechanics::frames::Frames| a.as_slice().iter().zip(b.as_slice()).flat_map(|(a, b)| a.pressure_kpa.iter().zip(&b.pressure_kpa).map(|(p, q)| (p - q).abs())).fold(0.0, f64::max);
        println!("difference {:.2e} {:.2e} kPa", worst(&done.frames, &full.frames), worst(&done.without, &full.without));
    }
    let settings = Settings { window_mm: Some(env("WINDOW", 10.0)), ..Settings::default() };
    for (k, (f, force)) in features(&done.frames, Reference::Without(&done.without), &settings).unwrap().iter().zip(&done.force_n_per_mm).enumerate() {
        let v = |f: &crate::mechanics::frames::Feature| f.value().unwrap_or(f64::NAN);
        let (a, b) = (&done.frames.as_slice()[k], &done.without.as_slice()[k]);
        let side: f64 = a.x_mm.iter().zip(&a.pressure_kpa).zip(&b.pressure_kpa).map(|((x, p), q)| (p - q) * if *x > 0.0 { 1.0 } else if *x < 0.0 { -1.0 } else { 0.0 }).sum();
        let total: f64 = a.pressure_kpa.iter().sum();
        let highest = a.pressure_kpa.iter().copied().fold(0.0, f64::max);
        println!("{:.1} force {force:.4} max {highest:.3} peak {:.3} base {:.3} centre {:.3} fwhm {:.2} ecc {:.3} of total {:.4}", f.position_mm, v(&f.peak_kpa), v(&f.base_kpa), v(&f.center_mm), v(&f.fwhm_mm), v(&f.eccentricity), side / total);
    }
    if std::env::var_os("RAW").is_some() {
        for frame in [&done.frames.as_slice()[0], &done.frames.as_slice()[done.frames.as_slice().len() / 2]] {
            println!("{:?}", frame.x_mm.iter().zip(&frame.pressure_kpa).map(|(x, p)| format!("{x:.2}:{p:.3}")).collect::<Vec<_>>());
        }
    }
}
