//! The frame of a state.

use crate::mechanics::frames::Frame;
use crate::mechanics::press::ContactPoint;

/// The true pressure (force on the present length of the face) at the places of a frame. It is linear between the nodes
/// of the face where these are now.
pub(super) fn frame(points: &[ContactPoint], position_mm: f64, places_mm: &[f64]) -> Frame {
    let mut nodes: Vec<[f64; 2]> =
        points.iter().map(|point| [point.reference_mm[0] + point.displacement_mm[0], point.pressure_kpa]).collect();
    nodes.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let pressure_kpa = places_mm.iter().map(|place| pressure(&nodes, position_mm + place)).collect();
    Frame { position_mm, x_mm: places_mm.to_vec(), pressure_kpa }
}

fn pressure(nodes: &[[f64; 2]], x: f64) -> f64 {
    let after = nodes.partition_point(|node| node[0] < x);
    let (Some(b), Some(a)) = (nodes.get(after), after.checked_sub(1).and_then(|k| nodes.get(k))) else {
        return nodes.get(after).filter(|node| node[0] == x).map_or(0.0, |node| node[1]);
    };
    a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_linear_between_displaced_nodes_and_nothing_beyond_the_face() {
        let point = |x: f64, u: f64, pressure_kpa: f64| ContactPoint {
            node: 0,
            reference_mm: [x, 0.0, 0.0],
            displacement_mm: [u, -1.0, 0.0],
            pressure_kpa,
            shear_kpa: 0.0,
            gap_mm: 0.0,
            force_mn: 0.0,
            area_mm2: 1.0,
        };
        let points = [point(0.0, 1.0, 0.0), point(1.0, 1.0, 4.0), point(3.0, 0.0, 2.0)];
        let frame = frame(&points, 2.0, &[-2.0, -1.0, -0.5, 0.5, 1.0, 1.5]);
        assert_eq!(frame.pressure_kpa, [0.0, 0.0, 2.0, 3.0, 2.0, 0.0]);
        assert_eq!((frame.position_mm, frame.x_mm[2]), (2.0, -0.5));
    }
}
