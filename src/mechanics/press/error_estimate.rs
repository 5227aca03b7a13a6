//! Error of a press, from a second one on a coarser mesh, and from a third by a rounder edge.

use super::face::Face;
use super::pressed::{Pressed, PressureError, Rounding};
use super::ready::Ready;
use super::{ContactPoint, Load, PressError, SensorBody, Setup};
use crate::mechanics::contact::Profile;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::newton::LinearSolver;

/// Orders of convergence. Of the pressure as the elements have it, and of all that the singular edge spoils: the force,
/// and the pressure that it sends inwards. The edge of a body bonded to a much stiffer one moves as the root of the
/// distance (Williams, J. Appl. Mech. 19, 526, 1952), so its energy converges as the size of the elements.
const LOCAL_ORDER: f64 = 2.0;
const EDGE_ORDER: f64 = 1.0;

/// Factor of safety on what two meshes say, between Roache's 3 for two meshes and 1.25 where a third shows the order
/// (J. Fluids Eng. 116, 405, 1994): the orders are known here, but not that the meshes are fine enough to show them.
/// docs/decisions/press-errors.md has what other factors hold.
pub const SAFETY: f64 = 2.0;

/// Parts of an error by the order in which they converge.
struct Shares {
    local: f64,
    edge: f64,
}

impl Shares {
    /// Of the difference of two meshes, what is taken for the error of the finer: safety / (ratio^order - 1), where
    /// `ratio` is how many times as large the coarser's elements are. Nothing for meshes that do not differ in size.
    fn of(pressed: &Pressed, coarse: &Pressed) -> Option<Self> {
        let elements = |pressed: &Pressed| pressed.assembly.problem.mesh.element_count() as f64;
        let ratio = (elements(pressed) / elements(coarse)).powf(1.0 / pressed.setup.kinematics.dim() as f64);
        let share = |order: f64| SAFETY / (ratio.powf(order) - 1.0);
        let local = share(if bends(&pressed.setup) { EDGE_ORDER } else { LOCAL_ORDER });
        (ratio > 1.0).then(|| Self { local, edge: share(EDGE_ORDER) })
    }
}

/// Whether what presses is given by points: where such a profile bends, the pressure is singular as the logarithm of
/// the distance.
fn bends(setup: &Setup) -> bool {
    matches!(setup.sensor, SensorBody::Indenter(Profile::Table(_)))
}

/// Force below which a press bears nothing, as a share of the largest.
pub const NOTHING: f64 = 1e-6;

