//! The press with extreme inclusions, compressibilities and places.

use super::compressibility::ELEMENTS;
use super::row::{Part, Row, Subject};
use super::{Context, StabilityError};
use crate::mechanics::contact::Grip;
use crate::mechanics::element::PressureOrder;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::material::Material;
use crate::mechanics::mesh::{Footprint, InclusionShape, MeshError, PhantomMesh, PhantomShape, Resolution, Star};
use crate::mechanics::press::{Load, PressError, PressSettings, Pressed, SensorBody, Setup, TIME_STEPS, press};
use crate::mechanics::read_out::{min_jacobian, pressure_jump};

/// Height of the phantom, mm.
pub const HEIGHT: f64 = 25.0;
/// Largest jump of the pressure between elements, as a share of its spread: a checkerboard has 2, a smooth field on
/// this mesh, singular at one edge, less than a third.
const JUMP: f64 = 0.3;
const FOLDS: &str = "a press of 1 mm folds nothing";

/// A ball in the phantom: diameter and depth of its top in mm, contrast to the phantom.
pub type Ball = (f64, f64, f64);

/// The phantom of 5 kPa on the soft sensor, tied, pressed by 1 mm.
///
/// # Errors
/// A modulus or ratio that a material cannot have.
pub fn setup(ball: Option<Ball>, poisson: f64) -> Result<Setup, StabilityError> {
    let material = |youngs: f64| Material::neo_hookean(youngs, poisson);
    let inclusion = |(diameter, depth, _): Ball| InclusionShape {
        center_mm: [0.0, 0.0, depth + 0.5 * diameter],
        surface: Star::Ellipsoid { semi_axes_mm: [0.5 * diameter; 3] },
    };
    let stack = [(5.0, 15.0), (3.0, 30.0), (2.0, 60.0)].map(|(height, youngs)| Ok((height, material(youngs)?)));
    let moduli = std::iter::once(5.0).chain(ball.map(|(.., contrast)| 5.0 * contrast));
    Ok(Setup {
        kinematics: Kinematics::Axisymmetric,
        pressure: PressureOrder::Linear,
        phantom: PhantomMesh {
            shape: PhantomShape::Cylinder { radius_mm: 30.0, height_mm: HEIGHT },
            inclusions: ball.map(inclusion).into_iter().collect(),
            footprint: Footprint::Round { radius_mm: 15.0 },
            symmetry: [true, true],
            resolution: Resolution::PLANE.halved(),
            offset_mm: [0.0; 2],
            layers_mm: Vec::new(),
        },
        phantom_materials: moduli.map(material).collect::<Result<_, _>>()?,
        sensor: SensorBody::Layers {
            layers: stack.into_iter().collect::<Result<Vec<_>, StabilityError>>()?,
            edge_radius_mm: 0.0,
        },
        grip: Grip::Bonded,
        load: Load::Depths(vec![1.0]),
        seconds_per_mm: None,
        hold_s: 0.0,
        time_steps: TIME_STEPS,
        tilt_deg: [0.0; 2],
    })
}

fn run(setup: &Setup) -> Result<Pressed, PressError> {
    press(setup, PressSettings::default(), &mut |_| true)
}

/// A press with what must hold of any.
struct Run {
    force_n: f64,
    least_jacobian: f64,
    jump: f64,
}

fn at(ball: Option<Ball>, poisson: f64) -> Result<Run, StabilityError> {
    run_of(&setup(ball, poisson)?)
}

fn run_of(setup: &Setup) -> Result<Run, StabilityError> {
    let pressed = run(setup)?;
    let step = pressed.steps.last().ok_or(StabilityError::Missing("a press without a load"))?;
    let problem = &pressed.assembly.problem;
    Ok(Run {
        force_n: step.force_n,
        least_jacobian: min_jacobian(problem, &step.state).unwrap_or(f64::NAN),
        jump: pressure_jump(problem, &step.state),
    })
}

/// All extreme presses.
///
/// # Errors
/// `Press` where a press that must come to its load does not. Those that must be refused are no error.
pub fn rows(context: &Context) -> Result<Vec<Row>, StabilityError> {
    let mut rows = Vec::new();
    towards_incompressible(context, &mut rows)?;
    contrasts(context, &mut rows)?;
    places(&mut rows)?;
    Ok(rows)
}

