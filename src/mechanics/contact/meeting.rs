//! Where a point of the touched face meets its counterpart, and how the gap there changes.

use super::project::{Hit, OtherFace, cross, dot, slides};
use super::{Contact, Counterpart, Grip, Profile};
use crate::mechanics::kinematics::Kinematics;

/// A point's counterpart.
pub struct Meeting<'a> {
    /// Nodes of the counterpart's facet; none where it is rigid.
    pub nodes: &'a [u32],
    /// Their shape functions.
    pub value: [f64; 9],
    /// What turns pressure into force: the unit normal of the touched face, inwards; (slope, 1) over a profile.
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
    /// Of two faces.
    Faces(Box<Faces>),
}

/// How the gap between two faces bends.
pub struct Faces {
    /// Turning of the touched facet, then of the counterpart's.
    turns: [Turn; 2],
    /// Slopes of the counterpart along its tangents, towards the touched face's normal.
    slopes: [f64; 2],
}

/// How a facet's turning acts: its local gradients, and how its local coordinates move with points above.
pub struct Turn {
    gradient: [[f64; 2]; 9],
    slide: [[f64; 3]; 2],
}

/// A point of the touched face with its normal.
pub struct Surface {
    /// Position, mm.
    pub x: [f64; 3],
    /// Unit normal, into the touched body.
    pub normal: [f64; 3],
    /// Tangents along the local axes; the second is 0 in two dimensions.
    pub tangents: [[f64; 3]; 2],
}

impl Surface {
    /// A facet's point; `sign` turns the normal of its tangents into the body.
    pub fn at(dim: usize, positions: &[[f64; 3]], value: &[f64; 9], gradient: &[[f64; 2]; 9], sign: f64) -> Self {
        let (mut x, mut tangents) = ([0.0; 3], [[0.0; 3]; 2]);
        for ((node, n), g) in positions.iter().zip(value).zip(gradient) {
            for i in 0..3 {
                x[i] += n * node[i];
                (0..dim - 1).for_each(|k| tangents[k][i] += g[k] * node[i]);
            }
        }
        let [t, s] = tangents;
        let normal = if dim == 2 { [-t[1], t[0], 0.0] } else { cross(t, s) };
        let length = dot(normal, normal).sqrt();
        Self { x, normal: normal.map(|c| sign * c / length), tangents }
    }
}

