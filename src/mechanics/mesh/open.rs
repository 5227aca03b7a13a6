//! Grid lines of a mesh into which inclusions are fitted, and what these must keep to.

use super::boxes::LEAST_GAP;
use super::phantom::Layout;
use super::plan::Outline;
use super::{InclusionShape, MeshError, PhantomMesh, PhantomShape};

/// Breaks nearer to each other than this share of an inclusion's elements would leave slivers.
const SLIVER: f64 = 0.5;

/// Length of elements in an inclusion, in units of those across its least width.
const SLENDER: f64 = 2.0;

/// Directions in which surfaces are looked at.
const DIRECTIONS: usize = 600;

impl PhantomMesh {
    /// Lines without boxes, fine enough for the inclusions.
    pub(super) fn open_layout(&self, core: [f64; 2], outlines: &[Outline]) -> Result<Layout, MeshError> {
        self.check_sizes(core)?;
        let (domain, mut lines) = self.domain(3, core);
        let (mut axes, mut radial) = (Vec::new(), self.grading(&domain, 0, &[]));
        for body in &self.inclusions {
            radial.features.extend(self.radial_size(body, core, outlines)?);
        }
        for (axis, breaks) in lines.iter_mut().enumerate() {
            let mut grading = self.grading(&domain, axis, &[]);
            for body in &self.inclusions {
                let extent = body.surface.extent()?;
                grading.features.extend(self.sizes(body, extent, axis, core));
                let size = self.size(extent, axis);
                for end in extent[axis] {
                    let at = body.center_mm[axis] + end;
                    let inside = domain.range[axis][0] < at && at < domain.range[axis][1];
                    if inside
                        && breaks.iter().all(|other| (other - at).abs() > SLIVER * size || axis == 2 && *other == 0.0)
                    {
                        breaks.push(at);
                    }
                }
            }
            breaks.sort_by(f64::total_cmp);
            breaks.dedup();
            axes.push(grading.lines(breaks, self.resolution.subdivision)?);
        }
        Ok(Layout { axes, boxes: Vec::new(), radial })
    }

    /// Size along an axis that resolves an inclusion, mm: a share of its width, and along a thin one of its thickness,
    /// as its ends are sharply curved.
    fn size(&self, extent: [[f64; 2]; 3], axis: usize) -> f64 {
        let widths = extent.map(|[low, high]| high - low);
        let least = widths.into_iter().fold(f64::INFINITY, f64::min);
        widths[axis].min(SLENDER * least) / (2.0 * self.resolution.inclusion_divisions)
    }

    /// From, to and size that an inclusion wants along an axis of the grid, mm; where it lies in sectors, which fan out
    /// from the grid's edge, as seen from there.
    fn sizes(&self, body: &InclusionShape, extent: [[f64; 2]; 3], axis: usize, core: [f64; 2]) -> Vec<[f64; 3]> {
        let [low, high] = extent[axis].map(|end| body.center_mm[axis] + end);
        let size = self.size(extent, axis);
        let mut sizes = vec![[low, high, size]];
        if axis < 2 {
            let (across, edge) = (1 - axis, core[1 - axis]);
            let distance = body.center_mm[across].abs();
            if distance > edge {
                let share = edge / distance;
                sizes = vec![[low * share, high * share, size * share]];
            }
        }
        sizes
    }

