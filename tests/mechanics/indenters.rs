//! Rigid indenters in place of the sensor: by closed forms, by the flat sensor, and in three dimensions by two.

use super::answers::graded;
use tirtouch::mechanics::contact::{Grip, Profile};
use tirtouch::mechanics::element::PressureOrder;
use tirtouch::mechanics::kinematics::Kinematics;
use tirtouch::mechanics::material::Material;
use tirtouch::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, Resolution};
use tirtouch::mechanics::press::{
    ContactPoint, Load, Pose, PressSettings, PressStep, SensorBody, Setup, TIME_STEPS, press,
};

/// A linear body of E = 1 kPa about the axis, under an indenter without friction.
fn setup(size_mm: [f64; 2], poisson: f64, profile: Profile, footprint_mm: f64, resolution: Resolution) -> Setup {
    let [radius_mm, height_mm] = size_mm;
    Setup {
        kinematics: Kinematics::Axisymmetric,
        pressure: PressureOrder::Linear,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm, height_mm },
            inclusions: Vec::new(),
            footprint: Footprint::Round { radius_mm: footprint_mm },
            symmetry: [true; 2],
            resolution,
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        },
        phantom_materials: vec![Material::linear(1.0, poisson).unwrap()],
        sensor: SensorBody::Indenter(profile),
        grip: Grip::Frictionless,
        load: Load::Depths(vec![1.0]),
        seconds_per_mm: None,
        hold_s: 0.0,
        time_steps: TIME_STEPS,
        tilt_deg: [0.0; 2],
    }
}

fn steps(setup: &Setup, estimate_error: bool) -> Vec<PressStep> {
    press(setup, PressSettings { estimate_error, ..PressSettings::default() }, &mut |_| true).unwrap().steps
}

/// A half space: a base at this distance stiffens by about 0.8 a over it, 0.07 %.
const FAR: f64 = 1200.0;
/// How steep the profile is where the contact, of 1 mm, ends: closed forms leave out its square.
const SLOPE: f64 = 0.0025;

/// A half space of Poisson's ratio 0.5 with twice as few elements in the contact as a scene's press has.
fn half_space(profile: Profile, footprint_mm: f64, depth_mm: f64) -> PressStep {
    let size = footprint_mm / 6.0;
    let body = setup([FAR; 2], 0.5, profile, footprint_mm, graded(size, size, 0.4 * FAR, 0.5, 1));
    steps(&Setup { load: Load::Depths(vec![depth_mm]), ..body }, true).remove(0)
}

/// E* of the half space, kPa.
const PLANE_KPA: f64 = 1.0 / 0.75;

#[test]
fn a_ball_presses_as_hertz_says_within_what_is_estimated() {
    let depth = SLOPE;
    let step = half_space(Profile::Round { radius_mm: 1.0 / SLOPE }, 2f64.sqrt(), depth);
    let hertz = |radius_mm: f64| {
        let contact = (radius_mm * depth).sqrt();
        [4e-3 / 3.0 * PLANE_KPA * contact * depth, 2.0 / std::f64::consts::PI * PLANE_KPA * contact / radius_mm]
    };
    let off = |radius_mm: f64| {
        let [force_n, peak_kpa] = hertz(radius_mm);
        [(step.force_n / force_n - 1.0).abs(), (step.peak_pressure_kpa / peak_kpa - 1.0).abs()]
    };
    let ([force, peak], error) = (off(1.0 / SLOPE), step.error.unwrap());
    println!("force off by {force:.1e} of {:.1e}, peak by {peak:.1e} of {:.1e} rms", error.force, error.rms);
    assert!(force < 5e-3 && peak < 5e-3, "{force} {peak}");
    assert!(force < error.force && error.force < 0.05 && error.rounding.is_none(), "{force} {error:?}");
    assert!(error.peak.is_some_and(|estimate| peak < estimate && estimate < error.rms), "{peak} {error:?}");
    // A ball a tenth larger would be noticed.
    assert!(off(1.1 / SLOPE).iter().all(|off| *off > 0.04));
}

/// F = (2 / pi) E* w^2 tan(alpha), alpha the angle between axis and face (Sneddon, Int. J. Eng. Sci. 3, 47, 1965): of a
/// face that falls by `slope` a mm, tan(alpha) = 1 / slope. The contact's radius is 2 w tan(alpha) / pi.
#[test]
fn a_cone_from_a_table_presses_as_sneddon_says() {
    let depth = std::f64::consts::FRAC_PI_2 * SLOPE;
    let step = half_space(Profile::Table(vec![[0.0, 0.0], [1.0, SLOPE]]), std::f64::consts::FRAC_PI_2, depth);
    let force_n = |tan: f64| 2e-3 / std::f64::consts::PI * PLANE_KPA * depth * depth * tan;
    let (off, error) = (step.force_n / force_n(1.0 / SLOPE) - 1.0, step.error.unwrap());
    println!("force off by {off:.1e} of {:.1e}", error.force);
    assert!(off.abs() < 5e-3 && off.abs() < error.force && error.force < 0.1, "{off} {error:?}");
    assert!((step.force_n / force_n(0.95 / SLOPE) - 1.0).abs() > 0.03);
    assert_eq!(error.peak, None, "a tip's pressure has no limit");
}

