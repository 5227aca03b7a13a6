use super::*;
use crate::mechanics::frames::{Reference, Settings, features};
use crate::scene::scan_preset;

#[test]
fn probe() {
    let mut loaded = scan_preset("frames-galea").unwrap();
    let env = |name: &str, default: f64| std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default);
    loaded.scene.scan.positions_mm.count = env("COUNT", 9.0) as u32;
    loaded.scene.scan.resolution = env("RES", 1.0);
    loaded.scene.phantom.inclusion[0].depth_mm = env("TOP", 5.0);
    let setup = ScanSetup::from_scene(&loaded).unwrap();
    let done = scan(&setup, ScanSettings { shown_mm: 0.0, estimate_error: true }, &|_| true).unwrap();
    println!("unknowns {} iterations {} seconds {:.2} + {:.2} {:?}", done.unknowns, done.iterations, done.seconds, done.error_seconds, done.error);
    let settings = Settings { window_mm: Some(env("WINDOW", 10.0)), ..Settings::default() };
    for (f, force) in features(&done.frames, Reference::Without(&done.without), &settings).unwrap().iter().zip(&done.force_n_per_mm) {
        let c = f.parabola.unwrap().coefficients[2];
        let p = f.peak_kpa.value().unwrap();
        println!("{:.1} force {force:.4} peak {p:.3} base {:.3} centre {:.3} fwhm {:.2} fwhm0 {:.2} ecc {:.3}", f.position_mm, f.base_kpa.value().unwrap(), f.center_mm.value().unwrap(), f.fwhm_mm.value().unwrap(), (2.0 * p / -c).sqrt(), f.eccentricity.value().unwrap());
    }
    if std::env::var_os("RAW").is_some() {
        for frame in [&done.frames.as_slice()[0], &done.frames.as_slice()[done.frames.as_slice().len() / 2]] {
            println!("{:?}", frame.x_mm.iter().zip(&frame.pressure_kpa).map(|(x, p)| format!("{x:.2}:{p:.3}")).collect::<Vec<_>>());
        }
    }
}
