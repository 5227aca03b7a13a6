//! Contact of a body's face with a rigid profile or with another body's face.
//!
//! Pressure lives on the nodes of the touched face as hat functions over half facets (they are never negative, unlike the
//! quadratic ones), and the gap is averaged with the same hats over Gauss points: a mortar method, which passes the contact
//! patch test on meshes that do not match. A node is in contact where pressure - eps * gap > 0 (Alart and Curnier 1991);
//! Newton's tangent is that of a stiff spring eps, its residual that of exact contact: each step brings both the
//! forces and the gaps closer. Tractions are per area of the undeformed face.

pub mod profile;
pub mod project;

pub use profile::Profile;

use super::element::{GAUSS_3, Shape};
use super::kinematics::Kinematics;
use super::mesh::{Facet, Mesh};
use project::{Face, dot, subtract};
use std::collections::HashMap;

/// How two faces hold each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grip {
    /// Bonded: no gap, no slip, no lift-off.
    Bonded,
    /// Unilateral, without friction.
    Frictionless,
    /// Unilateral, Coulomb friction with this coefficient.
    Coulomb(f64),
}

/// What a face meets.
#[derive(Debug, Clone)]
pub enum Counterpart {
    /// A rigid profile around the axis x = `center` (r = 0 in axisymmetry), its top in the plane z = 0.
    Rigid {
        /// The profile.
        profile: Profile,
        /// Position of the profile's axis along x and y, mm.
        center: [f64; 2],
    },
    /// The face of another body of the same mesh, with its nodes per facet.
    Face(Vec<Vec<u32>>),
}

/// A Gauss point of the touched face.
#[derive(Debug, Clone)]
struct TouchPoint {
    facet: usize,
    shape: [f64; 9],
    hat: [f64; 9],
    weight: f64,
}

/// A pair of faces.
#[derive(Debug, Clone)]
pub struct Contact {
    kinematics: Kinematics,
    /// How they hold.
    pub grip: Grip,
    counterpart: Counterpart,
    /// Nodes of the touched facets, as places in `nodes`.
    facets: Vec<Vec<u32>>,
    /// The touched nodes.
    pub nodes: Vec<u32>,
    points: Vec<TouchPoint>,
    /// Spring of the tangent at each touched node, kPa per mm.
    pub spring: Vec<f64>,
    /// -1 where the touched body lies below its face (the counterpart above), 1 where above.
    side: f64,
}

/// The constraint of one touched node at some state.
#[derive(Debug, Clone, Default)]
pub struct NodeGap {
    /// Area of the node's hat that has a counterpart, mm^2 (mm in plane strain).
    pub area: f64,
    /// Integral of hat times normal gap.
    pub gap: f64,
    /// Integral of hat times offset vector between the faces (bonded), or slip since the last step (friction).
    pub offset: [f64; 3],
    /// Mean normal (integral of hat times normal), out of the counterpart.
    pub normal: [f64; 3],
    /// Nodes of both bodies that move the gap: scalar weight and weight times normal.
    pub moved: Vec<(u32, f64, [f64; 3])>,
    /// Second derivatives of the normal gap by pairs of touched nodes along x, from the profile's curvature.
    pub curvature: Vec<(u32, u32, [[f64; 3]; 3])>,
}

/// How far the tangent's spring is stiffer than the body, in shear moduli over facet size.
pub const SPRING: f64 = 1e6;

impl Contact {
    /// Pairs the facets of a mesh with a counterpart. `shear_kpa` is that of the softer body.
    pub fn new(
        kinematics: Kinematics,
        mesh: &Mesh,
        facets: &[Facet],
        counterpart: Counterpart,
        grip: Grip,
        shear_kpa: f64,
        side: f64,
    ) -> Self {
        let axes = kinematics.dim() - 1;
        let mut nodes = Vec::new();
        let mut place: HashMap<u32, u32> = HashMap::new();
        let mut size: Vec<f64> = Vec::new();
        let mut local = Vec::new();
        let mut points = Vec::new();
        for (k, &facet) in facets.iter().enumerate() {
            let global = mesh.facet_nodes(facet);
            let positions: Vec<[f64; 3]> = global.iter().map(|&a| mesh.nodes[a as usize]).collect();
            let here = touch_points(kinematics, k, &positions);
            let area: f64 = here.iter().map(|point| point.weight / kinematics.weight(radius(&positions, point))).sum();
            let length = if axes == 1 { area } else { area.sqrt() };
            local.push(
                global
                    .iter()
                    .map(|&a| {
                        let index = *place.entry(a).or_insert_with(|| {
                            nodes.push(a);
                            size.push(length);
                            nodes.len() as u32 - 1
                        });
                        size[index as usize] = size[index as usize].min(length);
                        index
                    })
                    .collect(),
            );
            points.extend(here);
        }
        let spring = size.iter().map(|length| SPRING * shear_kpa / length).collect();
        Self { kinematics, grip, counterpart, facets: local, nodes, points, spring, side }
    }