    /// From, to and size that an inclusion wants along the rays from the axis, mm, as seen along x: rings lead from the
    /// grid's edge to the outlines at equal shares of each ray.
    fn radial_size(
        &self,
        body: &InclusionShape,
        core: [f64; 2],
        outlines: &[Outline],
    ) -> Result<Option<[f64; 3]>, MeshError> {
        let ([x, y, _], extent) = (body.center_mm, body.surface.extent()?);
        let far = x.hypot(y);
        if far == 0.0 {
            return Ok(None);
        }
        let direction = [x / far, y / far];
        let rings: Vec<Outline> = [Outline::Rectangle(core)].into_iter().chain(outlines.iter().copied()).collect();
        let along_x = |distance: f64| {
            let at = |outline: Outline| [outline.distance(direction), outline.distance([1.0, 0.0])];
            let ring = rings.windows(2).find(|ring| distance <= at(ring[1])[0]).or(rings.windows(2).last());
            let Some(&[inner, outer]) = ring else { return distance };
            let (from, to) = (at(inner), at(outer));
            from[1] + (distance - from[0]) / (to[0] - from[0]) * (to[1] - from[1])
        };
        // Half the width along the ray, as of an ellipse.
        let half = [0, 1].map(|i| 0.5 * (extent[i][1] - extent[i][0]));
        let reach = (half[0] * direction[0]).hypot(half[1] * direction[1]);
        let [low, high] = [along_x(far - reach), along_x(far + reach)];
        let most = self.size(extent, 0).max(self.size(extent, 1)) * (high - low) / (2.0 * reach);
        Ok(Some([low, high, (0.5 * (high - low) / self.resolution.inclusion_divisions).min(most)]))
    }

    /// Whether inclusions lie within the phantom and apart from each other.
    pub(super) fn check_bodies(&self) -> Result<(), MeshError> {
        let domain = self.domain(3, self.shape.half_widths()).0;
        let mut points = Vec::new();
        for (k, body) in self.inclusions.iter().enumerate() {
            domain.free_space(k + 1, body.center_mm, body.surface.extent()?)?;
            let surface = directions().map(|u| {
                let radius = body.surface.radius(k + 1, u)?;
                Ok(std::array::from_fn(|i| body.center_mm[i] + radius * u[i]))
            });
            points.push(surface.collect::<Result<Vec<[f64; 3]>, MeshError>>()?);
            self.check_side(k + 1, &points[k])?;
            for other in 0..k {
                self.check_apart(other, k, &points[k])?;
                self.check_apart(k, other, &points[other])?;
            }
        }
        Ok(())
    }

    fn check_side(&self, inclusion: usize, points: &[[f64; 3]]) -> Result<(), MeshError> {
        let PhantomShape::Cylinder { radius_mm, .. } = self.shape else { return Ok(()) };
        let far = |at: &[f64; 3]| (at[0] - self.offset_mm[0]).hypot(at[1] - self.offset_mm[1]);
        let farthest = points.iter().map(far).fold(0.0, f64::max);
        let reach = farthest - far(&self.inclusions[inclusion - 1].center_mm);
        let (gap_mm, least_mm) = (radius_mm - farthest, LEAST_GAP * reach.abs());
        if gap_mm < least_mm {
            return Err(MeshError::SticksOut { inclusion, face: "side", gap_mm, least_mm });
        }
        Ok(())
    }

    /// Whether points of the surface of inclusion `of` lie off inclusion `body`, both from 0.
    fn check_apart(&self, body: usize, of: usize, points: &[[f64; 3]]) -> Result<(), MeshError> {
        let shape = &self.inclusions[body];
        let (mut gap_mm, mut least_mm) = (f64::INFINITY, 0.0);
        for point in points.iter().chain([&self.inclusions[of].center_mm]) {
            let arm: [f64; 3] = std::array::from_fn(|i| point[i] - shape.center_mm[i]);
            let length = arm.iter().map(|x| x * x).sum::<f64>().sqrt();
            let direction = if length > 0.0 { arm.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
            let radius = shape.surface.radius(body + 1, direction)?;
            if length - radius < gap_mm {
                (gap_mm, least_mm) = (length - radius, 2.0 * LEAST_GAP * radius);
            }
        }
        if gap_mm < least_mm {
            let (first, second) = (body.min(of) + 1, body.max(of) + 1);
            return Err(MeshError::Overlap { first, second, gap_mm, least_mm });
        }
        Ok(())
    }
}

/// Unit vectors evenly over the sphere (a Fibonacci lattice).
fn directions() -> impl Iterator<Item = [f64; 3]> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    (0..DIRECTIONS).map(move |k| {
        let z = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (std::f64::consts::TAU * golden * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        [across * cos, across * sin, z]
    })
}
