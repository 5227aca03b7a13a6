//! Error of the pressure from a second press on elements of twice the size.

use super::run::{JUDGED_SHARE, is_judged, press_once};
use super::{ContactPoint, Load, PressError, Pressed, Setup};
use crate::mechanics::newton::Method;

/// Estimated discretisation error of a press at one load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PressureError {
    /// Root mean square of the pressure's error over 0.8 of the footprint's radius, as a share of the pressure's own.
    pub rms: f64,
    /// Error of the force, as a share of it.
    pub force: f64,
}

/// Error of the finer mesh as a share of the difference of the two, 1 / (2^q - 1): order q = 2 of the pressure as the
/// elements have it, and q = 1 of all that the singular edge spoils: the force, and the pressure that it sends inwards.
/// The edge of a body bonded to a much stiffer one moves as the root of the distance (Williams, J. Appl. Mech. 19, 526,
/// 1952), so its energy converges as the size of the elements.
const LOCAL_SHARE: f64 = 1.0 / 3.0;
const EDGE_SHARE: f64 = 1.0;

/// Presses again at the depths that were reached and books the errors.
pub(super) fn estimate(
    pressed: &mut Pressed,
    method: Option<Method>,
    observe: &mut dyn FnMut(f64) -> bool,
) -> Result<(), PressError> {
    let mut coarse = pressed.setup.halved();
    if !matches!(coarse.load, Load::Path(_)) {
        coarse.load = Load::Depths(pressed.steps.iter().map(|step| step.depth_mm).collect());
    }
    let coarse = match press_once(&coarse, method, observe) {
        Ok(coarse) => coarse,
        // Without the coarser press there is no estimate, but the press stands.
        Err(PressError::Stopped { reached, .. }) => *reached,
        Err(error) => return Err(error),
    };
    for (fine, coarse) in pressed.steps.iter_mut().zip(&coarse.steps) {
        let rms = pressure_error(&pressed.setup, &fine.points, &coarse.points);
        let force = (fine.force_n - coarse.force_n).abs() / fine.force_n.abs().max(f64::MIN_POSITIVE);
        fine.error = Some(PressureError { rms, force: EDGE_SHARE * force });
    }
    Ok(())
}

/// Estimated error of the finer of two pressures, rms over the judged part, as a share of it.
///
/// What the edge sends inwards is smooth there (Saint-Venant), so the difference is split: what p (a + b r^2) follows
/// by least squares is the edge's, the rest the elements' own.
pub(super) fn pressure_error(setup: &Setup, fine: &[ContactPoint], coarse: &[ContactPoint]) -> f64 {
    let misfits = misfits(setup, fine, coarse);
    let sum = |term: &dyn Fn(&Misfit) -> f64| misfits.iter().map(|m| m.area * term(m)).sum::<f64>();
    let size = sum(&|m| m.pressure.powi(2));
    let (mixed, far) = (sum(&|m| m.pressure.powi(2) * m.place), sum(&|m| (m.pressure * m.place).powi(2)));
    let (even, odd) = (sum(&|m| m.pressure * m.difference), sum(&|m| m.pressure * m.place * m.difference));
    let determinant = size * far - mixed * mixed;
    if determinant <= f64::EPSILON * size * far {
        return 0.0;
    }
    let (a, b) = ((even * far - odd * mixed) / determinant, (odd * size - even * mixed) / determinant);
    let smooth = (a * even + b * odd) / size;
    let rest = sum(&|m| m.difference.powi(2)) / size - smooth;
    (EDGE_SHARE.powi(2) * smooth.max(0.0) + LOCAL_SHARE.powi(2) * rest.max(0.0)).sqrt()
}

/// Root mean square difference of two pressures over the judged part, as a share of that of the first.
pub fn difference(setup: &Setup, fine: &[ContactPoint], coarse: &[ContactPoint]) -> f64 {
    let misfits = misfits(setup, fine, coarse);
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
fn misfits(setup: &Setup, fine: &[ContactPoint], coarse: &[ContactPoint]) -> Vec<Misfit> {
    let judged = fine.iter().filter(|point| is_judged(setup, point));
    let misfit = |point: &ContactPoint| {
        let [x, y, _] = point.reference_mm.map(|x| x / setup.reach_mm());
        Some(Misfit {
            area: point.area_mm2,
            pressure: point.pressure_kpa,
            difference: point.pressure_kpa - pressure_at(setup, coarse, point)?,
            place: if setup.kinematics.dim() == 3 { x * x + y * y } else { x * x },
        })
    };
    judged.filter_map(misfit).collect()
}

/// Pressure of another mesh at a point: linear between its nodes in two dimensions; in three, weighted by the nearest
/// ones.
fn pressure_at(setup: &Setup, points: &[ContactPoint], at: &ContactPoint) -> Option<f64> {
    if setup.kinematics.dim() == 2 {
        let after = points.partition_point(|point| point.reference_mm[0] < at.reference_mm[0]);
        let b = points.get(after)?;
        let Some(a) = after.checked_sub(1).and_then(|k| points.get(k)) else { return Some(b.pressure_kpa) };
        let share = (at.reference_mm[0] - a.reference_mm[0]) / (b.reference_mm[0] - a.reference_mm[0]);
        return Some(a.pressure_kpa + share * (b.pressure_kpa - a.pressure_kpa));
    }
    let mut near: Vec<(f64, f64)> = points
        .iter()
        .map(|point| {
            let d = [0, 1].map(|i| point.reference_mm[i] - at.reference_mm[i]);
            (d[0].hypot(d[1]), point.pressure_kpa)
        })
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    near.truncate(NEAREST);
    if near.first()?.0 < 1e-9 * JUDGED_SHARE {
        return near.first().map(|(_, pressure)| *pressure);
    }
    let weight: f64 = near.iter().map(|(d, _)| d.powi(-2)).sum();
    Some(near.iter().map(|(d, pressure)| pressure * d.powi(-2)).sum::<f64>() / weight)
}

/// Nodes of the coarser face that a pressure in three dimensions is drawn from.
const NEAREST: usize = 4;
