//! A few photons followed point by point through the vertical section y = 0, for pictures.
//!
//! The f64 twin traces them. They start in the section, from LEDs at the x walls, and only tissue, roughness and
//! deformations that are not even in y take them out of it.

use super::cpu::vec3::V3;
use super::cpu::{End, Limits, Path};
use super::leds::Led;
use super::model::Model;

/// Most launches tried: enough for LEDs of which one launch in thousands lies near the section.
const LAUNCHES: u32 = 200_000;
/// Sine of the angle to the section within which a launch is turned into it.
const NEAR: f64 = 0.05;
/// Length of the last piece outside the stack, over half its width: below there is the camera, beside it are names.
const BELOW: f64 = 0.3;
const BESIDE: f64 = 0.11;
/// Most points of one ray: a picture cannot show more.
const POINTS: usize = 40;

/// One photon from its LED to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Ray {
    /// Its points, mm, with a short piece outside where it left the stack.
    pub points_mm: Vec<[f64; 3]>,
    /// How it ended.
    pub end: End,
    /// Where it entered tissue first, mm; none where it never did.
    pub touched_mm: Option<[f64; 3]>,
}

impl Ray {
    /// Whether its end is in the picture: not at a wall along the section, not inside, and drawn to the last.
    pub fn ends_in_section(&self, model: &Model<f64>) -> bool {
        let beside = self.points_mm.last().is_some_and(|p| p[0].abs() >= model.half_size[0] * (1.0 - 1e-9));
        let left = matches!(self.end, End::Top | End::Bottom);
        self.points_mm.len() < POINTS && (left || beside && matches!(self.end, End::Sides | End::Wall))
    }
}

/// The LEDs at the x walls that the section cuts, each with half of the chord that it cuts, mm.
pub fn leds_in_section(model: &Model<f64>) -> Vec<(&Led<f64>, f64)> {
    let half_chord = |led: &Led<f64>| (led.radius.powi(2) - led.along.powi(2)).sqrt();
    let cut = |led: &&Led<f64>| led.wall.axis() == 0 && led.along.abs() < led.radius;
    model.leds.iter().filter(cut).map(|led| (led, half_chord(led))).collect()
}

/// Follows up to `count` photons launched in the section y = 0; fewer where the LEDs send few that way.
pub fn sample_rays(model: &Model<f64>, count: usize, seed: u32) -> Vec<Ray> {
    let mut rays = Vec::new();
    if leds_in_section(model).is_empty() {
        return rays;
    }
    for sample in 0..LAUNCHES {
        if rays.len() >= count {
            break;
        }
        let mut path = Path::new(model, Limits::whole());
        path.trail = Some(Vec::new());
        path.start_random(seed, sample, 0);
        let launched = path.launch();
        if launched == End::GoesOn && turn_into_section(&mut path) {
            rays.extend(follow(path));
        }
    }
    rays
}

/// Puts a photon that starts near the section into it; false where it does not.
fn turn_into_section(path: &mut Path<f64>) -> bool {
    let index = path.p.dot(path.p).sqrt();
    // Moved into the section it must still start on an LED.
    let on_led = leds_in_section(path.model)
        .iter()
        .any(|(led, half_chord)| led.wall == path.wall && (path.o.z - led.height).abs() <= *half_chord);
    let half_disc = path.model.leds.iter().map(|led| led.radius).fold(0.0, f64::max) * 0.5;
    if !on_led || path.o.y.abs() > half_disc || path.p.y.abs() > NEAR * index {
        return false;
    }
    let lengthened = index / path.p.x.hypot(path.p.z);
    path.p = V3 { x: path.p.x * lengthened, y: 0.0, z: path.p.z * lengthened };
    path.o.y = 0.0;
    path.trail = Some(vec![path.o]);
    true
}

