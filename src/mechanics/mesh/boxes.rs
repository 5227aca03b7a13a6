//! Boxes around inclusions: as wide as an O-grid likes, as narrow as the space between inclusions and faces wants.

use super::MeshError;

/// Room an O-grid likes around an inclusion, in units of the inclusion's reach along the axis.
pub(super) const MARGIN: f64 = 0.4;

/// Below this room a box goes up to the face itself: a strip between would be thinner than the O-grid's own cells.
const NARROW: f64 = 0.5;

/// Least free space, in units of the reach: a thinner gap has no element of usable shape.
pub(super) const LEAST_GAP: f64 = 0.005;

/// Where inclusions may be, along the axes of the mesh.
pub(super) struct Domain {
    /// Dimensions.
    pub dim: usize,
    /// Lower and upper bound along each axis, mm.
    pub range: [[f64; 2]; 3],
    /// Names of the faces there.
    pub faces: [[&'static str; 2]; 3],
    /// Axes whose lower bound is a plane of symmetry.
    pub symmetry: [bool; 3],
    /// Lines that the boxes should meet rather than pass by, mm; along the last axis no inclusion may cross one.
    pub lines: [Vec<f64>; 3],
}

/// An inclusion's box.
#[derive(Debug, Clone)]
pub(super) struct InclusionBox {
    /// Its centre, mm.
    pub center: [f64; 3],
    /// The box along each axis, mm.
    pub range: [[f64; 2]; 3],
    /// Reach of the inclusion below and above its centre, mm.
    pub extent: [[f64; 2]; 3],
    /// Free space below and above the inclusion, mm.
    pub free: [[f64; 2]; 3],
    /// Axes along which a plane of symmetry cuts it in half.
    pub cut: [bool; 3],
}

impl Domain {
    /// Boxes around inclusions given by centre and extent.
    pub fn boxes(&self, inclusions: &[([f64; 3], [[f64; 2]; 3])]) -> Result<Vec<InclusionBox>, MeshError> {
        let mut boxes = Vec::new();
        for (k, &(center, extent)) in inclusions.iter().enumerate() {
            boxes.push(self.free_space(k + 1, center, extent)?);
        }
        for second in 0..boxes.len() {
            for first in 0..second {
                self.part(&mut boxes, first, second)?;
            }
        }
        for item in &mut boxes {
            for axis in 0..self.dim {
                for side in 0..2 {
                    if side == 0 && item.cut[axis] {
                        item.range[axis][0] = item.center[axis];
                        continue;
                    }
                    let reach = item.extent[axis][side].abs();
                    let free = item.free[axis][side];
                    let margin = if free <= NARROW * reach { free } else { (MARGIN * reach).min(0.5 * free) };
                    item.range[axis][side] = item.center[axis] + [-1.0, 1.0][side] * (reach + margin);
                }
            }
        }
        (0..self.dim).for_each(|axis| self.meet_lines(&mut boxes, axis));
        Ok(boxes)
    }

    /// The nearest face below (side 0) or above a place, and its name: of the body or, along the last axis, of a layer.
    fn bound(&self, axis: usize, side: usize, at: f64) -> (f64, &'static str) {
        let (end, name) = (self.range[axis][side], self.faces[axis][side]);
        let interfaces = self.lines[axis].iter().filter(|_| axis + 1 == self.dim);
        let nearest = if side == 0 {
            interfaces.copied().filter(|&face| face <= at).fold(end, f64::max)
        } else {
            interfaces.copied().filter(|&face| face > at).fold(end, f64::min)
        };
        (nearest, if nearest == end { name } else { "interface of two layers" })
    }

    /// The box of inclusion `number`, still without room.
    pub fn free_space(
        &self,
        number: usize,
        center: [f64; 3],
        extent: [[f64; 2]; 3],
    ) -> Result<InclusionBox, MeshError> {
        let mut found = InclusionBox { center, range: [[0.0; 2]; 3], extent, free: [[0.0; 2]; 3], cut: [false; 3] };
        for axis in 0..self.dim {
            if !center[axis].is_finite() {
                return Err(MeshError::NotPositive { what: "the centre of an inclusion", value: center[axis] });
            }
            let crosses = self.symmetry[axis] && center[axis] + extent[axis][0] <= 0.0;
            if crosses && center[axis].abs() > 1e-9 * extent[axis][1] {
                let axis_name = ['x', 'y', 'z'][axis];
                return Err(MeshError::CutBySymmetry { inclusion: number, axis: axis_name, center_mm: center[axis] });
            }
            if crosses {
                found.cut[axis] = true;
                found.center[axis] = 0.0;
            }
            for side in 0..2 {
                if side == 0 && crosses {
                    continue;
                }
                let outer = center[axis] + extent[axis][side];
                let (bound, face) = self.bound(axis, side, center[axis]);
                let free = [1.0, -1.0][side] * (outer - bound);
                let least = LEAST_GAP * extent[axis][side].abs();
                if free < least {
                    // Rounded, so that one that just touches is at 0 mm and not at -0 mm.
                    let gap_mm = (free * 1e9).round() / 1e9 + 0.0;
                    return Err(MeshError::SticksOut { inclusion: number, face, gap_mm, least_mm: least });
                }
                found.free[axis][side] = free;
            }
        }
        Ok(found)
    }

    /// Shares the widest gap between two inclusions.
    fn part(&self, boxes: &mut [InclusionBox], first: usize, second: usize) -> Result<(), MeshError> {
        let bound = |k: usize, axis: usize, side: usize| boxes[k].center[axis] + boxes[k].extent[axis][side];
        let mut best = (f64::NEG_INFINITY, 0, first, second);
        for axis in 0..self.dim {
            for (below, above) in [(first, second), (second, first)] {
                let gap = bound(above, axis, 0) - bound(below, axis, 1);
                if gap > best.0 {
                    best = (gap, axis, below, above);
                }
            }
        }
        let (gap, axis, below, above) = best;
        let reach = boxes[below].extent[axis][1].max(-boxes[above].extent[axis][0]);
        if gap < 2.0 * LEAST_GAP * reach {
            let least_mm = 2.0 * LEAST_GAP * reach;
            return Err(MeshError::NotApart { first: first + 1, second: second + 1, gap_mm: gap, least_mm });
        }
        for (k, side) in [(below, 1), (above, 0)] {
            let free = &mut boxes[k].free[axis][side];
            *free = free.min(0.5 * gap);
        }
        Ok(())
    }

    /// Moves sides of boxes by up to a third of their margin onto lines nearby, so that no sliver lies between.
    fn meet_lines(&self, boxes: &mut [InclusionBox], axis: usize) {
        let mut lines = self.lines[axis].clone();
        lines.extend(self.range[axis]);
        for item in boxes {
            for side in 0..2 {
                if side == 0 && item.cut[axis] {
                    continue;
                }
                let inner = item.center[axis] + item.extent[axis][side];
                let (margin, free) = ((item.range[axis][side] - inner).abs(), item.free[axis][side]);
                let near = |line: &&f64| {
                    let moved = [-1.0, 1.0][side] * (**line - inner);
                    (moved - margin).abs() <= margin / 3.0 && moved <= free * (1.0 + 1e-9)
                };
                if let Some(&line) = lines.iter().find(near) {
                    item.range[axis][side] = line;
                }
                lines.push(item.range[axis][side]);
            }
        }
    }
}
