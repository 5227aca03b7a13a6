//! The touched face of a press: which of its pressures are judged, what lies between nodes, the peak.

use super::facets::{Facet, FacetMesh};
use super::{ContactPoint, PressStep, Pressed, SensorBody, Setup};
use crate::mechanics::contact::Contact;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::mesh::Footprint;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// Share of the footprint over which pressures are judged.
pub const JUDGED_SHARE: f64 = 0.8;

/// The touched face at one load, in its undeformed place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Face {
    /// Its nodes, by x, then y.
    pub points: Vec<ContactPoint>,
    /// Where it has two axes.
    facets: Option<FacetMesh>,
    outline: Outline,
}

/// Where pressures are judged, and by how much a place is off the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Outline {
    /// Half the widths along x and y of the ellipse that is the footprint, or the largest in it, mm.
    reach_mm: [f64; 2],
    /// Coordinates along the face: 1 (r or x) or 2.
    axes: usize,
    /// Whether it has a singular edge.
    has_edge: bool,
}

impl Outline {
    fn of(setup: &Setup) -> Self {
        Self {
            reach_mm: match setup.phantom.footprint {
                Footprint::Round { radius_mm } => [radius_mm; 2],
                Footprint::Rectangle { half_widths_mm } => half_widths_mm,
            },
            axes: setup.kinematics.dim() - 1,
            has_edge: !matches!(setup.sensor, SensorBody::Indenter(_)),
        }
    }

    /// Squared distance of a place from the axis, in reaches.
    fn place(&self, at: [f64; 3]) -> f64 {
        (0..self.axes).map(|i| (at[i] / self.reach_mm[i]).powi(2)).sum()
    }

    /// An indenter has no singular edge, so all of its contact is judged.
    fn is_judged(&self, at: [f64; 3]) -> bool {
        !self.has_edge || self.place(at) <= JUDGED_SHARE.powi(2)
    }
}

/// Whether a point lies within the part of the face over which pressures are judged.
pub fn is_judged(setup: &Setup, point: &ContactPoint) -> bool {
    Outline::of(setup).is_judged(point.reference_mm)
}

impl Face {
    /// The face at one load of a press.
    pub fn of(pressed: &Pressed, step: &PressStep) -> Self {
        Self::new(&pressed.setup, pressed.assembly.problem.contacts.first(), step.points.clone())
    }

    /// A face of given points in two dimensions, by x: of a closed form, say.
    pub fn along(setup: &Setup, points: Vec<ContactPoint>) -> Self {
        Self::new(setup, None, points)
    }

    pub(super) fn new(setup: &Setup, contact: Option<&Contact>, points: Vec<ContactPoint>) -> Self {
        let outline = Outline::of(setup);
        let contact = contact.filter(|_| setup.kinematics == Kinematics::ThreeDimensional);
        let facets = contact.map(|contact| {
            let place = |point: &ContactPoint| [point.reference_mm[0], point.reference_mm[1]];
            FacetMesh::new(2, setup.phantom.symmetry, pressure_facets(contact, &points, place))
        });
        Self { points, facets, outline }
    }

    /// Squared distance of a place from the axis, in reaches of the footprint.
    pub fn place(&self, at: [f64; 3]) -> f64 {
        self.outline.place(at)
    }

    /// Whether it ends at a sensor's edge, which is singular where it is sharp, and so is judged in part.
    pub fn has_edge(&self) -> bool {
        self.outline.has_edge
    }

    /// Nodes of the part over which pressures are judged.
    pub fn judged(&self) -> impl Iterator<Item = &ContactPoint> {
        self.points.iter().filter(|point| self.outline.is_judged(point.reference_mm))
    }