#[test]
fn a_flat_indenter_is_the_flat_sensor_with_its_edge() {
    let press = |sensor: SensorBody| {
        let resolution = Resolution { subdivision: 1, ..Resolution::PLANE };
        let setup = setup([20.0, 10.0], 0.45, Profile::Flat, 6.0, resolution);
        steps(&Setup { sensor, load: Load::Depths(vec![0.3]), ..setup }, false).remove(0)
    };
    let indenter = |edge_radius_mm: f64| {
        let flat_mm = 6.0 - edge_radius_mm;
        press(SensorBody::Indenter(Profile::RoundedFlat { flat_mm, edge_radius_mm }))
    };
    let (flat, same, rounder) = (press(SensorBody::Rigid { edge_radius_mm: 1.0 }), indenter(1.0), indenter(1.1));
    // To the rounding of sums over a face that reaches farther.
    assert!((same.force_n / flat.force_n - 1.0).abs() < 1e-12, "{} {}", same.force_n, flat.force_n);
    let pressure = |step: &PressStep, node: u32| {
        step.points.iter().find(|point| point.node == node).map(|point| point.pressure_kpa).unwrap()
    };
    let off = |point: &ContactPoint| (point.pressure_kpa - pressure(&same, point.node)).abs() / flat.peak_pressure_kpa;
    assert!(flat.points.iter().map(off).fold(0.0, f64::max) < 1e-9);
    assert!((rounder.force_n / flat.force_n - 1.0).abs() > 1e-3, "{} {}", rounder.force_n, flat.force_n);
}

/// Where the pressure acts on the undeformed face along x, mm.
fn middle(step: &PressStep) -> f64 {
    let sum = |of: fn(&ContactPoint) -> f64| step.points.iter().map(of).sum::<f64>();
    sum(|p| p.force_mn * p.reference_mm[0]) / sum(|p| p.force_mn)
}

/// A layer of 3 mm, whose side 7 mm away is not felt, under a ball of 6 mm.
fn layer(resolution: Resolution) -> Setup {
    setup([11.0, 3.0], 0.49, Profile::Round { radius_mm: 6.0 }, 2.2, resolution)
}

/// Force by axisymmetry, N.
fn round_force_n(depth_mm: f64) -> f64 {
    let flat = Setup { load: Load::Depths(vec![depth_mm]), ..layer(graded(0.3, 0.3, 1.5, 0.5, 1)) };
    steps(&flat, false)[0].force_n
}

/// The layer in three dimensions, one half of it. Nodes of pressure are 0.37 mm apart, in a contact of 1.7 mm.
fn solid() -> Setup {
    let mut solid = layer(graded(0.75, 0.75, 3.0, 1.0, 1));
    (solid.kinematics, solid.phantom.symmetry) = (Kinematics::ThreeDimensional, [false, true]);
    solid
}

#[test]
fn a_ball_off_the_middle_presses_as_in_it_and_slides_without_force() {
    let exact = round_force_n(0.4);
    let slide = 0.7;
    let pose = |depth_mm: f64, x: f64| Pose { depth_mm, slide_mm: [x, 0.0], hold_s: 0.0 };
    let mut solid = solid();
    solid.phantom.offset_mm = [2.0, 0.0];
    solid.load = Load::Path(vec![pose(0.4, 0.0), pose(0.4, slide)]);
    let [pressed, slid] = &steps(&solid, false)[..] else { panic!("two steps") };
    let off = [pressed, slid].map(|step| step.force_n / exact - 1.0);
    let places = [pressed, slid].map(middle);
    println!("forces off by {off:.5?}, at {places:.3?} mm");
    assert!(off.iter().all(|off| off.abs() < 0.01), "{off:?}");
    // The phantom slides: what touches lies as far behind. A slide that is forgotten would leave it in the middle.
    assert!(places[0].abs() < 0.02 && (places[1] + slide).abs() < 0.05, "{places:?}");
    assert!(round_force_n(0.41) / exact - 1.0 > 0.02, "a hundredth of a mm would be noticed");
}

#[test]
fn a_ball_meets_a_tilted_layer_beside_its_tip() {
    let tilt = 10.0f64;
    let cosine = tilt.to_radians().cos();
    let tilted = Setup { tilt_deg: [0.0, tilt], load: Load::Depths(vec![0.4]), ..solid() };
    let step = steps(&tilted, false).remove(0);
    // Across the layer the depth is smaller, and so is the force's part along the axis.
    let exact = cosine * round_force_n(0.4 * cosine);
    println!("force off by {:.1e}, at {:.3} mm", step.force_n / exact - 1.0, middle(&step));
    assert!((step.force_n / exact - 1.0).abs() < 0.015, "{} {exact}", step.force_n);
    // Touched first at R sin(tilt), towards the side that goes down; along the layer the ball goes back.
    let place = (6.0 - 0.4 * cosine) * tilt.to_radians().sin();
    assert!((middle(&step) - place).abs() < 0.06, "{} {place}", middle(&step));
}
