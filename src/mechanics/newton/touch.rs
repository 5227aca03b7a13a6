//! What a touched node does: bonded, free, sticking or slipping.
//!
//! Contact decides by a spring as stiff as the body, and holds by one [`SPRING`](crate::mechanics::contact::SPRING)
//! times stiffer; with one for both, nodes let go at each curved step (docs/decisions/two-springs.md).

use crate::mechanics::contact::{Bending, Grip, NodeGap};
use crate::mechanics::problem::Traction;

type Tensor = [[f64; 3]; 3];

/// A contact in a state.
pub(super) struct Touching {
    pub nodes: Vec<Touch>,
    /// Stiffness from the bending of the gaps under pressure.
    pub bending: Bending,
}

/// What a touched node does in a state.
pub(super) struct Touch {
    pub gap: NodeGap,
    pub hold: Hold,
    /// Traction that the residual uses.
    pub now: Traction,
    /// Traction that the next step starts from: with the springs' share.
    pub trial: Traction,
    /// The tangent's spring, kPa per mm; 0 where free.
    pub stiff: f64,
    /// Spring against the normal gap, kPa per mm; 0 where free.
    pub spring: f64,
    /// Spring against slip (or any offset), kPa per mm; 0 where it is free.
    pub along: Tensor,
    /// Tangential traction for each kPa of pressure, where friction drags.
    pub drag: [f64; 3],
    /// What is left of the constraint, mm.
    pub defect: f64,
    pub settled: bool,
}

/// What a touched node does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hold {
    Free,
    Bonded,
    Sticks,
    Slips,
}

/// What the traction of a touched node does to the nodes that move its gap.
pub(super) fn pushes(touch: &Touch, traction: &Traction) -> Vec<(u32, [f64; 3])> {
    let push = |m: f64, n: &[f64; 3]| [0, 1, 2].map(|i| traction.normal * n[i] + traction.vector[i] * m);
    touch.gap.moved.iter().map(|(a, m, n)| (*a, push(*m, n))).collect()
}

/// Integrals of hat times normal gap and times offset that a displacement adds.
pub(super) fn moved(gap: &NodeGap, change: &[f64], dim: usize) -> (f64, [f64; 3]) {
    let (mut normal, mut offset) = (0.0, [0.0; 3]);
    for ((a, m, _), gradient) in gap.moved.iter().zip(&gap.gradient) {
        for i in 0..dim {
            let du = change[*a as usize * dim + i];
            normal += gradient[i] * du;
            offset[i] += m * du;
        }
    }
    (normal, offset)
}

/// Gap below which faces lie on each other, mm.
const CLOSED: f64 = 1e-9;

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn apply(matrix: &Tensor, v: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|j| matrix[i][j] * v[j]).sum())
}

fn scaled(matrix: &Tensor, by: f64) -> Tensor {
    matrix.map(|row| row.map(|c| by * c))
}

/// The identity less the direction of `normal`.
fn across(normal: [f64; 3]) -> Tensor {
    let square: f64 = normal.iter().map(|n| n * n).sum();
    let keep = |i: usize, j: usize| if square > 0.0 { normal[i] * normal[j] / square } else { 0.0 };
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(i == j) - keep(i, j)))
}

/// Projector on the face, along the axes that are not held.
fn open_face(normal: [f64; 3], held: [bool; 3]) -> Tensor {
    let projector = across([0, 1, 2].map(|i| if held[i] { 0.0 } else { normal[i] }));
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| if held[i] || held[j] { 0.0 } else { projector[i][j] }))
}

