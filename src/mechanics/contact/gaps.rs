//! The constraints of a contact at some state.

use super::meeting::{Meeting, Surface, along_face};
use super::project::{OtherFace, subtract};
use super::{Bending, Contact, Counterpart, Coupling, Grip, NodeGap};
use rayon::prelude::*;
use std::collections::HashMap;

/// How a node moves a gap: weight, weight times normal, gradient, turning of the normal.
type Mover = (f64, [f64; 3], [f64; 3], [[f64; 3]; 3]);

/// Positions that a contact is judged by.
#[derive(Clone, Copy)]
pub struct Positions<'a> {
    /// Undeformed, mm.
    pub reference: &'a [[f64; 3]],
    /// At the end of the last load step, mm.
    pub before: &'a [[f64; 3]],
    /// Now, mm.
    pub now: &'a [[f64; 3]],
}

impl Contact {
    /// The constraints of all touched nodes, and the stiffness that the pressures `pressure` get from the bending of
    /// the gaps.
    pub fn gaps(&self, at: Positions, pressure: &[f64]) -> (Vec<NodeGap>, Bending) {
        if self.grip == Grip::Bonded {
            return (self.bonds(at), Bending::default());
        }
        self.meetings(at, pressure)
    }

    /// The constraints of bonded nodes: pairs and weights are those of the undeformed faces and are found once.
    fn bonds(&self, at: Positions) -> Vec<NodeGap> {
        let rest = Positions { before: at.reference, now: at.reference, ..at };
        let mut gaps = self.bonds.get_or_init(|| self.meetings(rest, &vec![0.0; self.nodes.len()]).0).clone();
        for gap in &mut gaps {
            for (a, weight, _) in &gap.moved {
                let [x, u] = [at.reference[*a as usize], at.now[*a as usize]];
                (0..3).for_each(|i| gap.offset[i] += weight * (u[i] - x[i]));
            }
        }
        gaps
    }

    /// Where the faces meet now, and what comes of it.
    fn meetings(&self, at: Positions, pressure: &[f64]) -> (Vec<NodeGap>, Bending) {
        let faces: Vec<Vec<[f64; 3]>> = match &self.counterpart {
            Counterpart::Face(facets) => {
                facets.iter().map(|nodes| nodes.iter().map(|&a| at.now[a as usize]).collect()).collect()
            }
            Counterpart::Rigid { .. } => Vec::new(),
        };
        let face = OtherFace::new(self.kinematics.dim(), &faces, self.outward());
        let rubs = matches!(self.grip, Grip::Coulomb(_));
        let mut gaps: Vec<NodeGap> = vec![NodeGap::default(); self.nodes.len()];
        let mut moved: Vec<HashMap<u32, Mover>> = vec![HashMap::new(); self.nodes.len()];
        let mut stiffness: HashMap<(u32, u32), [[[f64; 3]; 3]; 2]> = HashMap::new();
        let found = self.points.par_iter().map(|point| {
            let facet = &self.facets[point.facet];
            let positions: Vec<[f64; 3]> = facet.iter().map(|&k| at.now[self.nodes[k as usize] as usize]).collect();
            let sign = self.inward[point.facet];
            let surface = Surface::at(self.kinematics.dim(), &positions, &point.shape, &point.gradient, sign);
            self.meet(&face, &surface, &point.gradient)
        });
        let found: Vec<Option<Meeting>> = found.collect();
        for (point, meeting) in self.points.iter().zip(found) {
            let Some(meeting) = meeting else { continue };
            let facet = &self.facets[point.facet];
            let own: Vec<u32> = facet.iter().map(|&k| self.nodes[k as usize]).collect();
            let touched = |positions: &[[f64; 3]]| combine(positions, &own, &point.shape);
            let apart = |positions: &[[f64; 3]]| {
                subtract(touched(positions), combine(positions, meeting.nodes, &meeting.value))
            };
            let slip = subtract(apart(at.now), apart(at.before));
            let slip = along_face(slip, meeting.normal, self.kinematics.dim() - 1);
            let mut load = 0.0;
            for (&k, &hat) in facet.iter().zip(&point.hat).filter(|(_, hat)| **hat != 0.0) {
                let (gap, weight) = (&mut gaps[k as usize], hat * point.weight);
                load += weight * pressure[k as usize].max(0.0);
                gap.area += weight;
                gap.gap += weight * meeting.gap;
                for i in 0..3 {
                    gap.offset[i] += weight * slip[i];
                    gap.normal[i] += weight * meeting.normal[i];
                }
                let nodes = own.iter().zip(&point.shape).map(|(&a, &n)| (a, n));
                let counter = meeting.nodes.iter().zip(&meeting.value).map(|(&a, &n)| (a, -n));
                for (place, (a, n)) in nodes.chain(counter).enumerate() {
                    let entry = moved[k as usize].entry(a).or_default();
                    let gradient = meeting.gradient(place, n, own.len());
                    entry.0 += weight * n;
                    for i in 0..3 {
                        // Rounded as the gradient is: the two are compared.
                        entry.1[i] += weight * (n * meeting.normal[i]);
                        entry.2[i] += weight * gradient[i];
                    }
                    if rubs {
                        let turning = meeting.turning(place, n, own.len());
                        (0..9).for_each(|k| entry.3[k / 3][k % 3] += weight * turning[k / 3][k % 3]);
                    }
                }
            }
            if load > 0.0 {
                meeting.for_second(&own, &point.shape, &mut |a, b, even, odd| {
                    let entry = stiffness.entry((a, b)).or_default();
                    for (sum, second) in entry.iter_mut().zip([even, odd]) {
                        (0..9).for_each(|k| sum[k / 3][k % 3] -= load * second[k / 3][k % 3]);
                    }
                });
            }
        }
        for (gap, moved) in gaps.iter_mut().zip(moved) {
            let mut all: Vec<_> = moved.into_iter().collect();
            all.sort_unstable_by_key(|entry| entry.0);
            gap.moved = all.iter().map(|(a, (weight, normal, ..))| (*a, *weight, *normal)).collect();
            gap.turning = all.iter().filter(|_| rubs).map(|(_, (.., turning))| *turning).collect();
            gap.gradient = all.into_iter().map(|(_, (_, _, gradient, _))| gradient).collect();
        }
        let mut stiffness: Vec<_> = stiffness.into_iter().collect();
        stiffness.sort_unstable_by_key(|entry| entry.0);
        let part = |k: usize| -> Vec<Coupling> { stiffness.iter().map(|((a, b), parts)| (*a, *b, parts[k])).collect() };
        let odd = part(1).into_iter().filter(|(_, _, k)| k.iter().flatten().any(|k| *k != 0.0)).collect();
        (gaps, Bending { even: part(0), odd })
    }

    /// Out of the counterpart, towards the touched body.
    fn outward(&self) -> [f64; 3] {
        let mut outward = [0.0; 3];
        outward[self.kinematics.dim() - 1] = self.side;
        outward
    }
}

fn combine(positions: &[[f64; 3]], nodes: &[u32], value: &[f64; 9]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (&a, &n) in nodes.iter().zip(value) {
        (0..3).for_each(|i| sum[i] += n * positions[a as usize][i]);
    }
    sum
}
