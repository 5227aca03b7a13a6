//! Where a point of the touched face meets its counterpart, and how the gap there changes.

use super::project::{Bend, Face, dot};
use super::{Contact, Counterpart, Grip, Profile};
use crate::mechanics::kinematics::Kinematics;

/// A point's counterpart.
pub struct Meeting<'a> {
    /// Nodes of the counterpart's facet; none where it is rigid.
    pub nodes: &'a [u32],
    /// Their shape functions.
    pub value: [f64; 9],
    /// Gradient of the gap: the unit normal of a face, (slope, 1) over a profile.
    pub normal: [f64; 3],
    /// The gap, mm.
    pub gap: f64,
    /// Its second derivatives.
    pub second: Second,
}

/// Second derivatives of a gap.
pub enum Second {
    /// None.
    Zero,
    /// Of a profile, by the point's position.
    Profile([[f64; 3]; 3]),
    /// Of a face, by the positions of point and face.
    Face(Box<Bend>),
}

impl Contact {
    /// The counterpart of a point at `x`.
    pub(super) fn meet<'a>(&'a self, face: &Face, x: [f64; 3]) -> Option<Meeting<'a>> {
        match &self.counterpart {
            Counterpart::Rigid { profile, center } => Some(self.meet_profile(profile, *center, x)),
            Counterpart::Face(facets) => face.foot(x).map(|foot| Meeting {
                nodes: &facets[foot.facet],
                value: foot.value,
                normal: foot.normal,
                gap: foot.gap,
                second: Second::Face(Box::new(foot.bend)),
            }),
        }
    }

    /// The gap z + depth(distance).
    fn meet_profile(&self, profile: &Profile, center: [f64; 2], x: [f64; 3]) -> Meeting<'static> {
        let up = self.kinematics.dim() - 1;
        let across = match self.kinematics {
            Kinematics::Axisymmetric => [x[0], 0.0],
            Kinematics::PlaneStrain => [x[0] - center[0], 0.0],
            Kinematics::ThreeDimensional => [x[0] - center[0], x[1] - center[1]],
        };
        let distance = across[0].hypot(across[1]);
        let [depth, slope, curvature] = profile.depth(distance);
        let near = distance < 1e-12;
        let direction = across.map(|c| if near { 0.0 } else { c / distance });
        let turn = if near { curvature } else { slope / distance };
        let mut normal = [0.0; 3];
        let mut second = [[0.0; 3]; 3];
        for i in 0..up {
            normal[i] = slope * direction[i];
            for j in 0..up {
                let along = direction[i] * direction[j];
                let around = if up == 2 { turn * (f64::from(i == j) - along) } else { 0.0 };
                second[i][j] = if near { turn * f64::from(i == j) } else { curvature * along + around };
            }
        }
        normal[up] = 1.0;
        let bent = self.grip != Grip::Bonded && (curvature != 0.0 || slope != 0.0);
        let second = if bent { Second::Profile(second) } else { Second::Zero };
        Meeting { nodes: &[], value: [0.0; 9], normal, gap: x[up] + depth, second }
    }
}

/// A node that moves a gap: how the foot slides with it, and how it turns the face.
type Mover = (u32, [[f64; 3]; 2], [[f64; 3]; 2]);

impl Meeting<'_> {
    /// Calls `add` with the second derivatives of the gap by pairs of nodes, the touched ones with shape functions `shape`.
    pub fn for_second(&self, own: &[u32], shape: &[f64; 9], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3])) {
        match &self.second {
            Second::Zero => {}
            Second::Profile(second) => {
                for (&a, m) in own.iter().zip(shape) {
                    for (&b, n) in own.iter().zip(shape) {
                        add(a, b, second.map(|row| row.map(|h| m * n * h)));
                    }
                }
            }
            Second::Face(bend) => self.face_second(bend, own, shape, add),
        }
    }

    /// At a closed gap, -(E D + D E + k D D) with D the motion of the foot along the face, E the turning of the face and k
    /// its curvature (Wriggers 2006, Computational Contact Mechanics, ch. 6).
    fn face_second(&self, bend: &Bend, own: &[u32], shape: &[f64; 9], add: &mut dyn FnMut(u32, u32, [[f64; 3]; 3])) {
        let counter = self.nodes.iter().enumerate().map(|(a, &node)| (node, -self.value[a], bend.gradient[a]));
        let movers: Vec<Mover> = own
            .iter()
            .zip(shape)
            .map(|(&node, &n)| (node, n, [0.0; 2]))
            .chain(counter)
            .map(|(node, n, gradient)| (node, bend.slide(n), gradient.map(|g| self.normal.map(|c| g * c))))
            .collect();
        for (a, slide_a, turn_a) in &movers {
            for (b, slide_b, turn_b) in &movers {
                let mut second = [[0.0; 3]; 3];
                for (k, row) in bend.curvature.iter().enumerate() {
                    for i in 0..3 {
                        for j in 0..3 {
                            let bent: f64 = (0..2).map(|l| row[l] * slide_a[k][i] * slide_b[l][j]).sum();
                            second[i][j] -= turn_a[k][i] * slide_b[k][j] + slide_a[k][i] * turn_b[k][j] + bent;
                        }
                    }
                }
                add(*a, *b, second);
            }
        }
    }
}

impl Bend {
    /// How the foot's local coordinates move with a node of weight `n`.
    fn slide(&self, n: f64) -> [[f64; 3]; 2] {
        [0, 1].map(|k| [0, 1, 2].map(|i| n * (0..2).map(|l| self.metric[k][l] * self.tangents[l][i]).sum::<f64>()))
    }
}

/// Least cosine of a face's tilt at which faces approach along the axis and not along the normal.
const LEAST_COSINE: f64 = 0.1;

/// Part of a relative motion along the face with this normal. What closed the gap before the faces touched went along the
/// axis `up` and is no slip; seen along a tilted normal it would be.
pub fn along_face(motion: [f64; 3], normal: [f64; 3], up: usize) -> [f64; 3] {
    let square = dot(normal, normal);
    if normal[up].abs() < LEAST_COSINE * square.sqrt() {
        let share = dot(motion, normal) / square;
        return [0, 1, 2].map(|i| motion[i] - share * normal[i]);
    }
    let mut along = motion;
    along[up] -= dot(motion, normal) / normal[up];
    along
}
