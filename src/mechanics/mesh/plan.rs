//! The plan view of three-dimensional meshes: a rectangle of grid lines, and rings of sectors around it.
//!
//! The rectangle holds the inclusions' boxes. The first ring leads from it to the circle of contact, the next to the
//! outline of the phantom, both along rays from the axis; on each ray the outlines lie in this order, so no sector
//! folds.

use super::boxes::MARGIN;
use super::builder::{Builder, between_planes, cells};
use super::error::positive;
use super::fillet::rim_start;
use super::phantom::Layout;
use super::{Footprint, InclusionShape, Lines, Mesh, MeshError, PhantomMesh, PhantomShape, fit};

/// Half diagonal of the rectangle in the middle over the radius of the circle around it, if nothing asks for more.
const DIAGONAL: f64 = 0.78;

/// The most it may be: beyond, the corners of the sectors become too thin.
const MOST_DIAGONAL: f64 = 0.93;

/// Room between the outermost inclusion and the rectangle's edge, in units of the inclusion's distance.
const ROOM: f64 = 1.01;

/// A closed line around the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outline {
    /// A circle by its radius, mm.
    Circle(f64),
    /// A rectangle by its half widths, mm.
    Rectangle([f64; 2]),
}

impl Outline {
    /// Distance from the axis along a unit vector.
    pub fn distance(self, direction: [f64; 2]) -> f64 {
        match self {
            Self::Circle(radius) => radius,
            Self::Rectangle(half) => (half[0] / direction[0].abs()).min(half[1] / direction[1].abs()),
        }
    }
}

/// The plan view.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Lines of the rectangle in the middle.
    pub core: [Lines; 2],
    /// Outlines around it, inner ones first, each with the nodes' places between the one before (0) and it (1).
    pub rings: Vec<(Outline, Vec<f64>)>,
    /// Axes along which only the positive half is there.
    pub symmetry: [bool; 2],
    /// Place of the last outline's centre, mm.
    pub offset_mm: [f64; 2],
}

impl Plan {
    /// Adds the sectors, extruded along `heights`; `regions` has one entry a cell of these.
    pub fn add_sectors(&self, builder: &mut Builder, heights: &Lines, regions: &[u32]) -> Result<(), MeshError> {
        let z = heights.nodes();
        for axis in 0..2 {
            let along = self.core[1 - axis].nodes();
            for (side, symmetric) in [(-1.0, self.symmetry[axis]), (1.0, false)] {
                let edge = self.core[axis].0.last().copied().unwrap_or(0.0) * side;
                let mut inner: Option<Outline> = None;
                for (k, (outer, places)) in self.rings.iter().enumerate().filter(|_| !symmetric) {
                    let shift = if k + 1 == self.rings.len() { self.offset_mm } else { [0.0; 2] };
                    let node = |index: [usize; 3]| {
                        let mut at = [edge; 2];
                        at[1 - axis] = along[index[0]];
                        let length = at[0].hypot(at[1]);
                        let direction = at.map(|x| x / length);
                        let from = inner.map_or(length, |outline| outline.distance(direction));
                        let distance = from * (1.0 - places[index[1]]) + outer.distance(direction) * places[index[1]];
                        let place = [0, 1].map(|i| distance * direction[i] + places[index[1]] * shift[i]);
                        [place[0], place[1], z[index[2]]]
                    };
                    let counts = [along.len() / 2, places.len() / 2, heights.cells()];
                    builder.expect_elements(counts.iter().fold(1, |all: usize, &n| all.saturating_mul(n)))?;
                    for cell in cells(counts) {
                        let region = regions.get(cell[2]).copied().unwrap_or(0);
                        builder.add(region, |local| node([0, 1, 2].map(|i| 2 * cell[i] + local[i])));
                    }
                    inner = Some(*outer);
                }
            }
        }
        Ok(())
    }
}

