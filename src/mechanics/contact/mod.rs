//! Contact of a body's face with a rigid profile or with another body's face.
//!
//! Pressure lives on the nodes of the touched face as hat functions over half facets (they are never negative, unlike
//! the quadratic ones), and the gap is averaged with the same hats over Gauss points: a mortar method, which passes the
//! contact patch test on meshes that do not match. A node is in contact where pressure - eps * gap > 0 (Alart and
//! Curnier 1991); Newton's tangent is that of a stiff spring eps, its residual that of exact contact: each step brings
//! both the forces and the gaps closer. Tractions are per area of the undeformed face.

mod gaps;
mod meeting;
mod points;
pub mod profile;
pub mod project;

pub use gaps::Positions;
pub use profile::Profile;

use super::kinematics::Kinematics;
use super::mesh::{Facet, Mesh};
use meeting::Surface;
use points::{TouchPoint, radius, touch_points};
use std::collections::HashMap;
use std::sync::OnceLock;

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
    /// Sign of each facet's normal that points into the touched body.
    inward: Vec<f64>,
    /// Spring of the tangent at each touched node, kPa per mm.
    pub spring: Vec<f64>,
    /// -1 where the touched body lies below its face (the counterpart above), 1 where above.
    pub side: f64,
    /// The constraints of bonded nodes at rest, once they were asked for.
    bonds: OnceLock<Vec<NodeGap>>,
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
    /// Gradient of the gap by these nodes. Over a face it differs from the normal by the angle between the faces.
    pub gradient: Vec<[f64; 3]>,
    /// How the mean normal turns with these nodes, by rows its change along each axis; none where nothing rubs.
    pub turning: Vec<[[f64; 3]; 3]>,
}

/// Stiffness between two nodes, mN per mm.
pub type Coupling = (u32, u32, [[f64; 3]; 3]);

/// The stiffness that pressures get from the bending of gaps.
#[derive(Debug, Clone, Default)]
pub struct Bending {
    /// Its symmetric part.
    pub even: Vec<Coupling>,
    /// The rest.
    pub odd: Vec<Coupling>,
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
        let mut inward = Vec::new();
        for (k, &facet) in facets.iter().enumerate() {
            let global = mesh.facet_nodes(facet);
            let positions: Vec<[f64; 3]> = global.iter().map(|&a| mesh.nodes[a as usize]).collect();
            let here = touch_points(kinematics, k, &positions);
            let up = kinematics.dim() - 1;
            inward.push(here.first().map_or(1.0, |point| {
                let surface = Surface::at(up + 1, &positions, &point.shape, &point.gradient, 1.0);
                (side * surface.normal[up]).signum()
            }));
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
        Self {
            kinematics,
            grip,
            counterpart,
            facets: local,
            nodes,
            points,
            inward,
            spring,
            side,
            bonds: OnceLock::new(),
        }
    }

    /// Whether the counterpart is rigid.
    pub fn is_rigid(&self) -> bool {
        matches!(self.counterpart, Counterpart::Rigid { .. })
    }

    /// Nodes of each touched facet.
    pub fn facets(&self) -> impl Iterator<Item = Vec<u32>> {
        self.facets.iter().map(|facet| facet.iter().map(|&k| self.nodes[k as usize]).collect())
    }

    /// Areas of the nodes' hats at positions `x`, to turn nominal into true tractions.
    pub fn present_areas(&self, x: &[[f64; 3]]) -> Vec<f64> {
        let mut areas = vec![0.0; self.nodes.len()];
        for (k, facet) in self.facets.iter().enumerate() {
            let positions: Vec<[f64; 3]> = facet.iter().map(|&place| x[self.nodes[place as usize] as usize]).collect();
            for point in touch_points(self.kinematics, k, &positions) {
                for (&place, &hat) in facet.iter().zip(&point.hat) {
                    areas[place as usize] += hat * point.weight;
                }
            }
        }
        areas
    }
}