/// Follows a launched photon to its end; none where it gets lost.
fn follow(mut path: Path<f64>) -> Option<Ray> {
    let mut touched_mm = None;
    let end = loop {
        let mut end = path.walk();
        if end == End::Touch {
            let place = [path.o.x, path.o.y, path.o.z];
            path.events = Some(Vec::new());
            end = path.photon_touch();
            // Light that enters draws at once whether the tissue returns it (codes 512 and 513 of the event record).
            let entered = path.events.take().iter().flatten().any(|event| matches!(event.code, 512 | 513));
            touched_mm = touched_mm.or(entered.then_some(place));
        }
        if end != End::GoesOn {
            break end;
        }
    };
    let mut points_mm: Vec<[f64; 3]> = path.trail.iter().flatten().map(|o| [o.x, o.y, o.z]).collect();
    points_mm.truncate(POINTS);
    if let (true, End::Top | End::Bottom | End::Sides, Some(&[x, y, z])) =
        (points_mm.len() < POINTS, end, points_mm.last())
    {
        let length = path.model.half_size[0] * if end == End::Bottom { BELOW } else { BESIDE };
        let reach = length / path.p.dot(path.p).sqrt();
        points_mm.push([x + path.p.x * reach, y + path.p.y * reach, z + path.p.z * reach]);
    }
    (end != End::Lost && points_mm.len() > 1).then_some(Ray { points_mm, end, touched_mm })
}

/// Heights of every interface, lowest first, in the section y = 0 at evenly spaced places: points (x, z), mm.
pub fn interface_profiles(model: &Model<f64>, places: usize) -> Vec<Vec<[f64; 2]>> {
    let mut path = Path::new(model, Limits::default());
    let xs = section(model, places);
    (0..model.faces.len())
        .map(|i| match model.faces[i] {
            face if face.share == 0.0 => [-1.0, 1.0].map(|side| [side * model.half_size[0], face.z]).to_vec(),
            _ => xs.iter().map(|&x| [x, path.surface_height(i, x, 0.0)]).collect(),
        })
        .collect()
}

/// Share of true contact in the section y = 0 at evenly spaced places: points (x in mm, share); 0 where there is no
/// tissue.
pub fn contact_profile(model: &Model<f64>, places: usize) -> Vec<[f64; 2]> {
    let path = Path::new(model, Limits::default());
    let share = |x| if path.tissue_here(x, 0.0) { path.contact_share(x, 0.0) } else { 0.0 };
    section(model, places).into_iter().map(|x| [x, share(x)]).collect()
}

