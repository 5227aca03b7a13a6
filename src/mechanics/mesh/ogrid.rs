//! An inclusion in its box: a core like the box, a ring from it to the surface, a ring from the surface to the box.
//!
//! The lattice of the grid lines through the box goes over to the surface along rays from the centre. Core, surface and
//! box lie in this order on each ray, so the rings cannot fold, whatever the star-shaped surface. The inside of the
//! core is the transfinite (Gordon-Hall) interpolation of its boundary.

use std::collections::HashMap;

use super::MeshError;
use super::builder::{Builder, cells};

/// Size of the core: this share of the surface's radius where the box would first pierce it.
const CORE_SHARE: f64 = 0.75;

/// A box with an inclusion, in the axes of the mesh.
pub(super) struct Ogrid<'a> {
    /// Dimensions.
    pub dim: usize,
    /// Centre, mm.
    pub center: [f64; 3],
    /// Positions of the nodes of the grid through the box, mm; the axes beyond the dimensions hold a single 0.
    pub axes: [Vec<f64>; 3],
    /// Axes whose lower side is a plane of symmetry through the centre.
    pub cut: [bool; 3],
    /// Elements from core to surface and from surface to box.
    pub rings: [usize; 2],
    /// Regions of inclusion and surrounding.
    pub regions: [u32; 2],
    /// Distance of the surface from the centre along a unit vector.
    pub radius: &'a dyn Fn([f64; 3]) -> Result<f64, MeshError>,
}

/// A ray from the centre through a node on the box.
#[derive(Clone, Copy)]
struct Ray {
    direction: [f64; 3],
    /// Distances of core, surface and box, mm.
    at: [f64; 3],
}

impl Ogrid<'_> {
    /// Adds all elements in the box.
    pub fn fill(&self, builder: &mut Builder) -> Result<(), MeshError> {
        let counts = [0, 1, 2].map(|axis| (self.axes[axis].len() / 2).max(1));
        let faces: usize = (0..self.dim).map(|axis| 2 * counts.iter().product::<usize>() / counts[axis]).sum();
        builder.expect_elements(counts.iter().product::<usize>() + faces * (self.rings[0] + self.rings[1]))?;
        let rays = self.rays()?;
        for axis in 0..self.dim {
            for side in [0, 1] {
                if side == 1 || !self.cut[axis] {
                    self.fill_side(builder, &rays, counts, axis, side);
                }
            }
        }
        for cell in cells(counts) {
            builder.add(self.regions[0], |local| self.core([0, 1, 2].map(|axis| 2 * cell[axis] + local[axis]), &rays));
        }
        Ok(())
    }

    /// Both rings behind one side of the box.
    fn fill_side(
        &self,
        builder: &mut Builder,
        rays: &HashMap<[usize; 3], Ray>,
        counts: [usize; 3],
        axis: usize,
        side: usize,
    ) {
        let mut across = counts;
        across[axis] = self.rings[0] + self.rings[1];
        for cell in cells(across) {
            let ring = usize::from(cell[axis] >= self.rings[0]);
            builder.add(self.regions[ring], |local| {
                let mut index = [0, 1, 2].map(|i| 2 * cell[i] + local[i]);
                let first = [0, 2 * self.rings[0]][ring];
                let along = (index[axis] - first) as f64 / (2 * self.rings[ring]) as f64;
                index[axis] = side * (self.axes[axis].len() - 1);
                let ray = rays[&index];
                self.out(&ray, ray.at[ring] * (1.0 - along) + ray.at[ring + 1] * along)
            });
        }
    }

    fn out(&self, ray: &Ray, distance: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.center[i] + distance * ray.direction[i])
    }

    /// The rays through all nodes on the box, by their place in the lattice.
    fn rays(&self) -> Result<HashMap<[usize; 3], Ray>, MeshError> {
        let mut rays = HashMap::new();
        let mut pierced = f64::INFINITY;
        for index in cells(std::array::from_fn(|axis| self.axes[axis].len())) {
            let ends = |axis: usize| (index[axis] == 0 && !self.cut[axis]) || index[axis] + 1 == self.axes[axis].len();
            if !(0..self.dim).any(ends) {
                continue;
            }
            let arm: [f64; 3] = std::array::from_fn(|axis| self.axes[axis][index[axis]] - self.center[axis]);
            let length = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
            let direction = arm.map(|x| x / length);
            let surface = (self.radius)(direction)?;
            pierced = pierced.min(surface / length);
            rays.insert(index, Ray { direction, at: [0.0, surface, length] });
        }
        // The core is half way between the box's shape and the surface's: rounded.
        for ray in rays.values_mut() {
            ray.at[0] = 0.5 * (CORE_SHARE * pierced * ray.at[2] + 0.5 * ray.at[1]);
        }
        Ok(rays)
    }

    /// A node of the core: the Boolean sum of the linear interpolations along each axis between opposite sides.
    fn core(&self, index: [usize; 3], rays: &HashMap<[usize; 3], Ray>) -> [f64; 3] {
        let mut sum = [0.0; 3];
        // Each axis: 0 stays, 1 goes to the lower side, 2 to the upper.
        for choice in cells(std::array::from_fn(|axis| if axis < self.dim { 3 } else { 1 })) {
            let moved = choice.iter().filter(|&&side| side > 0).count();
            if moved == 0 {
                continue;
            }
            let (mut at, mut mirrored, mut weight) = (index, [1.0; 3], if moved % 2 == 1 { 1.0 } else { -1.0 });
            for axis in (0..self.dim).filter(|&axis| choice[axis] > 0) {
                let (last, nodes) = (self.axes[axis].len() - 1, &self.axes[axis]);
                let low = if self.cut[axis] { 2.0 * self.center[axis] - nodes[last] } else { nodes[0] };
                let share = (nodes[index[axis]] - low) / (nodes[last] - low);
                weight *= if choice[axis] == 1 { 1.0 - share } else { share };
                // Where a plane of symmetry cuts, the lower side is the upper one's image.
                mirrored[axis] = if choice[axis] == 1 && self.cut[axis] { -1.0 } else { 1.0 };
                at[axis] = if choice[axis] == 2 || self.cut[axis] { last } else { 0 };
            }
            let ray = rays[&at];
            (0..self.dim).for_each(|i| sum[i] += weight * mirrored[i] * ray.at[0] * ray.direction[i]);
        }
        std::array::from_fn(|i| self.center[i] + sum[i])
    }
}