/// Decides what a node does: bonded, free, sticking or slipping.
///
/// Coulomb's law is a part of Newton's method (Alart and Curnier 1991; Hueeber and Wohlmuth 2005): a node slips where
/// its traction, less a body-like spring times the slip, exceeds friction times the pressure; it then bears friction
/// times the pressure *of the next state*, and in three dimensions its direction turns with the slip. Along the axes
/// that are `held`, as on a plane of symmetry, faces do not rub: neighbours would hold such a node's mean slip once
/// more. Springs: one as stiff as the body, and that of the tangent. Where a press is at its `first` iteration, faces
/// that lie on each other touch although nothing presses yet: else they would first move through each other.
pub(super) fn touch(
    grip: Grip,
    gap: NodeGap,
    now: Traction,
    [soft, spring]: [f64; 2],
    held: [bool; 3],
    first: bool,
) -> Touch {
    let free = |settled| Touch {
        gap: NodeGap::default(),
        hold: Hold::Free,
        now: Traction::default(),
        trial: Traction::default(),
        stiff: 0.0,
        spring: 0.0,
        along: [[0.0; 3]; 3],
        drag: [0.0; 3],
        defect: 0.0,
        settled,
    };
    if gap.area <= 0.0 {
        return Touch { gap, ..free(now.normal == 0.0) };
    }
    let offset = gap.offset.map(|o| o / gap.area);
    let pulled = |spring: f64| [0, 1, 2].map(|i| now.vector[i] - spring * offset[i]);
    if grip == Grip::Bonded {
        let trial = Traction { vector: pulled(spring), ..Traction::default() };
        let along = scaled(&across([0.0; 3]), spring);
        return Touch {
            gap,
            hold: Hold::Bonded,
            now,
            trial,
            stiff: spring,
            along,
            defect: length(offset),
            ..free(true)
        };
    }
    let mean = gap.gap / gap.area;
    // What decides is the soft spring: a stiffer one would let go at each curved step.
    let pressure = (now.normal - soft * mean).max(0.0);
    if pressure == 0.0 && !(first && mean < CLOSED) {
        return Touch { gap, ..free(now.normal <= 0.0) };
    }
    let touching = Touch { stiff: spring, spring, defect: mean.abs(), ..free(now.normal > 0.0) };
    let pressed = now.normal - spring * mean;
    // The gap's gradient is longer than 1 on a sloping profile, and so is the normal traction than the pressure.
    let friction = match grip {
        Grip::Coulomb(friction) => friction * length(gap.normal) / gap.area,
        Grip::Bonded | Grip::Frictionless => 0.0,
    };
    if friction == 0.0 {
        let now = Traction { normal: now.normal, ..Traction::default() };
        let trial = Traction { normal: pressed, ..now };
        return Touch { gap, hold: Hold::Slips, now, trial, ..touching };
    }
    let face = open_face(gap.normal, held);
    let (bound, pull) = (friction * pressure, apply(&face, pulled(soft)));
    let excess = length(pull) - bound;
    if excess <= 0.0 {
        let now = Traction { vector: apply(&face, now.vector), ..now };
        let trial = Traction { normal: pressed, vector: apply(&face, pulled(spring)) };
        let (defect, along) = (mean.abs().max(length(apply(&face, offset))), scaled(&face, spring));
        return Touch { gap, hold: Hold::Sticks, now, trial, along, defect, ..touching };
    }
    let direction = pull.map(|c| c / length(pull));
    let drag = direction.map(|c| friction * c);
    // Slip across the traction turns it.
    let beside = across(direction);
    let turn = (soft * bound / excess).min(spring);
    let entry = |i: usize, j: usize| turn * (0..3).map(|k| face[i][k] * beside[k][j]).sum::<f64>();
    let along = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
    let aside = apply(&along, offset);
    let slipping = |pressure: f64| drag.map(|c| c * pressure);
    let lag = length([0, 1, 2].map(|i| slipping(now.normal)[i] - now.vector[i]));
    let settled = touching.settled && lag <= 1e-6 * bound;
    let vector = slipping(pressed);
    let trial = Traction { normal: pressed, vector: [0, 1, 2].map(|i| vector[i] - aside[i]) };
    let now = Traction { normal: now.normal, vector: slipping(now.normal) };
    Touch { gap, hold: Hold::Slips, now, trial, along, drag, settled, ..touching }
}

impl Touch {
    /// Whether its nodes are joined in the tangent: it holds them, or lets go of a pressure that bends the gap.
    pub fn bears(&self) -> bool {
        self.hold != Hold::Free || !self.settled
    }

    /// Whether the matrix has not all of what the node does.
    pub fn is_odd(&self) -> bool {
        let turned = || self.gap.moved.iter().zip(&self.gap.gradient).any(|((_, _, n), gradient)| n != gradient);
        let rubs = self.drag != [0.0; 3] || !self.gap.turning.is_empty();
        self.hold != Hold::Free && (rubs || self.spring > 0.0 && turned())
    }

