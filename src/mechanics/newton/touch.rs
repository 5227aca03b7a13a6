//! What a touched node does: bonded, free, sticking or slipping.

use crate::mechanics::contact::{Coupling, Grip, NodeGap, SPRING};
use crate::mechanics::problem::Traction;

/// A contact in a state.
pub(super) struct Touching {
    pub nodes: Vec<Touch>,
    /// Stiffness from the bending of the gaps under pressure.
    pub stiffness: Vec<Coupling>,
}

/// What a touched node does in a state.
pub(super) struct Touch {
    pub gap: NodeGap,
    /// Traction that the residual uses.
    pub now: Traction,
    /// Traction that the next step starts from: with the spring's share.
    pub trial: Traction,
    /// Spring against the normal gap and against slip (or any offset), kPa per mm; 0 where free.
    pub spring: [f64; 2],
    /// What is left of the constraint, mm.
    pub defect: f64,
    pub settled: bool,
}

/// What the traction of a touched node does to the nodes that move its gap.
pub(super) fn pushes(touch: &Touch, traction: &Traction) -> Vec<(u32, [f64; 3])> {
    let push = |m: f64, n: &[f64; 3]| [0, 1, 2].map(|i| traction.normal * n[i] + traction.vector[i] * m);
    touch.gap.moved.iter().map(|(a, m, n)| (*a, push(*m, n))).collect()
}

/// Integrals of hat times normal gap and times offset that a displacement adds.
pub(super) fn moved(gap: &NodeGap, change: &[f64], dim: usize) -> (f64, [f64; 3]) {
    let (mut normal, mut offset) = (0.0, [0.0; 3]);
    for (a, m, n) in &gap.moved {
        for i in 0..dim {
            let du = change[*a as usize * dim + i];
            normal += n[i] * du;
            offset[i] += m * du;
        }
    }
    (normal, offset)
}

/// Projector on the face where slip is tangential; the identity for bonded faces.
pub(super) fn tangential(gap: &NodeGap, unilateral: bool) -> [[f64; 3]; 3] {
    let square: f64 = gap.normal.iter().map(|n| n * n).sum();
    let keep =
        |i: usize, j: usize| if unilateral && square > 0.0 { gap.normal[i] * gap.normal[j] / square } else { 0.0 };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(i == j) - keep(i, j)))
}

/// Decides what a node does: bonded, free, sticking or slipping.
pub(super) fn touch(grip: Grip, gap: NodeGap, now: Traction, spring: f64) -> Touch {
    if gap.area <= 0.0 {
        let free = Traction::default();
        return Touch { gap, now: free, trial: free, spring: [0.0; 2], defect: 0.0, settled: now.normal == 0.0 };
    }
    let offset = gap.offset.map(|o| o / gap.area);
    let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let pulled = [0, 1, 2].map(|i| now.vector[i] - spring * offset[i]);
    if grip == Grip::Bonded {
        let trial = Traction { vector: pulled, ..Traction::default() };
        return Touch { gap, now, trial, spring: [0.0, spring], defect: length(offset), settled: true };
    }
    let mean = gap.gap / gap.area;
    let pressed = now.normal - spring * mean;
    // What decides is a spring as stiff as the body: a stiffer one would let go at each curved step.
    if now.normal - spring / SPRING * mean <= 0.0 {
        let free = Traction { bound: now.bound, ..Traction::default() };
        return Touch { gap, now: free, trial: free, spring: [0.0; 2], defect: 0.0, settled: now.normal <= 0.0 };
    }
    let settled = now.normal > 0.0;
    let bound = now.bound;
    if bound == 0.0 {
        let now = Traction { normal: now.normal, ..Traction::default() };
        let trial = Traction { normal: pressed, ..now };
        return Touch { gap, now, trial, spring: [spring, 0.0], defect: mean.abs(), settled };
    }
    let soft = [0, 1, 2].map(|i| now.vector[i] - spring / SPRING * offset[i]);
    let pull = length(soft);
    if pull <= bound {
        let trial = Traction { normal: pressed, vector: pulled, bound };
        let defect = mean.abs().max(length(offset));
        return Touch { gap, now, trial, spring: [spring, spring], defect, settled };
    }
    let slipping = soft.map(|c| c * bound / pull);
    let lag = length([0, 1, 2].map(|i| slipping[i] - now.vector[i]));
    let settled = settled && lag <= 1e-6 * bound;
    let now = Traction { normal: now.normal, vector: slipping, bound };
    let trial = Traction { normal: pressed, ..now };
    Touch { gap, now, trial, spring: [spring, 0.0], defect: mean.abs(), settled }
}

impl Touch {
    /// Traction after a full Newton step.
    pub fn stepped(&self, change: &[f64], dim: usize) -> Traction {
        let (gap, offset) = moved(&self.gap, change, dim);
        let [normal, along] = self.spring.map(|s| if self.gap.area > 0.0 { s / self.gap.area } else { 0.0 });
        let projector = tangential(&self.gap, self.spring[0] > 0.0);
        let mut next = self.trial;
        next.normal -= normal * gap;
        for i in 0..dim {
            next.vector[i] -= along * (0..dim).map(|j| projector[i][j] * offset[j]).sum::<f64>();
        }
        next
    }
}
