//! Diffuse reflectance of a face, and light that spreads in tissue.

use crate::beams::{covered, covered_by, scattering};
use crate::bench::{self, close};
use crate::fresnel::decided;
use tirtouch::optics::fresnel::{lambertian_mean, reflectance};
use tirtouch::optics::tissue::HalfSpace;
use tirtouch::trace::cpu::{End, vec3::V3};

/// Duntley's closed form of the external diffuse reflectance of index m, as given by Stern (1964).
fn external(m: f64) -> f64 {
    let (m2, m4) = (m * m, m * m * m * m);
    0.5 + (m - 1.0) * (3.0 * m + 1.0) / (6.0 * (m + 1.0).powi(2))
        + m2 * (m2 - 1.0).powi(2) / (m2 + 1.0).powi(3) * ((m - 1.0) / (m + 1.0)).ln()
        - 2.0 * m2 * m * (m2 + 2.0 * m - 1.0) / ((m2 + 1.0) * (m4 - 1.0))
        + 8.0 * m4 * (m4 + 1.0) / ((m2 + 1.0) * (m4 - 1.0).powi(2)) * m.ln()
}

#[test]
fn diffuse_reflectance_of_the_1_41_face_is_0_07834_outside_and_0_5364_inside() {
    let n = 1.41;
    let outside = external(n);
    let inside = 1.0 - (1.0 - outside) / (n * n);
    close("external, listed", outside, 0.078_34, 5e-6);
    close("internal, listed", inside, 0.5364, 5e-5);
    // The program's own means are midpoint sums of 2e5 steps; the root at grazing (outside) and at the critical angle
    // (inside) leave about steps^-1.5 = 1e-8 of error.
    close("external, by the sum", lambertian_mean(|c| reflectance(c, 1.0, n)), outside, 3e-8);
    close("internal, by the sum", lambertian_mean(|c| reflectance(c, n, 1.0)), inside, 3e-8);

    let model = bench::model(&bench::stack(&[[1.0, n]]));
    for (what, face, side, layer, n_i, expected, digits) in
        [("external", 0, 1.0, 0, 1.0, outside, 2), ("internal", 1, 1.0, 1, n, inside, 3)]
    {
        let momentum = |sin_sq: f64| [n_i * sin_sq.sqrt(), 0.0, n_i * (1.0 - sin_sq).sqrt()];
        // The mean of what the tracer decides by, over Lambertian light: the same sum, with 2e4 steps to 4e-7.
        let steps = 20_000;
        let mean = (0..steps)
            .map(|k| {
                let mut path = bench::path(&model, layer, [0.0; 3], momentum((f64::from(k) + 0.5) / f64::from(steps)));
                decided(&mut path, face, side)
            })
            .sum::<f64>()
            / f64::from(steps);
        close(what, mean, expected, 1e-6);
        bench::count(&model.cast::<f32>(), 13, 1 << 24, |path| {
            let sin_sq = f64::from(path.draw());
            bench::put(path, layer, [0.0; 3], momentum(sin_sq));
            !path.meet(face, V3::up(), side as f32)
        })
        .is(&format!("{what}, counted"), expected, digits);
    }
}