impl Contact {
    /// The counterpart of a point of the touched face whose facet has the local gradients `gradient` there.
    pub(super) fn meet<'a>(
        &'a self,
        face: &OtherFace,
        point: &Surface,
        gradient: &[[f64; 2]; 9],
    ) -> Option<Meeting<'a>> {
        match &self.counterpart {
            Counterpart::Rigid { profile, center } => Some(self.meet_profile(profile, *center, point.x)),
            Counterpart::Face(facets) if self.grip == Grip::Bonded => face.foot(point.x).map(|foot| Meeting {
                nodes: &facets[foot.facet],
                value: foot.value,
                normal: foot.normal,
                gap: foot.gap,
                second: Second::Zero,
            }),
            Counterpart::Face(facets) => {
                let duals = slides(self.kinematics.dim() - 1, point.tangents, point.tangents)?;
                face.hit(point.x, point.normal, point.tangents).map(|hit| {
                    let Hit { facet, value, gap, .. } = hit;
                    let turns =
                        [Turn { gradient: *gradient, slide: duals }, Turn { gradient: hit.gradient, slide: hit.slide }];
                    let second = Second::Faces(Box::new(Faces { turns, slopes: hit.slopes }));
                    Meeting { nodes: &facets[facet], value, normal: point.normal, gap, second }
                })
            }
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

/// A node that moves a gap: its weight, the body it belongs to (0 the touched one) and its place in the facet.
struct Mover {
    node: u32,
    weight: f64,
    body: usize,
    place: usize,
}

/// Takes second derivatives by a pair of nodes: their symmetric part and the rest.
pub type Add<'a> = dyn FnMut(u32, u32, [[f64; 3]; 3], [[f64; 3]; 3]) + 'a;

impl Meeting<'_> {
    /// Calls `add` with the second derivatives of the gap by pairs of nodes, the touched ones with shape functions
    /// `shape`.
    pub fn for_second(&self, own: &[u32], shape: &[f64; 9], add: &mut Add) {
        match &self.second {
            Second::Zero => {}
            Second::Profile(second) => {
                for (&a, m) in own.iter().zip(shape) {
                    for (&b, n) in own.iter().zip(shape) {
                        add(a, b, second.map(|row| row.map(|h| m * n * h)), [[0.0; 3]; 3]);
                    }
                }
            }
            Second::Faces(faces) => self.faces_second(faces, own, shape, add),
        }
    }

    /// The force n W_a on node a turns with n and moves with W_a: with D the motion of the point along a face and E the
    /// turning of that face, -(D E) of the touched one and -(E D) of the counterpart. Where both turn together it is
    /// symmetric.
    fn faces_second(&self, faces: &Faces, own: &[u32], shape: &[f64; 9], add: &mut Add) {
        let mover = |body: usize, sign: f64| {
            move |(place, (&node, &n)): (usize, (&u32, &f64))| Mover { node, weight: sign * n, body, place }
        };
        let touched = own.iter().zip(shape).enumerate().map(mover(0, 1.0));
        let counter = self.nodes.iter().zip(&self.value).enumerate().map(mover(1, -1.0));
        let movers: Vec<Mover> = touched.chain(counter).collect();
        let turn = |mover: &Mover, of: usize, l: usize| {
            if mover.body == of { faces.turns[of].gradient[mover.place][l] } else { 0.0 }
        };
        let [slide, counter_slide] = faces.turns.each_ref().map(|turn| turn.slide);
        let exact = |a: &Mover, b: &Mover, i: usize, j: usize| {
            let n = &self.normal;
            let along = |l: usize| {
                a.weight * slide[l][i] * turn(b, 0, l) * n[j] + turn(a, 1, l) * n[i] * counter_slide[l][j] * b.weight
            };
            along(0) + along(1)
        };
        for a in &movers {
            for b in &movers {
                let (mut even, mut odd) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
                for i in 0..3 {
                    for j in 0..3 {
                        let [here, mirrored] = [exact(a, b, i, j), exact(b, a, j, i)];
                        even[i][j] = -0.5 * (here + mirrored);
                        odd[i][j] = -0.5 * (here - mirrored);
                    }
                }
                add(a.node, b.node, even, odd);
            }
        }
    }

    /// How the normal turns as the node at `place` of weight `n` moves, the `own` touched ones first: by rows its change
    /// along each axis.
    pub fn turning(&self, place: usize, n: f64, own: usize) -> [[f64; 3]; 3] {
        match &self.second {
            Second::Profile(second) => second.map(|row| row.map(|h| n * h)),
            Second::Faces(faces) if place < own => {
                let Turn { gradient, slide } = &faces.turns[0];
                let [first, other] = gradient[place];
                [0, 1, 2].map(|i| self.normal.map(|c| -(slide[0][i] * first + slide[1][i] * other) * c))
            }
            Second::Zero | Second::Faces(_) => [[0.0; 3]; 3],
        }
    }

    /// Gradient of the gap by the node at `place` of weight `n`, the `own` touched ones first: along the touched face's
    /// normal, less the counterpart's slope times the motion of the foot.
    pub fn gradient(&self, place: usize, n: f64, own: usize) -> [f64; 3] {
        let mut gradient = self.normal.map(|c| n * c);
        let Second::Faces(faces) = &self.second else { return gradient };
        let [touched, counter] = &faces.turns;
        for (slope, slide) in faces.slopes.iter().zip(&counter.slide) {
            (0..3).for_each(|i| gradient[i] -= slope * n * slide[i]);
            if place < own {
                for (local, dual) in touched.gradient[place].iter().zip(&touched.slide) {
                    let turn = slope * self.gap * dot(*slide, *dual) * local;
                    (0..3).for_each(|i| gradient[i] -= turn * self.normal[i]);
                }
            }
        }
        gradient
    }
}

/// Least cosine of a face's tilt at which faces approach along the axis and not along the normal: on a steep rim, what
/// little the normal turns would be divided by it.
const LEAST_COSINE: f64 = 0.6;

/// Part of a relative motion along the face with this normal. What closed the gap before the faces touched went along
/// the axis `up` and is no slip; seen along a tilted normal it would be.
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