/// Forces rise to that of the incompressible phantom.
fn towards_incompressible(context: &Context, rows: &mut Vec<Row>) -> Result<(), StabilityError> {
    let ball = Some((8.0, 5.0, 24.0));
    let limit = at(ball, 0.5)?;
    let all = [0.49, 0.499, 0.4999, 0.499_999];
    for &poisson in if context.quick { &all[2..] } else { &all[..] } {
        let found = at(ball, poisson)?;
        let subject = Subject::new(Part::Mechanics, format!("press of an 8 mm inclusion, nu = {poisson}"), ELEMENTS);
        // The confined phantom loses a little more than 1 - 2 nu of its force.
        let allowed = 3.0 * (1.0 - 2.0 * poisson);
        let why = "3 (1 - 2 nu): linear in the compressibility";
        rows.push(subject.relative("force, N", [found.force_n, limit.force_n], "nu = 0.5 exactly", allowed, why));
        rows.push(subject.absolute("jump of the pressure", [found.jump, 0.0], "smooth", JUMP, "a checkerboard has 2"));
    }
    Ok(())
}

/// Contrast 1 equals homogeneous; extreme ones tend to limits, in the order of the contrast.
fn contrasts(context: &Context, rows: &mut Vec<Row>) -> Result<(), StabilityError> {
    let ratios: &[f64] = if context.quick { &[0.4999] } else { &[0.3, 0.4999, 0.5] };
    for &poisson in ratios {
        let subject = |contrast: f64| {
            let case = format!("press of an inclusion of contrast {contrast}, nu = {poisson}");
            Subject::new(Part::Mechanics, case, ELEMENTS)
        };
        let ball = |contrast: f64| at(Some((8.0, 5.0, contrast)), poisson);
        let same = ball(1.0)?;
        let none = at(None, poisson)?;
        let forces = [same.force_n, none.force_n];
        let why = "two meshes, each good to 4e-4 by its ladder";
        rows.push(subject(1.0).relative("force, N", forces, "no inclusion", 1e-3, why));
        for (contrast, limit) in [(1e6, 1e8), (1e-6, 1e-8)] {
            let [far, near] = [ball(contrast)?, ball(limit)?];
            let forces = [far.force_n, near.force_n];
            // The inclusion makes 3 % of the force. Of that, at 1e6, (k - 1)/(k + 2.04) is reached (3e-6 remain); at
            // 1e-6 a bulk modulus of 5,000 k E is left at nu = 0.4999, which fills a hundredth of a hole.
            let quantity = "force, N, has come to its limit";
            let reference = format!("contrast {limit}");
            rows.push(subject(contrast).relative(quantity, forces, reference, 3e-4, "a hundredth of its 3 % effect"));
            let quantity = "least J";
            let why = "no element inside out";
            rows.push(subject(contrast).above(quantity, [far.least_jacobian, 0.0], why, FOLDS));
            let ordered = (far.force_n > none.force_n) == (contrast > 1.0);
            rows.push(subject(contrast).holds("force on its side of no inclusion", ordered, "stiffer is stiffer"));
        }
    }
    Ok(())
}

/// Inclusions that touch a face are refused with their numbers; those that all but touch, or are tiny, press.
fn places(rows: &mut Vec<Row>) -> Result<(), StabilityError> {
    for (depth, face) in [(0.0, "touched face"), (-1.0, "touched face"), (HEIGHT - 8.0, "base")] {
        let refused = match run(&setup(Some((8.0, depth, 24.0)), 0.4999)?) {
            Err(PressError::Mesh(MeshError::SticksOut { face: named, .. })) => named == face,
            _ => false,
        };
        let subject = Subject::new(Part::Mechanics, format!("inclusion {depth} mm under the touched face"), ELEMENTS);
        rows.push(subject.holds(format!("refused: it meets the {face}"), refused, "impossible geometry is an error"));
    }
    let plain = at(None, 0.4999)?.force_n;
    for (ball, what) in [
        ((8.0, 0.021, 24.0), "inclusion 21 um from the touched face"),
        ((8.0, HEIGHT - 8.021, 24.0), "inclusion 21 um from the base"),
    ] {
        let found = at(Some(ball), 0.4999)?;
        let subject = Subject::new(Part::Mechanics, what, ELEMENTS);
        let why = "a stiff inclusion stiffens";
        rows.push(subject.above("force, N", [found.force_n, plain], "no inclusion", why));
        rows.push(subject.above("least J", [found.least_jacobian, 0.0], "no element inside out", FOLDS));
    }
    let tiny = at(Some((0.001, 5.0, 24.0)), 0.4999)?.force_n;
    let subject = Subject::new(Part::Mechanics, "inclusion of 1 um, below any element", ELEMENTS);
    let why = "another mesh around it; its volume is nothing";
    rows.push(subject.relative("force, N", [tiny, plain], "no inclusion", 1e-3, why));
    Ok(())
}