/// Presses again at the depths that were reached, unless `coarse` is such a press, and books the errors.
pub(super) fn estimate(
    pressed: &mut Pressed,
    coarse: Option<Pressed>,
    method: Option<LinearSolver>,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<(), PressError> {
    let rounder = pressed.setup.coarsened().twice_rounded();
    let parts = if rounder.is_some() { 2.0 } else { 1.0 };
    let coarse = match coarse {
        Some(coarse) => coarse,
        None => again(pressed, pressed.setup.coarsened(), method, &mut |done| observe(done / parts))?,
    };
    let rounder = match rounder {
        Some(setup) => Some(again(pressed, setup, method, &mut |done| observe((1.0 + done) / parts))?),
        None => None,
    };
    let Some(shares) = Shares::of(pressed, &coarse) else { return Ok(()) };
    // Of what is lifted off again, no share is known.
    let least = NOTHING * pressed.steps.iter().map(|step| step.force_n.abs()).fold(0.0, f64::max);
    let by_order = [shares.local, shares.edge];
    let errors: Vec<_> = pressed
        .steps
        .iter()
        .zip(&coarse.steps)
        .enumerate()
        .map(|(k, (step, other))| {
            if step.force_n.abs() < least {
                return None;
            }
            let [own, others] = [(&*pressed, step), (&coarse, other)].map(|(pressed, step)| Face::of(pressed, step));
            let rounding = rounder.as_ref().and_then(|rounder| Some((rounder, rounder.steps.get(k)?)));
            let rounding = rounding.map(|(rounder, step)| Rounding {
                rms: SAFETY * difference(&others, &Face::of(rounder, step)),
                force: SAFETY * share_of(other.force_n - step.force_n, other.force_n),
            });
            let peak = (!bends(&pressed.setup)).then(|| peak_error(&own, &others, by_order) + own.stands_out());
            // The force is of second order in the pressure's error: where that is large, two forces agree by chance.
            let least = peak.filter(|_| !own.has_edge()).map_or(0.0, |peak| peak.powi(2));
            let force = (shares.edge * share_of(step.force_n - other.force_n, step.force_n))
                .max(end_of_contact(&pressed.setup, &step.points))
                .max(least);
            let rms = pressure_error(&own, &others, by_order);
            Some(PressureError { rms, peak, force, rounding })
        })
        .collect();
    pressed.steps.iter_mut().zip(errors).for_each(|(step, error)| step.error = error);
    Ok(())
}

/// Another press to the depths that were reached, or as many of them as it reaches: without it there is no estimate,
/// but the press stands.
fn again(
    pressed: &Pressed,
    mut setup: Setup,
    method: Option<LinearSolver>,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<Pressed, PressError> {
    if !matches!(setup.load, Load::Path(_)) {
        setup.load = Load::Depths(pressed.steps.iter().map(|step| step.depth_mm).collect());
    }
    Ready::new(&setup, method)?.press_as_far(Some(pressed), observe)
}

/// What the force under an indenter may be off for its contact ends between two nodes, as a share of it. Two meshes may
/// agree by chance where few nodes bear.
fn end_of_contact(setup: &Setup, points: &[ContactPoint]) -> f64 {
    if !matches!(setup.sensor, SensorBody::Indenter(_)) {
        return 0.0;
    }
    // The distance of nodes over the contact's radius, squared.
    let bearing = points.iter().filter(|point| point.pressure_kpa > 0.0).count().max(1) as f64;
    let share = match setup.kinematics {
        Kinematics::ThreeDimensional => std::f64::consts::PI / (setup.copies() * bearing),
        Kinematics::Axisymmetric | Kinematics::PlaneStrain => bearing.powi(-2),
    };
    ENDS_BETWEEN * share
}

/// Error of a force for a contact as wide as the distance of nodes: balls and cones were off by 0.03 to 0.14.
const ENDS_BETWEEN: f64 = 0.15;

/// Size of a part of a whole.
fn share_of(part: f64, whole: f64) -> f64 {
    part.abs() / whole.abs().max(f64::MIN_POSITIVE)
}

/// Estimated error of the finer of two pressures, rms over the judged part, as a share of it.
///
/// What the edge sends inwards is smooth there (Saint-Venant), so the difference is split: what p (a + b r^2) follows
/// by least squares is the edge's, the rest the elements' own. Each counts by its share of the difference.
pub(super) fn pressure_error(fine: &Face, coarse: &Face, [local, edge]: [f64; 2]) -> f64 {
    let misfits = misfits(fine, coarse);
    let sum = |term: &dyn Fn(&Misfit) -> f64| misfits.iter().map(|m| m.area * term(m)).sum::<f64>();
    let size = sum(&|m| m.pressure.powi(2));
    if size == 0.0 {
        return 0.0;
    }
    let whole = sum(&|m| m.difference.powi(2)) / size;
    let Some(from_edge) = sent_by_edge(&misfits) else { return edge * whole.sqrt() };
    let smooth = sum(&|m| m.pressure * from_edge(m.place) * m.difference) / size;
    let rest = whole - smooth;
    (edge.powi(2) * smooth.max(0.0) + local.powi(2) * rest.max(0.0)).sqrt()
}

/// Estimated error of the peak of the finer of two pressures, as a share of it: that of the pressure where either has
/// its peak, split as that of the whole. Under a sensor it is no less than that of the whole: at one place two meshes
/// may agree by chance, their difference being zero somewhere. Under an indenter the whole has the end of the contact.
pub(super) fn peak_error(fine: &Face, coarse: &Face, [local, edge]: [f64; 2]) -> f64 {
    let (Some((here, peak)), Some((there, _))) = (fine.peak(), coarse.peak()) else {
        return 0.0;
    };
    let from_edge = sent_by_edge(&misfits(fine, coarse));
    let error = |at: [f64; 3]| {
        let pressure = fine.pressure_at(at)?;
        let difference = pressure - coarse.pressure_at(at)?;
        let smooth = from_edge.as_ref().map_or(difference, |share| pressure * share(fine.place(at)));
        Some((edge * smooth).hypot(local * (difference - smooth)) / peak)
    };
    let least = if fine.has_edge() { pressure_error(fine, coarse, [local, edge]) } else { 0.0 };
    if peak > 0.0 { [here, there].into_iter().filter_map(error).fold(least, f64::max) } else { 0.0 }
}

/// What the edge sends inwards, as a share of the pressure at a place: a + b r^2. Nothing where too few points tell.
fn sent_by_edge(misfits: &[Misfit]) -> Option<impl Fn(f64) -> f64 + use<>> {
    let sum = |term: &dyn Fn(&Misfit) -> f64| misfits.iter().map(|m| m.area * term(m)).sum::<f64>();
    let size = sum(&|m| m.pressure.powi(2));
    let (mixed, far) = (sum(&|m| m.pressure.powi(2) * m.place), sum(&|m| (m.pressure * m.place).powi(2)));
    let (even, odd) = (sum(&|m| m.pressure * m.difference), sum(&|m| m.pressure * m.place * m.difference));
    let determinant = size * far - mixed * mixed;
    let (a, b) = ((even * far - odd * mixed) / determinant, (odd * size - even * mixed) / determinant);
    (determinant > f64::EPSILON * size * far).then_some(move |place: f64| a + b * place)
}

/// Root mean square difference of two pressures over the judged part, as a share of that of the first.
pub fn difference(fine: &Face, coarse: &Face) -> f64 {
    let misfits = misfits(fine, coarse);
    let sum = |term: &dyn Fn(&Misfit) -> f64| misfits.iter().map(|m| m.area * term(m)).sum::<f64>();
    let size = sum(&|m| m.pressure.powi(2));
    if size == 0.0 { 0.0 } else { (sum(&|m| m.difference.powi(2)) / size).sqrt() }
}

/// Two pressures at one point.
struct Misfit {
    area: f64,
    /// The first, kPa.
    pressure: f64,
    /// The first less the second, kPa.
    difference: f64,
    /// Squared distance from the axis, in reaches of the footprint.
    place: f64,
}

/// The judged points of the first face.
fn misfits(fine: &Face, coarse: &Face) -> Vec<Misfit> {
    let misfit = |point: &ContactPoint| {
        Some(Misfit {
            area: point.area_mm2,
            pressure: point.pressure_kpa,
            difference: point.pressure_kpa - coarse.pressure_at(point.reference_mm)?,
            place: fine.place(point.reference_mm),
        })
    };
    fine.judged().filter_map(misfit).collect()
}