impl PhantomMesh {
    /// The mesh of hexahedra in (x, y, z).
    ///
    /// Inclusions have boxes where these can stand apart within the contact's circle, or are fitted into
    /// a mesh that carries the contact's edge.
    ///
    /// # Errors
    /// Sizes not positive, inclusions that stick out or overlap, a rectangular footprint too far out in a cylinder, too
    /// many elements, a mesh too coarse for an inclusion.
    pub fn build_3d(&self) -> Result<Mesh, MeshError> {
        positive("the way from the axis to the phantom's side", self.least_reach())?;
        let (layout, plan, boxed) = self.scheme()?;
        let mut builder = Builder::new(3);
        let regions = self.regions(&layout.axes[2]);
        if boxed {
            self.fill(&mut builder, &layout)?;
        } else {
            builder.add_grid(&layout.axes, |cell| regions.get(cell[2]).copied())?;
        }
        plan.add_sectors(&mut builder, &layout.axes[2], &regions)?;
        let finish = |builder: Builder| builder.finish(between_planes(3, 0.0, self.shape.height_mm(), self.symmetry));
        if boxed {
            return finish(builder);
        }
        let base = finish(builder)?;
        let mut fitted = Builder::new(3);
        fit::fit(&mut fitted, &base, &self.inclusions)?;
        finish(fitted).and_then(fit::sound).map_err(|error| match error {
            MeshError::Folded { at_mm, .. } => MeshError::NotFitted { at_mm },
            other => other,
        })
    }

    /// Whether inclusions have boxes of their own.
    ///
    /// # Errors
    /// As [`Self::build_3d`].
    pub fn boxed(&self) -> Result<bool, MeshError> {
        Ok(self.scheme()?.2)
    }

    /// The plan view within the contact, for a sensor that shares its nodes.
    pub(super) fn contact_plan(&self) -> Result<Plan, MeshError> {
        let mut plan = self.scheme()?.1;
        plan.offset_mm = [0.0; 2];
        let half = self.footprint.half_widths();
        let carried = match self.footprint {
            Footprint::Round { radius_mm } => {
                let edge = plan.rings.iter().position(|ring| ring.0 == Outline::Circle(radius_mm));
                plan.rings.truncate(edge.map_or(0, |edge| edge + 1));
                edge.is_some()
            }
            Footprint::Rectangle { .. } => {
                plan.rings.clear();
                for (lines, half) in plan.core.iter_mut().zip(half) {
                    *lines = lines.between(-half, half);
                }
                (0..2).all(|axis| plan.core[axis].0.last() == Some(&half[axis]))
            }
        };
        if carried { Ok(plan) } else { Err(MeshError::NoSharedEdge { edge_mm: half[0] }) }
    }

    /// Grid, boxes and rings, and whether inclusions have boxes.
    fn scheme(&self) -> Result<(Layout, Plan, bool), MeshError> {
        let plan = |inclusions: &[InclusionShape], boxed: bool| {
            let (core, outlines) = self.outlines(inclusions)?;
            let layout = if boxed { self.layout(3, core)? } else { self.open_layout(core, &outlines)? };
            let plan = self.plan(&layout, core, &outlines)?;
            Ok((layout, plan, boxed))
        };
        let carries = |plan: &Plan| {
            let Footprint::Round { radius_mm } = self.footprint else { return true };
            radius_mm >= self.least_reach() || plan.rings.iter().any(|ring| ring.0 == Outline::Circle(radius_mm))
        };
        match plan(&self.inclusions, true) {
            Ok(found) if carries(&found.1) => Ok(found),
            Ok(_) | Err(MeshError::NotApart { .. } | MeshError::TooFarOut { .. }) => {
                self.check_bodies()?;
                plan(&[], false)
            }
            Err(error) => Err(error),
        }
    }

