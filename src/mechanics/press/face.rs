//! Pressures over the touched face: which of them are judged, what lies between nodes, the peak.

use super::{ContactPoint, SensorBody, Setup};

/// Share of the footprint's radius over which pressures are judged.
pub const JUDGED_SHARE: f64 = 0.8;

/// Whether a point lies within the part of the face over which pressures are judged: an indenter has no singular edge,
/// so all of its contact is.
pub fn is_judged(setup: &Setup, point: &ContactPoint) -> bool {
    if matches!(setup.sensor, SensorBody::Indenter(_)) {
        return true;
    }
    let [x, y, _] = point.reference_mm;
    let across = if setup.kinematics.dim() == 3 { x.hypot(y) } else { x.abs() };
    across <= JUDGED_SHARE * setup.reach_mm()
}

/// Place of the largest pressure over the judged part, mm, and that pressure, kPa; nothing where no node is judged.
///
/// Towards a singular edge the pressure rises up to the end of that part, which seldom is a node: in two dimensions the
/// end counts as one. Another mesh would have another last node, and the peak would leap by what lies between.
pub fn peak(setup: &Setup, points: &[ContactPoint]) -> Option<([f64; 3], f64)> {
    let judged = points.iter().filter(|point| is_judged(setup, point));
    let nodes = judged.map(|point| (point.reference_mm, point.pressure_kpa));
    let end = [JUDGED_SHARE * setup.reach_mm(), 0.0, 0.0];
    let has_end = setup.kinematics.dim() == 2 && !matches!(setup.sensor, SensorBody::Indenter(_));
    let at_end = if has_end { pressure_at(setup, points, end).map(|pressure| (end, pressure)) } else { None };
    nodes.chain(at_end).max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Pressure at a place of the undeformed face, kPa: linear between its nodes in two dimensions; in three, weighted by
/// the nearest ones. Nothing beyond the face.
pub fn pressure_at(setup: &Setup, points: &[ContactPoint], at: [f64; 3]) -> Option<f64> {
    if setup.kinematics.dim() == 2 {
        let after = points.partition_point(|point| point.reference_mm[0] < at[0]);
        let b = points.get(after)?;
        let Some(a) = after.checked_sub(1).and_then(|k| points.get(k)) else { return Some(b.pressure_kpa) };
        let share = (at[0] - a.reference_mm[0]) / (b.reference_mm[0] - a.reference_mm[0]);
        return Some(a.pressure_kpa + share * (b.pressure_kpa - a.pressure_kpa));
    }
    let mut near: Vec<(f64, f64)> = points
        .iter()
        .map(|point| {
            let d = [0, 1].map(|i| point.reference_mm[i] - at[i]);
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

/// Nodes of the face that a pressure in three dimensions is drawn from.
const NEAREST: usize = 4;