    /// Change of the traction with a motion beyond that in the matrix: friction follows the pressure and the face as it
    /// turns, and the gap's gradient is not quite the normal.
    pub fn odd_answer(&self, change: &[f64], dim: usize) -> Traction {
        let normal = self.answer(change, dim).normal;
        let along: f64 = self
            .gap
            .moved
            .iter()
            .map(|(a, _, n)| (0..dim).map(|i| n[i] * change[*a as usize * dim + i]).sum::<f64>())
            .sum();
        let turned = self.turned(change, dim);
        let vector = [0, 1, 2].map(|i| self.drag[i] * normal + turned[i]);
        Traction { normal: normal + self.spring * along / self.gap.area, vector }
    }

    /// Change of the tangential traction as the face turns: it stays in the face, and where it slips it grows as the
    /// normal does, for friction is of the pressure on the face itself.
    fn turned(&self, change: &[f64], dim: usize) -> [f64; 3] {
        let mut by = [0.0; 3];
        for ((b, ..), turning) in self.gap.moved.iter().zip(&self.gap.turning) {
            for i in 0..dim {
                by[i] += (0..dim).map(|j| turning[i][j] * change[*b as usize * dim + j]).sum::<f64>();
            }
        }
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (n, t) = (self.gap.normal, self.now.vector);
        let (square, stretch) = (dot(n, n), dot(n, by));
        if square == 0.0 {
            return [0.0; 3];
        }
        let lean = (dot(t, by) - dot(t, n) * stretch / square) / square;
        let growth = if self.hold == Hold::Slips { stretch / square } else { 0.0 };
        [0, 1, 2].map(|i| growth * t[i] - lean * n[i])
    }

    /// The part of a vector that a bonded or sticking node's spring is against.
    pub fn along_face(&self, v: [f64; 3]) -> [f64; 3] {
        apply(&self.along, v).map(|c| c / self.stiff)
    }

    /// The traction, and its change in a full Newton step.
    pub fn step(&self, change: &[f64], dim: usize) -> [Traction; 2] {
        let next = self.stepped(change, dim);
        let vector = [0, 1, 2].map(|i| next.vector[i] - self.now.vector[i]);
        [self.now, Traction { normal: next.normal - self.now.normal, vector }]
    }

    /// Traction after a full Newton step.
    pub fn stepped(&self, change: &[f64], dim: usize) -> Traction {
        let mut next = self.trial;
        let answer = self.answer(change, dim);
        next.normal += answer.normal;
        (0..3).for_each(|i| next.vector[i] += answer.vector[i]);
        next
    }

    /// Change of the traction with a motion.
    pub fn answer(&self, change: &[f64], dim: usize) -> Traction {
        if self.hold == Hold::Free {
            return Traction::default();
        }
        let (gap, offset) = moved(&self.gap, change, dim);
        let normal = -self.spring * gap / self.gap.area;
        let along = apply(&self.along, offset);
        let vector = [0, 1, 2].map(|i| self.drag[i] * normal - along[i] / self.gap.area);
        Traction { normal, vector }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Traction of a node that rubs on a slope, by differences as the slope changes and as the tangent has it.
    #[test]
    fn friction_turns_with_the_face() {
        let (slope, curvature, step) = (0.7, 3.0, 1e-6);
        let at = |slope: f64| NodeGap {
            area: 2.0,
            normal: [2.0 * slope, 2.0, 0.0],
            moved: vec![(0, 2.0, [0.0; 3])],
            gradient: vec![[0.0; 3]],
            turning: vec![[[2.0 * curvature, 0.0, 0.0], [0.0; 3], [0.0; 3]]],
            ..NodeGap::default()
        };
        for (pull, hold) in [(0.4, Hold::Sticks), (5.0, Hold::Slips)] {
            let now = Traction { normal: 3.0, vector: [pull, -pull * slope, 0.0] };
            let here = |slope: f64| touch(Grip::Coulomb(0.3), at(slope), now, [1.0, 10.0], [false, false, true], false);
            let (touched, beside) = (here(slope), here(slope + curvature * step));
            assert_eq!((touched.hold, beside.hold), (hold, hold));
            let foretold = touched.odd_answer(&[step, 0.0], 2).vector;
            for i in 0..2 {
                let change = beside.now.vector[i] - touched.now.vector[i];
                assert!((foretold[i] - change).abs() < 1e-5 * step, "{hold:?} {i}: {} {change}", foretold[i]);
            }
            assert!(length(foretold) > 0.1 * step);
        }
    }
}