    /// Rings around a grid.
    fn plan(&self, layout: &Layout, core: [f64; 2], outlines: &[Outline]) -> Result<Plan, MeshError> {
        let last = self.shape.half_widths()[0];
        let mut radii = vec![core[0]];
        radii.extend(outlines.iter().map(|outline| match *outline {
            Outline::Circle(radius) => radius,
            Outline::Rectangle(_) => last,
        }));
        let (mut radial, size) = (layout.radial.clone(), self.resolution);
        let edge = self.footprint.half_widths()[0];
        radial.features.push([edge, edge, size.ring_share * size.edge_mm]);
        let lines = radial.lines(&radii, size.subdivision)?;
        let places = |from: f64, to: f64| {
            let nodes = lines.between(from, to).nodes();
            nodes.into_iter().map(|x| (x - from) / (to - from)).collect()
        };
        let rings =
            outlines.iter().zip(radii.windows(2)).map(|(outline, pair)| (*outline, places(pair[0], pair[1]))).collect();
        let axis = |axis: usize| layout.axes.get(axis).cloned().unwrap_or(Lines(Vec::new()));
        Ok(Plan { core: [axis(0), axis(1)], rings, symmetry: self.symmetry, offset_mm: self.offset_mm })
    }

    /// Least distance from the axis to the outline, mm.
    fn least_reach(&self) -> f64 {
        let ([x, y], [half_x, half_y]) = (self.offset_mm, self.shape.half_widths());
        match self.shape {
            PhantomShape::Cylinder { radius_mm, .. } => radius_mm - x.hypot(y),
            PhantomShape::Block { .. } => (half_x - x.abs()).min(half_y - y.abs()),
        }
    }

    /// Half widths of the rectangle in the middle, and the outlines around it.
    fn outlines(&self, inclusions: &[InclusionShape]) -> Result<([f64; 2], Vec<Outline>), MeshError> {
        let (half, foot) = (self.shape.half_widths(), self.footprint.half_widths());
        let (outer, shape) = match self.shape {
            PhantomShape::Cylinder { radius_mm, .. } => (Outline::Circle(radius_mm), [1.0, 1.0]),
            PhantomShape::Block { .. } => (Outline::Rectangle(half), [1.0, half[1] / half[0]]),
        };
        // Reach of what must lie in the rectangle, in units of its proportions: bare, and with the O-grids' room.
        let mut reach = [0.0_f64; 2];
        for inclusion in inclusions {
            let extent = inclusion.surface.extent()?;
            for axis in 0..2 {
                for end in extent[axis] {
                    let at = (inclusion.center_mm[axis] + end).abs();
                    reach[0] = reach[0].max(ROOM * at / shape[axis]);
                    reach[1] = reach[1].max((at + MARGIN * end.abs()) / shape[axis]);
                }
            }
        }
        let round = matches!(self.footprint, Footprint::Round { .. });
        if !round {
            let edge = foot[0].max(foot[1]);
            reach = reach.map(|x| x.max(edge));
        }
        let diagonal = shape[0].hypot(shape[1]);
        let core = |radius: f64| {
            let (least, most) = (DIAGONAL * radius / diagonal, MOST_DIAGONAL * radius / diagonal);
            let width = reach[1].clamp(least, most);
            (reach[0] <= most).then_some(shape.map(|share| share * width))
        };
        // The circle where the rim's arc begins, and that where it ends.
        let start = rim_start(self.resolution.rim_mm, foot[0]);
        let around = if round && foot[0] < self.least_reach() { core(start) } else { None };
        if let Some(core) = around {
            let mut outlines = vec![Outline::Circle(start), Outline::Circle(foot[0]), outer];
            outlines.dedup();
            return Ok((core, outlines));
        }
        match outer {
            Outline::Rectangle(_) => Ok((half, Vec::new())),
            Outline::Circle(_) => match core(self.least_reach()) {
                Some(core) => Ok((core, vec![outer])),
                None => {
                    let what = if round { "an inclusion" } else { "an inclusion or the footprint" };
                    let limit_mm = MOST_DIAGONAL * self.least_reach() / diagonal;
                    Err(MeshError::TooFarOut { what, reach_mm: reach[0], limit_mm })
                }
            },
        }
    }
}
