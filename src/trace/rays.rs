//! A few photons followed point by point through the vertical section y = 0, for pictures.
//!
//! The f64 twin traces them. They start in the section, from LEDs at the x walls, and only tissue, roughness and
//! deformations that are not even in y take them out of it.

use super::cpu::vec3::V3;
use super::cpu::{End, Limits, Path};
use super::model::Model;

/// Most launches tried: enough for LEDs of which one launch in thousands lies near the section.
const LAUNCHES: u32 = 200_000;
/// Sine of the angle to the section within which a launch is turned into it.
const NEAR: f64 = 0.05;
/// Length of the last piece outside the stack, mm.
const OUTSIDE_MM: f64 = 4.0;
/// Most points of one ray: a picture cannot show more.
const POINTS: usize = 64;

/// One photon from its LED to its end.
#[derive(Debug, Clone, PartialEq)]
pub struct Ray {
    /// Its points, mm, with a short piece outside where it left the stack.
    pub points_mm: Vec<[f64; 3]>,
    /// How it ended.
    pub end: End,
    /// Entered tissue at least once.
    pub touched: bool,
}

/// Follows up to `count` photons launched in the section y = 0; fewer where the LEDs send few that way.
pub fn sample_rays(model: &Model<f64>, count: usize, seed: u32) -> Vec<Ray> {
    let mut rays = Vec::new();
    for sample in 0..LAUNCHES {
        if rays.len() >= count {
            break;
        }
        let mut path = Path::new(model, Limits::default());
        path.events = Some(Vec::new());
        path.trail = Some(Vec::new());
        path.start_random(seed, 0, sample);
        let launched = path.launch();
        if launched == End::GoesOn && turn_into_section(&mut path) {
            let end = path.follow(launched);
            rays.extend(finished(path, end));
        }
    }
    rays
}

/// Puts a photon that starts near the section into it; false where it does not.
fn turn_into_section(path: &mut Path<f64>) -> bool {
    let index = path.p.dot(path.p).sqrt();
    let near_disc = path.model.leds.iter().any(|led| led.wall == path.wall && led.along.abs() < led.radius);
    let half_disc = path.model.leds.iter().map(|led| led.radius).fold(0.0, f64::max) * 0.5;
    if path.wall > 1 || !near_disc || path.o.y.abs() > half_disc || path.p.y.abs() > NEAR * index {
        return false;
    }
    let lengthened = index / path.p.x.hypot(path.p.z);
    path.p = V3 { x: path.p.x * lengthened, y: 0.0, z: path.p.z * lengthened };
    path.o.y = 0.0;
    path.trail = Some(vec![path.o]);
    true
}

/// The ray of a followed path; none where it got lost.
fn finished(path: Path<f64>, end: End) -> Option<Ray> {
    let mut points_mm: Vec<[f64; 3]> = path.trail.iter().flatten().map(|o| [o.x, o.y, o.z]).collect();
    // A path that has entered tissue has drawn whether it lives on (codes 512 and 513 of the event record).
    let touched = path.events.iter().flatten().any(|event| matches!(event.code, 512 | 513));
    let cut = points_mm.len() > POINTS;
    points_mm.truncate(POINTS);
    if let (false, End::Top | End::Bottom | End::Sides, Some(&[x, y, z])) = (cut, end, points_mm.last()) {
        let reach = OUTSIDE_MM / path.p.dot(path.p).sqrt();
        points_mm.push([x + path.p.x * reach, y + path.p.y * reach, z + path.p.z * reach]);
    }
    (end != End::Lost && points_mm.len() > 1).then_some(Ray { points_mm, end, touched })
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

/// Share of true contact in the section y = 0 at evenly spaced places: points (x in mm, share); 0 where there is no tissue.
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
    use crate::scene::preset;
    use crate::surface::{contact_map, surface};

    fn model(name: &str) -> Model<f64> {
        let loaded = preset(name).unwrap();
        Model::new(&loaded, &surface(&loaded).unwrap(), contact_map(&loaded).unwrap()).unwrap()
    }

    #[test]
    fn a_flat_stack_guides_every_ray_from_wall_to_wall() {
        let rays = sample_rays(&model("tsis-paper"), 20, 3);
        assert_eq!(rays.len(), 20);
        for ray in &rays {
            assert_eq!((ray.end, ray.touched), (End::Sides, false));
            assert_eq!(ray.points_mm[0][0].abs(), 15.0);
            assert!(ray.points_mm.iter().all(|p| p[1] == 0.0 && (0.0..=12.0).contains(&p[2]) || p[0].abs() > 15.0));
        }
    }

    #[test]
    fn pieces_inside_a_layer_keep_the_horizontal_momentum() {
        // Between the plane faces of one layer a ray runs at one slope up and down; Snell's law holds from layer to layer.
        let model = model("tsis-paper");
        let ray = &sample_rays(&model, 1, 5)[0];
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
        let touched = sample_rays(&model("contact-disc"), 300, 1).iter().filter(|ray| ray.touched).count();
        assert!((10..290).contains(&touched), "{touched}");
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
