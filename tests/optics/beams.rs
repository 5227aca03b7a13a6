//! Closed forms as the camera sees them, on the GPU and the twin: narrow beams that end on glowing walls.
//!
//! Bonded LEDs larger than the walls make every wall glow with radiance 1 in its own medium, so a camera path brings
//! home the share of its light that reached a wall, over the square of the index there. The image is so wide that a
//! thousand of its pixels see one angle: their tangents differ by 2e-3 at most to either side, symmetrically, so the
//! mean over them is the value in the middle to about 1e-5.

use crate::bench::{self, Share, close};
use std::f64::consts::PI;
use tirtouch::optics::fresnel::{lambertian_mean, reflectance};
use tirtouch::scene::{Contact, ContactLaw, LoadedScene, Pressure, Tissue};
use tirtouch::trace::cpu::camera::FILM_UNIT;
use tirtouch::trace::modes::CameraMode;
use tirtouch::trace::{Backend, Model};

const PIXELS: u32 = 1024;
const SAMPLES: u32 = 1 << 13;
/// Samples of one call. Mesa's llvmpipe ends all loops of a thread after 65,535 turns together, and says nothing.
const CHUNK: u32 = 256;
const PATHS: f64 = PIXELS as f64 * SAMPLES as f64;

/// A model whose walls glow and whose camera looks at one angle; and the first of its pixels.
fn beam(loaded: &LoadedScene, angle_deg: f64) -> (Model<f64>, u32) {
    let mut model = bench::model(loaded);
    for led in &mut model.leds {
        (led.radius, led.height) = (1e4, 0.0);
    }
    let columns = 1u32 << 19;
    model.camera.size = [columns, 1];
    model.camera.distance = 0.5;
    model.camera.pixel_tan = angle_deg.to_radians().tan() / f64::from((columns - PIXELS) / 2);
    (model, columns - PIXELS)
}

/// Mean light of the beam, in units of the wall's radiance.
fn seen(backend: &mut Backend, first: u32) -> f64 {
    backend.clear_film().unwrap();
    for sample in (0..SAMPLES).step_by(CHUNK as usize) {
        backend.camera(CameraMode::Path, 9, [first, PIXELS], [sample, CHUNK]).unwrap();
    }
    let (film, _) = backend.read_film().unwrap();
    film[first as usize..].iter().map(|&v| v as f64).sum::<f64>() / FILM_UNIT / PATHS
}

/// Holds the light seen to a share of `each`, to three digits.
fn share_is(what: &str, loaded: &LoadedScene, angle_deg: f64, each: f64, share: f64) {
    let (model, first) = beam(loaded, angle_deg);
    let mut backend = bench::fastest(&model);
    let found = seen(&mut backend, first) / each;
    Share { hits: found * PATHS, of: PATHS }.is(&format!("{what}, {}", backend.name()), share, 3);
}

#[test]
fn radiance_seen_through_a_face_falls_by_its_reflectance_and_by_n_squared() {
    for n in [1.38, 1.41] {
        let deep = bench::stack(&[[1000.0, n]]);
        // At 3 degrees the mean of s and p is that at 0 to 1e-6: their squares of the angle cancel.
        let r = f64::powi((n - 1.0) / (n + 1.0), 2);
        share_is(&format!("into {n} at 3 degrees"), &deep, 3.0, 1.0 / (n * n), 1.0 - r);
    }
    share_is("into 1.41 at 60 degrees", &bench::stack(&[[40.0, 1.41]]), 60.0, 1.0 / (1.41 * 1.41), 1.0 - 0.073_755_9);
}

#[test]
fn a_slab_between_layers_of_air_transmits_all_orders() {
    let slab = bench::stack(&[[100.0, 1.0], [0.1, 1.41], [1.0, 1.0]]);
    for (angle, listed) in [(30.0, 0.941_288), (45.0, 0.926_946)] {
        share_is(&format!("slab at {angle} degrees"), &slab, angle, 1.0, listed);
    }
}

#[test]
fn light_fades_exponentially_on_its_way_to_the_wall() {
    let mut loaded = bench::stack(&[[40.0, 1.41]]);
    loaded.scene.stack.layer[0].absorption_per_mm = 0.03;
    let sin = 60f64.to_radians().sin();
    // From the entry 0.5 tan(60 degrees) off the axis to the wall at 15 mm, at the refracted angle.
    let length = (15.0 - 0.5 * 60f64.to_radians().tan()) * 1.41 / sin;
    share_is("absorbed", &loaded, 60.0, (-0.03 * length).exp() / (1.41 * 1.41), 1.0 - 0.073_755_9);
}

