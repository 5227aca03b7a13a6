use super::*;
use crate::mechanics::contact::{Grip, Profile};
use crate::mechanics::frames::{Features, Frame, Reference, Settings, features};
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, PhantomMesh, PhantomShape, Resolution};
use crate::mechanics::press::element_stress;
use crate::scene::{Elastic, Interface, LoadedScan, scan_preset};
use std::f64::consts::PI;

/// Elements four times those of the preset: half a percent of pressure becomes two or three.
const COARSE: Resolution = Resolution {
    edge_mm: 1.4,
    ring_share: 1.0,
    contact_mm: 1.4,
    coarsest_mm: 8.0,
    growth: 0.6,
    rim_mm: 0.0,
    rim_divisions: 1.0,
    inclusion_divisions: 3.0,
    subdivision: 1,
};

const PLAIN: ScanSettings = ScanSettings { shown_mm: 0.0, estimate_error: false };

/// The preset with other positions.
fn scene(from: f64, to: f64, count: u32) -> LoadedScan {
    let mut loaded = scan_preset("frames-galea").unwrap();
    loaded.scene.scan.positions_mm = crate::scene::Positions { from, to, count };
    loaded
}

fn coarse(loaded: &LoadedScan) -> ScanSetup {
    let mut setup = ScanSetup::from_scene(loaded).unwrap();
    setup.tissue.resolution = COARSE;
    setup
}

fn run(setup: &ScanSetup) -> Scanned {
    scan(setup, PLAIN, &|_| true).unwrap()
}

fn read(scanned: &Scanned) -> Vec<Features> {
    let settings = Settings { window_mm: Some(10.0), ..Settings::default() };
    features(&scanned.frames, Reference::Without(&scanned.without), &settings).unwrap()
}

/// Largest difference of two lists of frames, kPa.
fn apart(a: &[Frame], b: &[Frame]) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a.pressure_kpa.iter().zip(&b.pressure_kpa));
    pairs.map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
}

#[test]
fn one_factorisation_gives_the_frames_of_the_whole_system() {
    let mut setup = coarse(&scene(-10.0, 2.5, 2));
    // Both solve the same equations, whatever the mesh.
    setup.tissue.resolution = COARSE.finer(0.5);
    let fast = run(&setup);
    // Coulomb friction without friction is the same contact, solved whole.
    let whole = run(&ScanSetup { grip: Grip::Coulomb(0.0), ..setup.clone() });
    assert!(fast.one_factorisation && !whole.one_factorisation);
    // Both stop at gaps of 1e-8 mm and forces of 1e-9 of their size.
    assert!(apart(fast.frames.as_slice(), whole.frames.as_slice()) < 1e-6);
    assert!(apart(fast.without.as_slice(), whole.without.as_slice()) < 1e-6);
    for (a, b) in fast.force_n_per_mm.iter().zip(&whole.force_n_per_mm) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
    let deeper = run(&ScanSetup { depth_mm: setup.depth_mm + 1e-3, ..setup });
    assert!(apart(fast.frames.as_slice(), deeper.frames.as_slice()) > 1e-4, "the comparison can fail");
}

#[test]
fn frames_mirror_and_eccentricity_is_odd() {
    let scanned = run(&coarse(&scene(-12.0, 12.0, 5)));
    let (frames, read) = (scanned.frames.as_slice(), read(&scanned));
    for (a, b) in frames.iter().zip(frames.iter().rev()) {
        for (p, q) in a.pressure_kpa.iter().zip(b.pressure_kpa.iter().rev()) {
            // The mesh mirrors to rounding, the solver stops at 1e-9 mm.
            assert!((p - q).abs() < 1e-6, "{p} {q} at {}", a.position_mm);
        }
    }
    let lean: Vec<f64> = read.iter().map(|f| f.eccentricity.value().unwrap()).collect();
    for (a, b) in lean.iter().zip(lean.iter().rev()) {
        assert!((a + b).abs() < 1e-5, "{lean:?}");
    }
    // Left of the inclusion it lies to the right.
    assert!(lean[0] > 0.3 && lean[1] > 0.3 && lean[2].abs() < 1e-5, "{lean:?}");
}