#[test]
fn tissue_of_1_41_under_air_keeps_light_by_its_internal_reflectance() {
    let (albedo, n) = (0.5, 1.41);
    let mut loaded = bench::stack(&[[1.0, 1.0]]);
    covered(&mut loaded, n, albedo);
    let model = bench::model(&loaded);
    let inside = 1.0 - (1.0 - external(n)) / (n * n);
    let reentry = model.tissue.as_ref().unwrap().scatter.reentry(1.0);
    close("re-entry of the map", reentry[0][0], inside, 3e-8);
    // Absorbed at each turn by 1 - albedo, sent back by the face by R: (1 - albedo) / (1 - albedo R) stays.
    bench::count(&model.cast::<f32>(), 14, 1 << 24, |path| {
        bench::put(path, 1, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
        path.tissue_walk(1.0) == End::Absorbed
    })
    .is("absorbed", (1.0 - albedo) / (1.0 - albedo * inside), 3);
}

#[test]
fn light_leaves_the_tissue_at_christensen_and_burleys_distance_and_in_every_direction() {
    let spread = 1.0;
    let mut loaded = bench::stack(&[[1.0, 1.41]]);
    covered(&mut loaded, 1.41, 1.0);
    loaded.scene.stack.footprint_mm = [1e3, 1e3];
    if let Some(contact) = &mut loaded.scene.touch.contact {
        contact.tissue.spread_mm = spread;
    }
    let model = bench::model(&loaded).cast::<f32>();
    let mut path = bench::path(&model, 1, [0.0; 3], [0.0; 3]);
    let n = 1 << 19;
    let steps: Vec<(f64, f64)> = (0..n)
        .map(|k| {
            path.start_random(15, k, 0);
            bench::put(&mut path, 1, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
            // Matched and white: in, once sideways, out.
            assert_eq!(path.tissue_walk(1.0), End::GoesOn);
            (f64::from(path.o.x), f64::from(path.o.y))
        })
        .collect();
    let radii: Vec<f64> = steps.iter().map(|(x, y)| x.hypot(*y)).collect();
    // (exp(-r/d) + exp(-r/3d)) / (8 pi d r): a quarter has the mean d, the rest 3 d, together 2.5 d; its second moment
    // is 2 d^2 (1/4 + 9 3/4) = 14 d^2.
    let d = spread / 2.5;
    let mean = radii.iter().sum::<f64>() / f64::from(n);
    let four = 4.0 * (14.0 * d * d - spread * spread).sqrt() / f64::from(n).sqrt();
    close("mean distance", mean, spread, four);
    bench::kolmogorov("distances", radii, |r| 1.0 - 0.25 * (-r / d).exp() - 0.75 * (-r / (3.0 * d)).exp());
    let mut turns = [0.0; 64];
    for (x, y) in steps {
        let turn = (y.atan2(x) / std::f64::consts::TAU + 1.0).fract();
        turns[(turn * 64.0) as usize % 64] += 1.0;
    }
    bench::chi_square("directions", &turns, &[f64::from(n) / 64.0; 64]);
}

/// Chandrasekhar's H functions: 1 and 0.01 per mm return 0.754 of light that comes along the normal, 0.816 at 60
/// degrees and 0.7955 of Lambertian light; 1 and 0.1 per mm 0.4955 of that. `optics::tissue` is held to these, and here
/// the tracer to it.
#[test]
fn tissue_given_by_coefficients_returns_what_the_angle_of_the_light_asks_for() {
    for (what, absorption, cosine, listed) in
        [("normal", 0.01, Some(1.0), 0.754), ("60 degrees", 0.01, Some(0.5), 0.816), ("Lambertian", 0.1, None, 0.4955)]
    {
        let mut loaded = bench::stack(&[[1.0, 1.41]]);
        covered_by(&mut loaded, scattering(absorption));
        let model = bench::model(&loaded).cast::<f32>();
        let tissue = HalfSpace::new(1.0, absorption);
        let exact = cosine.map_or(tissue.returned_diffuse(), |mu| tissue.returned(mu));
        close(what, exact, listed, 5e-4);
        bench::count(&model, 16, 1 << 24, |path| {
            bench::put(path, 1, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
            let mu = cosine.map_or_else(|| path.draw().sqrt(), |mu| mu as f32);
            path.tissue_walk(mu) == End::GoesOn
        })
        .is(what, exact, 3);
    }
}

#[test]
fn light_leaves_tissue_given_by_coefficients_by_chandrasekhars_law() {
    let mut loaded = bench::stack(&[[1.0, 1.41]]);
    covered_by(&mut loaded, scattering(0.01));
    let model = bench::model(&loaded).cast::<f32>();
    let tissue = HalfSpace::new(1.0, 0.01);
    let n = 1u64 << 20;
    let mut lambertian = true;
    for mu_i in [0.3, 1.0] {
        // Weights and their squares in cells of even sin^2, which Lambertian light fills alike.
        let sums: [f64; 32] = bench::sums(&model, 17, n, |path| {
            bench::put(path, 1, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
            let mut cells = [0.0; 32];
            if path.tissue_walk(mu_i as f32) == End::GoesOn {
                let cos = f64::from(path.p.z) / 1.41;
                let cell = ((1.0 - cos * cos) * 16.0).clamp(0.0, 15.0) as usize;
                let weight = f64::from(path.weight);
                (cells[2 * cell], cells[2 * cell + 1]) = (weight, weight * weight);
            }
            cells
        });
        for cell in 0..16 {
            let [mean, square] = [0, 1].map(|k| sums[2 * cell + k] / n as f64);
            let mu = |k: i32| (1.0 - (cell as f64 + (f64::from(k) + 0.5) / 1000.0) / 16.0).sqrt();
            let exact = (0..1000).map(|k| tissue.sent(mu_i, mu(k))).sum::<f64>() / 16_000.0;
            // 32 cells beyond 4.5 standard errors: a chance of 2e-4.
            let off = 4.5 * ((square - mean * mean) / n as f64).sqrt();
            close(&format!("from {mu_i} into cell {cell}"), mean, exact, off);
            lambertian &= (tissue.returned(mu_i) / 16.0 - mean).abs() <= off;
        }
    }
    assert!(!lambertian, "a Lambertian exit would pass too");
}

/// Nothing is lost or gained in tissue that absorbs nothing, whatever the boundary mirrors back.
#[test]
fn white_tissue_gives_all_light_back_through_any_boundary() {
    let mut loaded = bench::stack(&[[1.0, 1.2]]);
    covered_by(&mut loaded, scattering(0.0));
    let model = bench::model(&loaded).cast::<f32>();
    let n = 1u64 << 20;
    for mu in [0.1, 1.0] {
        let [sum, squares] = bench::sums(&model, 18, n, |path| {
            bench::put(path, 1, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
            assert_eq!(path.tissue_walk(mu), End::GoesOn);
            let weight = f64::from(path.weight);
            [weight, weight * weight]
        });
        let mean = sum / n as f64;
        close(&format!("from {mu}"), mean, 1.0, 4.0 * ((squares / n as f64 - mean * mean) / n as f64).sqrt() + 3e-5);
    }
}