    /// The constraints of all touched nodes where `x` are the present positions and `before` those of the last step.
    pub fn gaps(&self, x: &[[f64; 3]], before: &[[f64; 3]], reference: &[[f64; 3]]) -> Vec<NodeGap> {
        let outward = self.outward();
        let faces: Vec<Vec<[f64; 3]>> = match &self.counterpart {
            // Bonded faces keep the pairs that they had when they met.
            Counterpart::Face(facets) => {
                let at = if self.grip == Grip::Bonded { reference } else { x };
                facets.iter().map(|nodes| nodes.iter().map(|&a| at[a as usize]).collect()).collect()
            }
            Counterpart::Rigid { .. } => Vec::new(),
        };
        let face = Face { dim: self.kinematics.dim(), facets: &faces, outward };
        let mut gaps: Vec<NodeGap> = vec![NodeGap::default(); self.nodes.len()];
        let mut moved: Vec<HashMap<u32, (f64, [f64; 3])>> = vec![HashMap::new(); self.nodes.len()];
        for point in &self.points {
            let facet = &self.facets[point.facet];
            let own: Vec<u32> = facet.iter().map(|&k| self.nodes[k as usize]).collect();
            let at = |positions: &[[f64; 3]]| combine(positions, &own, &point.shape);
            let Some(meeting) = self.meet(&face, if self.bonded_face() { at(reference) } else { at(x) }) else {
                continue;
            };
            let other = |positions: &[[f64; 3]]| combine(positions, &meeting.nodes, &meeting.value);
            let offset = if self.grip == Grip::Bonded {
                match &self.counterpart {
                    Counterpart::Face(_) => {
                        let start = subtract(at(reference), other(reference));
                        subtract(subtract(at(x), other(x)), start)
                    }
                    Counterpart::Rigid { .. } => subtract(at(x), at(reference)),
                }
            } else {
                let slip = subtract(subtract(at(x), at(before)), subtract(other(x), other(before)));
                let along = dot(slip, meeting.normal) / dot(meeting.normal, meeting.normal);
                subtract(slip, meeting.normal.map(|n| n * along))
            };
            for (&k, &hat) in facet.iter().zip(&point.hat) {
                if hat == 0.0 {
                    continue;
                }
                let (gap, weight) = (&mut gaps[k as usize], hat * point.weight);
                gap.area += weight;
                gap.gap += weight * meeting.gap;
                for i in 0..3 {
                    gap.offset[i] += weight * offset[i];
                    gap.normal[i] += weight * meeting.normal[i];
                }
                let nodes = own.iter().zip(&point.shape).map(|(&a, &n)| (a, n));
                let counter = meeting.nodes.iter().zip(&meeting.value).map(|(&a, &n)| (a, -n));
                for (a, n) in nodes.chain(counter) {
                    let entry = moved[k as usize].entry(a).or_default();
                    entry.0 += weight * n;
                    (0..3).for_each(|i| entry.1[i] += weight * n * meeting.normal[i]);
                }
                if let Some(hessian) = meeting.hessian {
                    for (&a, &m) in own.iter().zip(&point.shape) {
                        for (&b, &n) in own.iter().zip(&point.shape) {
                            gap.curvature.push((a, b, hessian.map(|row| row.map(|h| weight * m * n * h))));
                        }
                    }
                }
            }
        }
        for (gap, moved) in gaps.iter_mut().zip(moved) {
            gap.moved = moved.into_iter().map(|(a, (weight, normal))| (a, weight, normal)).collect();
            gap.moved.sort_unstable_by_key(|entry| entry.0);
        }
        gaps
    }

    fn bonded_face(&self) -> bool {
        self.grip == Grip::Bonded && matches!(self.counterpart, Counterpart::Face(_))
    }

    /// Out of the counterpart, towards the touched body.
    fn outward(&self) -> [f64; 3] {
        let mut outward = [0.0; 3];
        outward[self.kinematics.dim() - 1] = self.side;
        outward
    }

    fn meet(&self, face: &Face, x: [f64; 3]) -> Option<Meeting> {
        match &self.counterpart {
            Counterpart::Rigid { profile, center } => Some(self.meet_profile(profile, *center, x)),
            Counterpart::Face(facets) => face.foot(x).map(|foot| Meeting {
                nodes: facets[foot.facet].clone(),
                value: foot.value,
                normal: foot.normal,
                gap: foot.gap,
                hessian: None,
            }),
        }
    }

