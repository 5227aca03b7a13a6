//! A dent as a closed form and as triangles gives the same light.

use crate::bench;
use std::f64::consts::TAU;
use tirtouch::surface::{Cap, Mesh, Surface};
use tirtouch::trace::Model;
use tirtouch::trace::cpu::Limits;
use tirtouch::trace::cpu::camera::{FILM_UNIT, View, add};

const DENT: Cap = Cap { center_mm: [0.0; 2], depth_mm: 1.5, rim_mm: 6.0 };
const RINGS: u32 = 96;
const SECTORS: u32 = 192;

/// Mean radiances of 16 images of the dent, in the light of wide LEDs.
fn images(surface: &Surface) -> Vec<f64> {
    let mut loaded = bench::sensor("dent-cap");
    loaded.scene.led.iter_mut().for_each(|led| led.diameter_mm = 10.0);
    loaded.scene.camera.pixels = [32, 32];
    loaded.scene.camera.view_angle_deg = 28.6;
    let model = Model::new(&loaded, surface, None).unwrap().cast::<f32>();
    let image = |seed| {
        let mut film = vec![0; 32 * 32];
        add(&model, View { exitance: None, complement: false }, seed, [0, 8], 0, Limits::default(), &mut film);
        film.iter().map(|sum| *sum as f64 / FILM_UNIT).sum::<f64>() / (8.0 * film.len() as f64)
    };
    (1..=16).map(image).collect()
}

/// The dent in rings about its axis; with a crease the rim's vertices are there twice, so that no normal is a mean over
/// both sides.
fn rings(crease: bool) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let step = DENT.rim_mm / f64::from(RINGS);
    let mut radii: Vec<f64> = (0..=RINGS).map(|k| f64::from(k) * step).collect();
    radii.extend(crease.then_some(DENT.rim_mm));
    // Once more as wide, then beyond the corners of the stack.
    radii.extend([DENT.rim_mm + step, 22.0]);
    let vertex = |r: f64, k: u32| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(SECTORS)).sin_cos();
        [r * cos, r * sin, 12.0 + DENT.height_mm(r, 0.0)]
    };
    let vertices = radii.iter().flat_map(|&r| (0..SECTORS).map(move |k| vertex(r, k))).collect();
    let square = |ring: u32, k: u32| {
        let [a, b] = [ring * SECTORS + k, ring * SECTORS + (k + 1) % SECTORS];
        [[a, a + SECTORS, b + SECTORS], [a, b + SECTORS, b]]
    };
    let triangles =
        (0..radii.len() as u32 - 1).flat_map(|ring| (0..SECTORS).flat_map(move |k| square(ring, k))).collect();
    (vertices, triangles)
}

/// How much brighter the triangles, with interpolated normals, are than the closed form, and the standard error of
/// that, as shares.
fn brighter((vertices, triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>)) -> [f64; 2] {
    let exact = images(&Surface::Cap { cap: DENT, share: vec![0.0, 0.0, 0.0, 0.0, 1.0] });
    let found = images(&Surface::Mesh(Mesh::build(&vertices, &triangles, true).unwrap()));
    let count = exact.len() as f64;
    let middle = exact.iter().sum::<f64>() / count;
    let offs: Vec<f64> = exact.iter().zip(&found).map(|(a, b)| (b - a) / middle).collect();
    let mean = offs.iter().sum::<f64>() / count;
    let square = offs.iter().map(|off| (off - mean).powi(2)).sum::<f64>();
    let error = (square / (count - 1.0) / count).sqrt();
    println!("{:+.2} % with an error of {:.2} %", 100.0 * mean, 100.0 * error);
    [mean, error]
}

#[test]
fn triangles_that_follow_a_dent_give_the_light_of_its_closed_form() {
    let [off, error] = brighter(rings(true));
    assert!(error < 3e-3, "{error}");
    assert!(off.abs() < 4.0 * error, "{off} with an error of {error}");
}

#[test]
fn normals_that_blur_the_rim_and_missing_triangles_show_in_the_light() {
    let [blurred, error] = brighter(rings(false));
    assert!(blurred.abs() > 8.0 * error, "{blurred} with an error of {error}");
    let (vertices, mut triangles) = rings(true);
    let mut count = 0;
    triangles.retain(|_| {
        count += 1;
        count % 20 != 0
    });
    let [holed, error] = brighter((vertices, triangles));
    assert!(holed < -8.0 * error, "{holed} with an error of {error}");
}