    /// Place of the largest pressure over the judged part, mm, and that pressure, kPa; nothing where no node is judged.
    ///
    /// Towards a singular edge the pressure rises up to the end of that part, which seldom is a node, so that places
    /// along the end count too. Another mesh would have other last nodes, and the peak would leap by what lies between.
    pub fn peak(&self) -> Option<([f64; 3], f64)> {
        let nodes = self.judged().map(|point| (point.reference_mm, point.pressure_kpa));
        let around = match (self.outline.has_edge, self.outline.axes) {
            (false, _) => 0,
            // Along x the ends are two.
            (true, 1) => 2,
            (true, _) => AROUND,
        };
        let end = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / around as f64).sin_cos();
            let [x, y] = self.outline.reach_mm;
            let at = [JUDGED_SHARE * x * cos, if around == AROUND { JUDGED_SHARE * y * sin } else { 0.0 }, 0.0];
            Some((at, self.pressure_at(at)?))
        };
        nodes.chain((0..around).filter_map(end)).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// By how much the node at the peak stands out from what its neighbours tell of the pressure there, as a share of
    /// the peak; none on a face with two axes, and at the end of the contact.
    ///
    /// On the axis little area bears on a node, and where faces slide pressures of neighbours go up and down: what
    /// stands out there does not shrink as the square of the elements. Neighbours are two on each side; beyond the axis
    /// they are those before it.
    pub fn stands_out(&self) -> f64 {
        let Some((at, peak)) = self.peak().filter(|(_, peak)| self.facets.is_none() && *peak > 0.0) else { return 0.0 };
        let away = |k: &usize| (self.points[*k].reference_mm[0] - at[0]).abs();
        let Some(node) = (0..self.points.len()).min_by(|a, b| away(a).total_cmp(&away(b))) else { return 0.0 };
        let x = |k: usize| self.points[k].reference_mm[0];
        let neighbour = |by: isize| {
            let k = node as isize + by;
            let (k, side) = if k < 0 && x(0) == 0.0 { (-k, -1.0) } else { (k, 1.0) };
            let point = self.points.get(usize::try_from(k).ok()?)?;
            Some((side * point.reference_mm[0], point.pressure_kpa)).filter(|(_, pressure)| *pressure > 0.0)
        };
        let Some(told) = [-2, -1, 1, 2].into_iter().map(neighbour).collect::<Option<Vec<_>>>() else { return 0.0 };
        // The cubic through them (Lagrange).
        let weight = |&(own, _): &(f64, f64)| {
            told.iter()
                .filter(|(other, _)| *other != own)
                .map(|(other, _)| (x(node) - other) / (own - other))
                .product::<f64>()
        };
        let expected: f64 = told.iter().map(|one| weight(one) * one.1).sum();
        (self.points[node].pressure_kpa - expected).abs() / peak
    }

    /// Pressure at a place of the undeformed face, kPa: linear between nodes, as the contact has it. Nothing beyond.
    pub fn pressure_at(&self, at: [f64; 3]) -> Option<f64> {
        if let Some(facets) = &self.facets {
            return facets.between_nodes(facets.meshed([at[0], at[1]]));
        }
        let after = self.points.partition_point(|point| point.reference_mm[0] < at[0]);
        let b = self.points.get(after)?;
        let Some(a) = after.checked_sub(1).and_then(|k| self.points.get(k)) else {
            return (b.reference_mm[0] <= at[0]).then_some(b.pressure_kpa);
        };
        let share = (at[0] - a.reference_mm[0]) / (b.reference_mm[0] - a.reference_mm[0]);
        Some(a.pressure_kpa + share * (b.pressure_kpa - a.pressure_kpa))
    }
}

/// Places along the end of the judged part that a peak is sought at.
const AROUND: usize = 180;

