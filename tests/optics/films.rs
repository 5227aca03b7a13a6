//! Methods that share no light find the same image: paths from the camera, photons splatted, photons in a map.

use crate::bench;
use tirtouch::film::{self, Film};
use tirtouch::scene::{Integrator, LoadedScene, Pattern, Roughness};
use tirtouch::trace::{Model, Precision, Settings, render};

/// Chance of a false alarm, over all levels of blocks together: as four standard errors.
const LEVEL: f64 = 6.334e-5;

fn film(model: &Model<f64>, integrator: Integrator, spp: u32, seed: u32) -> Film {
    let settings = Settings {
        integrator,
        spp,
        photons: Some(1 << 21),
        seconds: None,
        target_error: None,
        seed,
        backend: bench::fastest(),
        precision: Precision::F32,
    };
    let outcome = render(model, &settings, &mut |_| true).unwrap();
    println!(
        "{integrator:?}: {:.2} s, mean {:.6e}, error {:?}",
        outcome.seconds, outcome.mean_radiance, outcome.relative_error
    );
    outcome.film
}

fn agree(a: &Film, b: &Film) -> bool {
    let c = film::compare(a, b, LEVEL).unwrap();
    println!("ratio {:?}, {:?}", c.ratio, c.tests.iter().map(|t| (t.edge, t.cells, t.p_value)).collect::<Vec<_>>());
    c.passed
}

/// The film with every radiance changed by 2 %.
fn brighter(film: &Film) -> Film {
    let by = |values: &mut Vec<f32>, k: f32| values.iter_mut().for_each(|v| *v *= k);
    let mut out = film.clone();
    by(&mut out.mean, 1.02);
    by(&mut out.variance, 1.02 * 1.02);
    for block in &mut out.blocks {
        by(&mut block.mean, 1.02);
        by(&mut block.variance, 1.02 * 1.02);
    }
    out
}

fn small(preset: &str) -> LoadedScene {
    let mut loaded = bench::sensor(preset);
    let camera = &mut loaded.scene.camera;
    camera.pixel_pitch_um *= f64::from(camera.pixels[0]) / 96.0;
    camera.pixels = [96, 72];
    loaded
}