/// A prototype of this scan with other elements gave: peak 5.5 to 8.9 kPa, width 23 to 16 mm, base falling over the
/// inclusion, after base and width rise on the approach.
#[test]
fn over_the_inclusion_frames_are_higher_and_narrower_and_on_the_approach_wider() {
    let scanned = run(&coarse(&scene(-20.0, 0.0, 3)));
    let value = |feature: &crate::figure::Figure| feature.value().unwrap();
    let [far, near, over] = &read(&scanned)[..] else { panic!("three positions") };
    let within = |name: &str, feature: &crate::figure::Figure, expected: f64, share: f64| {
        let value = value(feature);
        assert!((value / expected - 1.0).abs() < share, "{name}: {value}, expected {expected}");
    };
    within("far peak", &far.peak_kpa, 5.5, 0.05);
    within("peak over the inclusion", &over.peak_kpa, 8.9, 0.05);
    // Width depends on the window, which the prototype did not keep.
    within("far width", &far.fwhm_mm, 23.0, 0.1);
    within("width over the inclusion", &over.fwhm_mm, 16.0, 0.1);
    let (base, width) = (|f: &Features| value(&f.base_kpa), |f: &Features| value(&f.fwhm_mm));
    assert!(base(over) < 0.9 * base(far) && base(near) > 1.1 * base(far));
    assert!(width(near) > 1.1 * width(far));
}

#[test]
fn an_inclusion_of_the_tissues_material_changes_nothing() {
    let mut loaded = scene(-8.0, 0.0, 2);
    loaded.scene.phantom.inclusion[0].material = loaded.scene.phantom.material.clone();
    let scanned = run(&coarse(&loaded));
    // Two solutions of one problem, each to 1e-9 mm.
    assert!(apart(scanned.frames.as_slice(), scanned.without.as_slice()) < 1e-6);
    assert!(read(&scanned).iter().all(|f| f.eccentricity.value() == Some(0.0)));
}

/// Line contact of a cylinder: p0^2 = P E*/(pi R) and a^2 = 4 P R/(pi E*), whatever the far field (Johnson 1985, 4.2).
#[test]
fn a_cylinder_on_a_thick_block_follows_hertz() {
    let (radius_mm, youngs_kpa, poisson) = (20.0, 5.0, 0.4999);
    let half = 1.8;
    let setup = ScanSetup {
        tissue: PhantomMesh {
            shape: PhantomShape::Block { size_mm: [200.0, 200.0], height_mm: 100.0 },
            inclusions: Vec::new(),
            footprint: Footprint::Rectangle { half_widths_mm: [half; 2] },
            symmetry: [false; 2],
            resolution: Resolution { edge_mm: 0.1, contact_mm: 0.1, coarsest_mm: 30.0, growth: 0.5, ..COARSE },
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        },
        materials: vec![Material::linear(youngs_kpa, poisson).unwrap()],
        indenter: Profile::Round { radius_mm },
        grip: Grip::Frictionless,
        depth_mm: 0.14,
        positions_mm: vec![0.0],
        places_mm: (-180..=180).map(|k| half * f64::from(k) / 180.0).collect(),
    };
    let scanned = run(&setup);
    let modulus = youngs_kpa / (1.0 - poisson * poisson);
    let force = 1e3 * scanned.force_n_per_mm[0];
    let highest = (force * modulus / (PI * radius_mm)).sqrt();
    let width = (4.0 * force * radius_mm / (PI * modulus)).sqrt();
    let frame = &scanned.frames.as_slice()[0];
    let middle = frame.pressure_kpa[180];
    // Half an element of a tenth of the contact.
    assert!((middle / highest - 1.0).abs() < 0.005, "{middle} {highest}");
    let touching = scanned.shown.points.iter().filter(|point| point.pressure_kpa > 0.0);
    let reach = touching.map(|point| point.reference_mm[0] + point.displacement_mm[0]).fold(0.0, f64::max);
    assert!((reach - width).abs() < 0.1, "the contact ends within one element: {reach} {width}");
    assert!(width > 0.8 && width < 1.4, "a contact small beside block and indenter: {width}");
    // The profile is an ellipse: p / p0 = sqrt(1 - x^2 / a^2).
    for (x, p) in frame.x_mm.iter().zip(&frame.pressure_kpa).filter(|(x, _)| x.abs() < 0.8 * width) {
        let exact = highest * (1.0 - x * x / (width * width)).sqrt();
        assert!((p / exact - 1.0).abs() < 0.02, "{x}: {p} {exact}");
    }
    // Below its middle (Johnson 1985, 4.46), with what Hertz leaves out: the pressure p acts along the normal of the
    // curved face, so a share s/R of it pushes sideways, away from the middle (2.22), 5 % of p0 here.
    let Shown { problem, state, points, .. } = &scanned.shown;
    let sideways = |depth: f64, power: i32| {
        let step = width / 2000.0;
        let one = |k: u32| {
            let s = (f64::from(k) + 0.5) * step;
            let pressure = highest * (1.0 - s * s / (width * width)).sqrt();
            4.0 / PI * pressure * s / radius_mm * s.powi(power) * depth.powi(3 - power) / s.hypot(depth).powi(4) * step
        };
        (0..2000).map(one).sum::<f64>()
    };
    let mut checked = 0;
    for (e, found) in element_stress(problem, state).iter().enumerate() {
        let nodes: Vec<_> = problem.mesh.element(e).iter().map(|&a| problem.mesh.nodes[a as usize]).collect();
        let middle = |axis: usize| nodes.iter().map(|node| node[axis]).sum::<f64>() / nodes.len() as f64;
        let (x, depth) = (middle(0), (middle(1) - points[0].reference_mm[1]).abs());
        if x.abs() > 0.06 || depth > 1.0 {
            continue;
        }
        let far = width.hypot(depth);
        let across =
            -highest / width * ((width * width + 2.0 * depth * depth) / far - 2.0 * depth) + sideways(depth, 3);
        let down = -highest * width / far + sideways(depth, 1);
        for (axis, exact) in [across, down, poisson * (across + down)].into_iter().enumerate() {
            assert!((found[axis][axis] - exact).abs() < 0.01 * highest, "{depth} {axis}: {found:?} {exact}");
        }
        checked += 1;
    }
    assert_eq!(checked, 8);
}

