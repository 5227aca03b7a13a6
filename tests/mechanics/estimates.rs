//! The errors that a press states of itself, against finer meshes and a closed form, on few and coarse meshes;
//! `benches/press_errors` does the same for many (docs/decisions/press-errors.md).

use super::answers::{hayes, phantom};
use super::layers::{Punched, one, rounded};
use tirtouch::mechanics::contact::Grip;
use tirtouch::mechanics::mesh::Resolution;
use tirtouch::mechanics::press::error_estimate::difference;
use tirtouch::mechanics::press::{Face, Load, PressSettings, Pressed, SensorBody, Setup, press};

/// Errors of force and pressure as shares, and their estimates.
struct Judged {
    what: &'static str,
    truth: [f64; 2],
    estimate: [f64; 2],
}

impl Judged {
    /// Estimated over true.
    fn ratios(&self) -> [f64; 2] {
        [0, 1].map(|k| self.estimate[k] / self.truth[k])
    }
}

fn pressed(setup: &Setup, estimate_error: bool) -> Pressed {
    press(setup, PressSettings { estimate_error, ..PressSettings::default() }, &mut |_| true).unwrap()
}

/// The shipped phantom at 1 mm, on elements of twice the default's size.
fn soft(inclusion: bool, subdivision: usize) -> Setup {
    let mut setup = phantom::setup(inclusion, subdivision);
    setup.phantom.resolution = Resolution { subdivision, ..Resolution::PLANE.finer(1.0 / subdivision as f64) };
    setup.load = Load::Depths(vec![1.0]);
    setup
}

fn rigid(subdivision: usize, grip: Grip) -> Setup {
    Setup { sensor: SensorBody::Rigid { edge_radius_mm: 0.5 }, grip, ..soft(false, subdivision) }
}

/// Against a mesh twice as fine, in which half of an error of first order does not show.
fn against_a_finer_mesh(what: &'static str, setup: &Setup) -> Judged {
    let mut finer = setup.clone();
    finer.phantom.resolution = finer.phantom.resolution.doubled();
    let pressed = pressed(setup, true);
    let [rms, force] = phantom::errors(&pressed, &self::pressed(&finer, false)).unwrap();
    let shown = if setup.grip == Grip::Bonded { 0.5 } else { 1.0 };
    let error = pressed.steps[0].error.unwrap();
    Judged { what, truth: [force.abs() / shown, rms], estimate: [error.force, error.rms] }
}

/// Against the sharp punch; the estimates of the mesh alone, and with those of the rounding.
fn against_the_sharp_punch(a_over_h: f64, poisson: f64) -> [Judged; 2] {
    let layer = one(a_over_h, poisson);
    let pressed = pressed(&rounded(&layer, Resolution::PLANE.finer(0.5)), true);
    let (step, sharp) = (&pressed.steps[0], Punched::on(&layer));
    let [own, exact] = [Face::of(&pressed, step), Face::along(&pressed.setup, sharp.face())];
    let truth = [(sharp.force_n() / step.force_n - 1.0).abs(), difference(&own, &exact)];
    let (error, what) = (step.error.unwrap(), "sharp punch");
    let rounding = error.rounding.unwrap();
    [[error.force, error.rms], [error.force + rounding.force, error.rms + rounding.rms]].map(|estimate| Judged {
        what,
        truth,
        estimate,
    })
}

#[test]
fn a_press_knows_its_error() {
    let mut judged = vec![
        against_a_finer_mesh("soft, tied, inclusion", &soft(true, 2)),
        against_a_finer_mesh("rigid, tied", &rigid(2, Grip::Bonded)),
        against_a_finer_mesh("rigid, tied, divided by 3", &rigid(3, Grip::Bonded)),
        against_a_finer_mesh("rigid, sliding", &rigid(2, Grip::Frictionless)),
    ];
    // Planted: the order of the elements for that of the singular edge, (2 - 1) / (2^2 - 1) of what it makes.
    for judged in &judged[..2] {
        assert!(judged.ratios()[0] / 3.0 < 1.0, "{}", judged.what);
    }
    for (a_over_h, poisson) in [(0.4, 0.45), (2.0, 0.5)] {
        let [mesh, both] = against_the_sharp_punch(a_over_h, poisson);
        // Planted: the rounding left out.
        assert!(mesh.ratios()[0] < 1.0, "{:?}", mesh.ratios());
        judged.push(both);
    }
    for judged in &judged {
        assert!(judged.ratios().iter().all(|&ratio| ratio >= 1.0), "{}: {:?}", judged.what, judged.ratios());
    }
    for k in 0..2 {
        let mut ratios: Vec<f64> = judged.iter().map(|judged| judged.ratios()[k]).collect();
        ratios.sort_by(f64::total_cmp);
        assert!(ratios[judged.len() / 2] < 4.0, "{ratios:?}");
    }
}

#[test]
fn the_closed_form_is_that_of_the_table() {
    for [a_over_h, compressible, incompressible] in hayes::KAPPA {
        for (poisson, kappa) in [(0.45, compressible), (0.5, incompressible)] {
            let found = Punched::on(&one(a_over_h, poisson)).kappa();
            // Half a unit of the fifth digit, and as much for the table's own rule.
            assert!((found - kappa).abs() < 1e-4, "a/h {a_over_h}, nu {poisson}: {found} for {kappa}");
        }
    }
}
