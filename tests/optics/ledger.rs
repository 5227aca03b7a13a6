//! The flux ledger of every preset, the dark image of the paper's flat stack, and what leaks without the cut-off cone.

use crate::bench::{self, close};
use rayon::prelude::*;
use tirtouch::optics::reflectance;
use tirtouch::scene::{self, Mount};
use tirtouch::trace::Integrator;
use tirtouch::trace::batch::Batch;
use tirtouch::trace::cpu::book;
use tirtouch::trace::modes::{CameraMode, PhotonMode};

#[test]
fn emitted_light_is_accounted_for_to_1e_6_on_every_preset() {
    scene::PRESETS.par_iter().for_each(|(name, _)| {
        let mut loaded = bench::sensor(name);
        if let Some(press) = &mut loaded.scene.press {
            // The paper's nine phantoms differ in their inclusions; one of each series, at a small load of coarse
            // elements.
            if !["phantom-size-14mm", "phantom-depth-3mm", "phantom-stiffness-44.5kpa"].contains(name) {
                return;
            }
            (press.depths_mm, press.resolution) = (Some(vec![1.0]), 0.5);
        }
        loaded.scene.camera.pixels = [8, 8];
        let model = bench::model(&loaded);
        for mut backend in bench::backends(&model) {
            let mut batch = Batch::new(&model, &mut backend, Integrator::Path, 1);
            batch.ledger(1 << 16, &mut |_| true).unwrap();
            let ledger = batch.totals.ledger();
            assert_eq!(batch.totals.lost(), 0, "{name}");
            println!("{name} {}: {ledger:?}", batch.backend.name());
            assert!(ledger.residual.abs() <= 1e-6, "{name}: {ledger:?}");
            assert_eq!(ledger.terminated, 0.0, "{name}");
            // Its parts are shares of the light: none is negative but the roulette's, which is noise about zero.
            let parts = [ledger.absorbed, ledger.escaped_top, ledger.escaped_bottom, ledger.escaped_sides];
            assert!(parts.iter().all(|p| (0.0..=1.0).contains(p)) && ledger.roulette.abs() < 0.05, "{name}");
        }
    });
}

#[test]
fn the_camera_sees_nothing_through_the_papers_flat_stack() {
    let mut loaded = bench::sensor("tsis-paper");
    let [columns, rows] = [174, 130];
    loaded.scene.camera.pixels = [columns, rows];
    let model = bench::model(&loaded);
    for mut backend in bench::backends(&model) {
        backend.clear_film().unwrap();
        backend.camera(CameraMode::Path, 1, [0, columns * rows], [0, 16]).unwrap();
        let (film, fates) = backend.read_film().unwrap();
        assert!(film.iter().all(|&v| v == 0), "{}", backend.name());
        assert!(fates.segments > u64::from(16 * columns * rows) / 2);
    }
}

/// An edge LED in air sends this share of its light steeper than a guide of index n traps, and `entering` of it gets
/// in.
fn steep(n: f64) -> [f64; 2] {
    // Lambertian: sin^2 is uniform and so is the azimuth; steep where sin^2 cos^2(phi) > n^2 - 1.
    let bound = n * n - 1.0;
    let steps = 200_000;
    let mut sum = [0.0; 2];
    for k in 0..steps {
        let sin_sq = bound + (1.0 - bound) * (f64::from(k) + 0.5) / f64::from(steps);
        let share = (bound / sin_sq).sqrt().acos() * 2.0 / std::f64::consts::PI;
        sum[0] += share;
        sum[1] += share * (1.0 - reflectance((1.0 - sin_sq).sqrt(), 1.0, n));
    }
    sum.map(|s| s * (1.0 - bound) / f64::from(steps))
}

#[test]
fn without_its_cut_off_cone_an_edge_led_leaks_about_one_percent() {
    for (n, listed) in [(1.39, 0.008), (1.38, 0.013)] {
        let [geometric, entering] = steep(n);
        // Listed to two digits, without the reflection at the edge.
        close(&format!("steep light, {n}"), geometric, listed, 5e-4);
        let mut loaded = bench::sensor("tsis-paper");
        loaded.scene.stack.layer = bench::stack(&[[3.5, n]]).scene.stack.layer;
        // So wide that all steep light meets the faces often before it meets another wall.
        loaded.scene.stack.footprint_mm = [150.0, 150.0];
        for led in &mut loaded.scene.led {
            (led.height_mm, led.mount) = (1.75, Mount::Air { gap_mm: 0.0 });
            led.cutoff_half_angle_deg = None;
        }
        let model = bench::model(&loaded);
        for mut backend in bench::backends(&model) {
            backend.clear_photons(PhotonMode::Ledger).unwrap();
            backend.photons(PhotonMode::Ledger, 2, 1 << 14, [0, 16]).unwrap();
            let (tally, _) = backend.read_photons(PhotonMode::Ledger).unwrap();
            assert_eq!(tally[book::EMITTED], (1 << 18) * (1 << 20));
            let share = |slot: usize| tally[slot] as f64 / tally[book::EMITTED] as f64;
            let found = share(book::TOP) + share(book::BOTTOM);
            let four = 4.0 * (entering / f64::from(1 << 18)).sqrt();
            println!("{n} {}: geometric {geometric:.5}, entering {entering:.5}, found {found:.5}", backend.name());
            close("leak", found, entering, four);
        }
    }
}