#[test]
fn a_ray_through_the_papers_silicone_comes_out_where_it_should() {
    // A row of pixels crosses the upper edge of an LED behind the stack; where it goes dark tells the lateral shift.
    let layers = [[2.0, 1.41], [3.0, 1.40], [5.0, 1.39]];
    let stacked: Vec<[f64; 2]> = [[40.0, 1.0]].into_iter().chain(layers).chain([[1.0, 1.0]]).collect();
    let (mut model, first) = beam(&bench::stack(&stacked), 30.0);
    let tan = 30f64.to_radians().tan();
    let shift = 3.833_178;
    // Through 0.5 mm of air to the stack and 1 mm of air in it, the silicone, and air from 11 mm to the wall at 15 mm.
    let height = 11.0 + (15.0 - 1.5 * tan - shift) / tan;
    for led in &mut model.leds {
        (led.radius, led.height) = (1.0, height - 1.0);
    }
    for mut backend in bench::backends(&model) {
        backend.clear_film().unwrap();
        backend.camera(CameraMode::Path, 9, [first, PIXELS], [0, 64]).unwrap();
        let (film, _) = backend.read_film().unwrap();
        // Larger angles arrive lower: lit ones follow dark ones. A lit pixel has 50 contributions or more.
        let lit = film[first as usize..].iter().take_while(|&&v| v == 0).count();
        assert!(film[first as usize + lit + 1..].iter().all(|&v| v > 0));
        // The middle of the 1024 pixels sees 30 degrees; a pixel of the wall's image is tan(30)/2.6e5 wide, which is
        // 22 mm / cos^2 of path times 2.2e-6, or 5e-5 mm across. f32 adds 1e-5 mm.
        close(&format!("edge, {}", backend.name()), lit as f64, 0.5 * f64::from(PIXELS), 3.0);
    }
}

/// Full contact with tissue over the whole touched face.
pub fn covered(loaded: &mut LoadedScene, n: f64, albedo: f64) {
    covered_by(loaded, Tissue { n, ..lambertian(albedo) });
}

/// Lambertian tissue.
pub fn lambertian(albedo: f64) -> Tissue {
    Tissue {
        n: 1.41,
        diffuse_reflectance: Some(albedo),
        reduced_scattering_per_mm: None,
        absorption_per_mm: None,
        spread_mm: 0.0,
    }
}

/// Tissue of reduced scattering 1 per mm.
pub fn scattering(absorption: f64) -> Tissue {
    Tissue {
        diffuse_reflectance: None,
        reduced_scattering_per_mm: Some(1.0),
        absorption_per_mm: Some(absorption),
        ..lambertian(0.0)
    }
}

/// Full contact with this tissue over the whole touched face.
pub fn covered_by(loaded: &mut LoadedScene, tissue: Tissue) {
    loaded.scene.touch.contact = Some(Contact {
        pressure: Pressure::Disc { radius_mm: 1e3, center_mm: [0.0; 2], pressure_kpa: 1.0 },
        law: ContactLaw::Full,
        tissue,
    });
}

#[test]
fn a_white_face_is_as_bright_as_the_share_of_glowing_walls_it_sees() {
    let (half, height) = (15.0, 40.0);
    let mut loaded = bench::stack(&[[height, 1.0]]);
    covered(&mut loaded, 1.0, 1.0);
    // View factor from the middle of the top to the open bottom: four corner rectangles of a x a at height h (Howell,
    // A Catalog of Radiation Heat Transfer Configuration Factors, B-3). The beam meets the top 0.07 mm off the middle.
    let a: f64 = half / height;
    let root = (1.0 + a * a).sqrt();
    let open = 4.0 / PI * (a / root) * (a / root).atan();
    share_is("white face", &loaded, 0.1, 1.0, 1.0 - open);
}

#[test]
fn light_leaves_a_body_of_1_41_by_its_external_and_internal_diffuse_reflectance() {
    let (albedo, depth) = (0.95, 100.0);
    let mut loaded = bench::stack(&[[depth, 1.0]]);
    covered(&mut loaded, 1.41, albedo);
    loaded.scene.stack.footprint_mm = [1.0, 1.0];
    let (first, internal) = (reflectance(1.0, 1.0, 1.41), 0.5364);
    close("internal", lambertian_mean(|c| reflectance(c, 1.41, 1.0)), internal, 5e-5);
    // In, out after any number of internal reflections; 1 / (pi 100^2) of it misses the walls and leaves below.
    let out = (1.0 - first) * albedo * (1.0 - internal) / (1.0 - albedo * internal);
    share_is("white body", &loaded, 1e-3, 1.0, out * (1.0 - 1.0 / (PI * depth * depth)));
}