#[test]
fn nonlinear_tissue_is_solved_position_by_position() {
    let mut loaded = scene(-10.0, 0.0, 2);
    let law = |youngs_kpa| Elastic::NeoHookean { youngs_kpa, poisson: 0.4999, relaxation: Vec::new() };
    loaded.scene.phantom.material = law(12.8);
    loaded.scene.phantom.inclusion[0].material = law(128.0);
    loaded.scene.scan.depth_mm = 3.0;
    let setup = coarse(&loaded);
    let scanned = scan(&setup, ScanSettings { shown_mm: -9.0, estimate_error: true }, &|_| true).unwrap();
    assert!(!scanned.one_factorisation && scanned.iterations > 4);
    assert_eq!(scanned.shown.position_mm, -10.0);
    let error = scanned.error.unwrap();
    assert!(error.position_mm == -10.0 && error.rms > 0.0 && error.rms < 0.2, "{error:?}");
    let highest = |k: usize| scanned.frames.as_slice()[k].pressure_kpa.iter().copied().fold(0.0, f64::max);
    assert!(highest(1) > highest(0));
}

#[test]
fn a_position_that_fails_is_named_and_a_stop_is_no_failure() {
    let mut loaded = scene(-8.0, 0.0, 2);
    loaded.scene.phantom.inclusion.clear();
    loaded.scene.phantom.material = Elastic::NeoHookean { youngs_kpa: 5.0, poisson: 0.4999, relaxation: Vec::new() };
    let mut setup = coarse(&loaded);
    setup.tissue.resolution = Resolution { edge_mm: 6.0, contact_mm: 6.0, coarsest_mm: 20.0, ..COARSE };
    let stopped = scan(&setup, PLAIN, &|_| false).unwrap_err();
    assert!(matches!(stopped, ScanError::Stopped));
    // Deeper than the tissue is high, by so much that its steps, shares of the depth, are soon too short.
    setup.depth_mm = 1e4;
    let said = scan(&setup, PLAIN, &|_| true).unwrap_err().to_string();
    assert!(said.starts_with("the indenter at ") && said.contains(" mm, ") && said.contains("stops at"), "{said}");
}

#[test]
fn friction_arrives() {
    let mut loaded = scene(-8.0, 0.0, 2);
    loaded.scene.scan.interface = Interface::Coulomb { friction: 0.3 };
    assert_eq!(ScanSetup::from_scene(&loaded).unwrap().grip, Grip::Coulomb(0.3));
}
