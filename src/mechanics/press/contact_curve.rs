//! Pressures, gaps and displacements of the touched face.

use crate::mechanics::contact::{Grip, Positions};
use crate::mechanics::problem::{Problem, State};

/// A node of the touched face.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ContactPoint {
    /// The node in the problem's mesh.
    pub node: u32,
    /// Undeformed position, mm.
    pub reference_mm: [f64; 3],
    /// Displacement, mm.
    pub displacement_mm: [f64; 3],
    /// Pressure on the deformed face, kPa; negative where a bond pulls.
    pub pressure_kpa: f64,
    /// Tangential traction on the deformed face, its size, kPa.
    pub shear_kpa: f64,
    /// Mean distance between the faces around the node, mm; 0 for bonded ones.
    pub gap_mm: f64,
    /// Force that the node's share of the face bears along z, mN, pressing positive.
    pub force_mn: f64,
    /// Area of that share, undeformed, mm^2 (mm in plane strain).
    pub area_mm2: f64,
}

/// The nodes of a contact in a state, by x (or r), then y.
pub fn contact_points(problem: &Problem, contact: usize, state: &State) -> Vec<ContactPoint> {
    let Some((contact, traction)) = problem.contacts.get(contact).zip(state.traction.get(contact)) else {
        return Vec::new();
    };
    let now = problem.positions(state);
    let at = Positions { reference: &problem.mesh.nodes, before: &now, now: &now };
    let (gaps, _) = contact.gaps(at, &vec![0.0; contact.nodes.len()]);
    let present = contact.present_areas(&now);
    let up = problem.kinematics.dim() - 1;
    let mut points: Vec<ContactPoint> = gaps
        .iter()
        .zip(traction.iter().zip(&present))
        .zip(&contact.nodes)
        .map(|((gap, (traction, present)), &node)| {
            let mean = gap.normal.map(|n| if gap.area > 0.0 { n / gap.area } else { 0.0 });
            let length = mean.iter().map(|n| n * n).sum::<f64>().sqrt();
            let normal = mean.map(|n| if length > 0.0 { n / length } else { 0.0 });
            let whole = [0, 1, 2].map(|i| traction.normal * mean[i] + traction.vector[i]);
            let pressure: f64 = (0..3).map(|i| whole[i] * normal[i]).sum();
            let shear = [0, 1, 2].map(|i| whole[i] - pressure * normal[i]);
            let stretch = if *present > 0.0 { gap.area / present } else { 1.0 };
            ContactPoint {
                node,
                reference_mm: problem.mesh.nodes[node as usize],
                displacement_mm: state.displacement[node as usize],
                pressure_kpa: pressure * stretch,
                shear_kpa: shear.iter().map(|s| s * s).sum::<f64>().sqrt() * stretch,
                gap_mm: if contact.grip == Grip::Bonded || gap.area == 0.0 { 0.0 } else { gap.gap / gap.area },
                force_mn: whole[up] * gap.area * contact.side,
                area_mm2: gap.area,
            }
        })
        .collect();
    points.sort_by(|a, b| {
        let [p, q] = [a, b].map(|point| point.reference_mm);
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
    });
    points
}