    /// The gap z + depth(distance) with its gradient and second derivatives.
    fn meet_profile(&self, profile: &Profile, center: [f64; 2], x: [f64; 3]) -> Meeting {
        let up = self.kinematics.dim() - 1;
        let across = match self.kinematics {
            Kinematics::Axisymmetric => [x[0], 0.0],
            Kinematics::PlaneStrain => [x[0] - center[0], 0.0],
            Kinematics::ThreeDimensional => [x[0] - center[0], x[1] - center[1]],
        };
        let distance = across[0].hypot(across[1]);
        let [depth, slope, curvature] = profile.depth(distance);
        let mut normal = [0.0; 3];
        let mut hessian = [[0.0; 3]; 3];
        let near = distance < 1e-12;
        for i in 0..up {
            let e_i = if near { 0.0 } else { across[i] / distance };
            normal[i] = slope * e_i;
            for j in 0..up {
                let e_j = if near { 0.0 } else { across[j] / distance };
                let (along, delta) = (e_i * e_j, f64::from(i == j));
                let turn = if near { curvature } else { slope / distance };
                hessian[i][j] = curvature * along + turn * (delta - along);
            }
        }
        normal[up] = 1.0;
        let hessian = (self.grip != Grip::Bonded && (curvature != 0.0 || slope != 0.0)).then_some(hessian);
        Meeting { nodes: Vec::new(), value: [0.0; 9], normal, gap: x[up] + depth, hessian }
    }

    /// Areas of the nodes' hats at positions `x`, to turn nominal into true tractions.
    pub fn present_areas(&self, x: &[[f64; 3]]) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        for (k, facet) in self.facets.iter().enumerate() {
            let positions: Vec<[f64; 3]> =
                facet.iter().map(|&place| x[self.nodes[place as usize] as usize]).collect();
            for point in touch_points(self.kinematics, k, &positions) {
                for (&place, &hat) in facet.iter().zip(&point.hat) {
                    areas[place as usize] += hat * point.weight;
                }
            }
        }
        areas
    }
}

/// Where a point meets its counterpart.
struct Meeting {
    nodes: Vec<u32>,
    value: [f64; 9],
    /// Gradient of the gap (a unit vector against a face; (slope, 1) against a profile).
    normal: [f64; 3],
    gap: f64,
    hessian: Option<[[f64; 3]; 3]>,
}

fn combine(positions: &[[f64; 3]], nodes: &[u32], value: &[f64; 9]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (&a, &n) in nodes.iter().zip(value) {
        (0..3).for_each(|i| sum[i] += n * positions[a as usize][i]);
    }
    sum
}

fn radius(positions: &[[f64; 3]], point: &TouchPoint) -> f64 {
    positions.iter().zip(&point.shape).map(|(x, n)| n * x[0]).sum()
}

/// Three Gauss points along each half of each axis of a facet, with the hats of its lattice.
fn touch_points(kinematics: Kinematics, facet: usize, positions: &[[f64; 3]]) -> Vec<TouchPoint> {
    let axes = kinematics.dim() - 1;
    let line: Vec<[f64; 2]> = [-0.5, 0.5]
        .iter()
        .flat_map(|middle| GAUSS_3.map(|[at, weight]| [middle + 0.5 * at, 0.5 * weight]))
        .collect();
    let hats = |xi: f64| [(-xi).max(0.0), 1.0 - xi.abs(), xi.max(0.0)];
    (0..line.len().pow(axes as u32))
        .map(|q| {
            let (i, j) = (q % line.len(), q / line.len());
            let second = if axes == 2 { line[j] } else { [0.0, 1.0] };
            let shape = Shape::at(axes, [line[i][0], second[0], 0.0]);
            let mut tangents = [[0.0; 3]; 2];
            for (a, x) in positions.iter().enumerate() {
                for c in 0..3 {
                    tangents[0][c] += shape.gradient[a][0] * x[c];
                    tangents[1][c] += shape.gradient[a][1] * x[c];
                }
            }
            let stretch = match axes {
                1 => dot(tangents[0], tangents[0]).sqrt(),
                _ => {
                    let [a, b] = tangents;
                    (dot(a, a) * dot(b, b) - dot(a, b).powi(2)).max(0.0).sqrt()
                }
            };
            let mut point = TouchPoint { facet, shape: [0.0; 9], hat: [0.0; 9], weight: 0.0 };
            let (first, other) = (hats(line[i][0]), hats(second[0]));
            for (a, (shape_a, hat_a)) in point.shape.iter_mut().zip(&mut point.hat).enumerate().take(positions.len()) {
                *shape_a = shape.value[a];
                *hat_a = first[a % 3] * if axes == 2 { other[a / 3] } else { 1.0 };
            }
            point.weight = line[i][1] * second[1] * stretch * kinematics.weight(radius(positions, &point));
            point
        })
        .collect()
}