/// The facets of a contact with the pressures of their nodes, at places of those, mm.
pub fn pressure_facets(
    contact: &Contact,
    points: &[ContactPoint],
    place: impl Fn(&ContactPoint) -> [f64; 2],
) -> Vec<Facet> {
    let by_node: HashMap<u32, &ContactPoint> = points.iter().map(|point| (point.node, point)).collect();
    let of = |nodes: Vec<u32>| nodes.iter().filter_map(|node| by_node.get(node).copied()).collect::<Vec<_>>();
    let facet = |points: Vec<&ContactPoint>| Facet {
        nodes: points.iter().map(|p| p.node).collect(),
        places: points.iter().map(|p| place(p)).collect(),
        values: points.iter().map(|p| p.pressure_kpa).collect(),
    };
    contact.facets().map(of).map(facet).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::error_estimate::{difference, peak_error};
    use super::*;

    /// A quarter of a rectangle of 20 x 12 mm in so many by as many facets, with pressures by place.
    fn quarter(divisions: usize, pressure_kpa: &dyn Fn(f64, f64) -> f64) -> Face {
        let reach_mm = [10.0, 6.0];
        let lines = 2 * divisions + 1;
        let place =
            |k: usize| [(k % lines, 10.0), (k / lines, 6.0)].map(|(i, width)| width * i as f64 / (lines - 1) as f64);
        let point = |k: usize| {
            let [x, y] = place(k);
            let (displacement_mm, reference_mm, pressure_kpa) = ([0.0; 3], [x, y, 0.0], pressure_kpa(x, y));
            let (node, shear_kpa, gap_mm, force_mn, area_mm2) = (k as u32, 0.0, 0.0, 0.0, 1.0);
            ContactPoint { node, reference_mm, displacement_mm, pressure_kpa, shear_kpa, gap_mm, force_mn, area_mm2 }
        };
        let points: Vec<_> = (0..lines * lines).map(point).collect();
        let facet = |k: usize| {
            let first = 2 * (k % divisions) + 2 * lines * (k / divisions);
            let of: Vec<usize> = (0..9).map(|a| first + a % 3 + lines * (a / 3)).collect();
            Facet {
                nodes: of.iter().map(|&k| k as u32).collect(),
                places: of.iter().map(|&k| place(k)).collect(),
                values: of.iter().map(|&k| points[k].pressure_kpa).collect(),
            }
        };
        let facets = FacetMesh::new(2, [true; 2], (0..divisions * divisions).map(facet).collect());
        let outline = Outline { reach_mm, axes: 2, has_edge: true };
        Face { points, facets: Some(facets), outline }
    }

    #[test]
    fn pressures_that_lines_can_follow_are_the_same_on_other_nodes() {
        let field = |x: f64, y: f64| 3.0 + 0.2 * x - 0.1 * y + 0.05 * x * y;
        let [coarse, fine] = [3, 7].map(|divisions| quarter(divisions, &field));
        for at in [[0.0f64, 0.0], [10.0, 6.0], [1.7, 5.2], [-8.1, 0.4], [3.3, -2.9]] {
            let expected = field(at[0].abs(), at[1].abs());
            let found = coarse.pressure_at([at[0], at[1], 0.0]).unwrap();
            assert!((found - expected).abs() < 1e-9, "{at:?}: {found} for {expected}");
        }
        assert_eq!(coarse.pressure_at([10.1, 0.0, 0.0]), None);
        assert!(difference(&fine, &coarse) < 1e-12 && peak_error(&fine, &coarse, [1.0; 2]) < 1e-12);
        // What another field is off is told, at the peak in full.
        let other = quarter(3, &|x, y| 1.02 * field(x, y));
        assert!((difference(&fine, &other) - 0.02).abs() < 1e-9);
        assert!((peak_error(&fine, &other, [1.0; 2]) - 0.02).abs() < 1e-9);
    }

    #[test]
    fn a_rectangle_is_judged_within_an_ellipse_that_no_side_cuts() {
        let rising = |x: f64, y: f64| 1.0 + (x / 10.0).powi(2) + (y / 6.0).powi(2);
        let face = quarter(40, &rising);
        assert!(face.judged().all(|point| point.reference_mm[0] <= 8.0 && point.reference_mm[1] <= 4.8));
        let (at, pressure) = face.peak().unwrap();
        // The ellipse is a line of equal pressure, 1.64; chords of 40 facets are above it by 1e-3 of that.
        assert!((face.place(at) - 0.64).abs() < 1e-9 && (pressure - 1.64).abs() < 1e-3, "{at:?}: {pressure}");
    }
}