fn section(model: &Model<f64>, places: usize) -> Vec<f64> {
    let last = places.saturating_sub(1).max(1) as f64;
    (0..places).map(|i| (2.0 * i as f64 / last - 1.0) * model.half_size[0]).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{LoadedScene, Wall, preset};
    use crate::surface::{contact_map, surface};

    fn model(name: &str) -> Model<f64> {
        let loaded = preset(name).unwrap();
        Model::new(&loaded, &surface(&loaded).unwrap(), contact_map(&loaded).unwrap()).unwrap()
    }

    #[test]
    fn a_flat_stack_guides_every_ray_from_wall_to_wall() {
        let model = model("tsis-paper");
        let rays = sample_rays(&model, 20, 3);
        assert_eq!(rays.len(), 20);
        for ray in &rays {
            assert_eq!((ray.end, ray.touched_mm), (End::Sides, None));
            assert!(ray.ends_in_section(&model));
            assert_eq!(ray.points_mm[0][0].abs(), 15.0);
            assert!(ray.points_mm.iter().all(|p| p[1] == 0.0 && (0.0..=12.0).contains(&p[2]) || p[0].abs() > 15.0));
        }
    }

    #[test]
    fn rays_start_on_the_leds_that_the_section_cuts() {
        let mut loaded = preset("tsis-paper").unwrap();
        // Along y: one in the section off its middle, one beside it, at either wall, and all others away.
        let leds = &mut loaded.scene.led;
        leds.truncate(2);
        for (led, along_mm) in leds.iter_mut().zip([1.2, 2.0]) {
            (led.wall, led.along_mm, led.diameter_mm) = (Wall::PlusX, along_mm, 3.0);
        }
        let flat = |loaded: &LoadedScene| Model::new(loaded, &surface(loaded).unwrap(), None).unwrap();
        let cut: Model<f64> = flat(&loaded);
        let leds = leds_in_section(&cut);
        assert_eq!(leds.len(), 1, "the other's edge is 0.5 mm away");
        // A chord 1.2 mm off the centre of a disc of radius 1.5 mm: 0.9 mm each way.
        let (led, half_chord) = leds[0];
        assert!((half_chord - 0.9).abs() < 1e-12 && led.along == 1.2);
        let rays = sample_rays(&cut, 30, 1);
        assert!(!rays.is_empty());
        for ray in &rays {
            let [x, y, z] = ray.points_mm[0];
            assert!(x > 0.0 && y == 0.0 && (z - led.height).abs() <= half_chord, "{x} {y} {z}");
        }
        loaded.scene.led.remove(0);
        let beside = flat(&loaded);
        assert!(leds_in_section(&beside).is_empty() && sample_rays(&beside, 5, 1).is_empty());
    }

    #[test]
    fn pieces_inside_a_layer_keep_the_horizontal_momentum() {
        // Between the plane faces of one layer a ray runs at one slope up and down; Snell's law holds from layer to
        // layer.
        let model = model("tsis-paper");
        let rays = sample_rays(&model, 20, 5);
        let ray = rays.iter().max_by_key(|ray| ray.points_mm.len()).unwrap();
        let momenta: Vec<f64> = ray.points_mm[..ray.points_mm.len() - 1]
            .windows(2)
            .map(|piece| {
                let (dx, dz) = (piece[1][0] - piece[0][0], piece[1][2] - piece[0][2]);
                let middle = 0.5 * (piece[0][2] + piece[1][2]);
                let layer = model.faces.iter().filter(|face| face.z < middle).count();
                model.layers[layer].n * dx.abs() / dx.hypot(dz)
            })
            .collect();
        // Coordinates of some 10 mm over pieces of some millimetres: differences keep 12 digits.
        assert!(momenta.len() > 2 && momenta.iter().all(|s| (s - momenta[0]).abs() < 1e-10), "{momenta:?}");
    }

    #[test]
    fn contact_scatters_rays_and_a_dent_lets_them_out() {
        let rays = sample_rays(&model("contact-disc"), 300, 1);
        let touched: Vec<[f64; 3]> = rays.iter().filter_map(|ray| ray.touched_mm).collect();
        assert!((10..290).contains(&touched.len()), "{}", touched.len());
        assert!(touched.iter().all(|[x, y, z]| x.hypot(*y) <= 4.0 && *z == 12.0));
        let dented = sample_rays(&model("tsis-dent"), 100, 1);
        assert!(dented.iter().any(|ray| matches!(ray.end, End::Bottom | End::Top)));
        assert!(dented.iter().flat_map(|ray| &ray.points_mm).flatten().all(|v| v.abs() < 40.0));
    }

    #[test]
    fn profiles_show_the_dent_and_the_contact() {
        let heights = interface_profiles(&model("tsis-dent"), 101);
        // The cap is 5 mm deep on the axis; the interface at 7 mm carries (7 - 2) / (12 - 2) of it.
        assert!((heights[4][50][1] - 7.0).abs() < 1e-12 && (heights[2][50][1] - 4.5).abs() < 1e-12);
        assert_eq!(heights[0], [[-15.0, 0.0], [15.0, 0.0]]);
        let shares = contact_profile(&model("contact-disc"), 301);
        assert!(shares.iter().all(|&[x, share]| share == f64::from(u8::from(x.abs() <= 4.0))));
    }
}
