//! Bicubic B-spline height fields over the footprint.

use super::Relief;

/// Displacement of one interface: a bicubic B-spline that interpolates samples on a regular grid.
///
/// Samples lie at the corners of `columns - 1` by `rows - 1` cells that span the footprint; the spline ends with zero
/// second derivative (natural). Control points carry one more row and column on every side.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    /// Samples along x.
    pub columns: usize,
    /// Samples along y.
    pub rows: usize,
    /// Samples per mm along x and y.
    pub per_mm: [f64; 2],
    /// Control points, (rows + 2) x (columns + 2), row 0 at negative y, mm.
    pub control: Vec<f64>,
}

impl HeightField {
    /// Interpolates `samples` (row-major, row 0 at negative y, mm) over a footprint of the given size.
    ///
    /// At least 3 x 3 samples, as many as `columns * rows`; otherwise `None`.
    pub fn interpolate(columns: usize, rows: usize, footprint_mm: [f64; 2], samples: &[f64]) -> Option<Self> {
        if columns < 3 || rows < 3 || samples.len() != columns * rows {
            return None;
        }
        let width = columns + 2;
        let mut control = vec![0.0; width * (rows + 2)];
        for y in 0..rows {
            let line = control_points(&samples[y * columns..(y + 1) * columns]);
            control[(y + 1) * width..(y + 2) * width].copy_from_slice(&line);
        }
        for x in 0..width {
            let line: Vec<f64> = (1..=rows).map(|y| control[y * width + x]).collect();
            for (y, c) in control_points(&line).into_iter().enumerate() {
                control[y * width + x] = c;
            }
        }
        Some(Self {
            columns,
            rows,
            per_mm: [(columns - 1) as f64 / footprint_mm[0], (rows - 1) as f64 / footprint_mm[1]],
            control,
        })
    }

    /// Samples `height(x, y)` over the footprint and interpolates; `points` samples along the longer side.
    pub fn sample(points: usize, footprint_mm: [f64; 2], height: impl Fn(f64, f64) -> f64) -> Option<Self> {
        let longer = footprint_mm[0].max(footprint_mm[1]);
        let count = |extent: f64| ((points as f64 * extent / longer).round() as usize).max(3);
        let (columns, rows) = (count(footprint_mm[0]), count(footprint_mm[1]));
        let at = |k: usize, n: usize, extent: f64| (k as f64 / (n - 1) as f64 - 0.5) * extent;
        let samples: Vec<f64> = (0..rows * columns)
            .map(|k| height(at(k % columns, columns, footprint_mm[0]), at(k / columns, rows, footprint_mm[1])))
            .collect();
        Self::interpolate(columns, rows, footprint_mm, &samples)
    }

    /// The same field with every height multiplied.
    pub fn scaled(&self, factor: f64) -> Self {
        let mut out = self.clone();
        out.control.iter_mut().for_each(|c| *c *= factor);
        out
    }
}

impl Relief for HeightField {
    /// The spline stays within its control points.
    fn range_mm(&self) -> [f64; 2] {
        let fold = |init: f64, pick: fn(f64, f64) -> f64| self.control.iter().copied().fold(init, pick);
        [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Along either axis the derivative is a convex combination of first differences.
    fn steepest(&self) -> f64 {
        let width = self.columns + 2;
        let largest = |step: usize, per_mm: f64| {
            let pairs = self.control.iter().zip(&self.control[step..]).enumerate();
            // A row's last point is no neighbour of the next row's first.
            let within = pairs.filter(|(k, _)| step > 1 || (k + 1) % width != 0);
            within.map(|(_, (a, b))| (b - a).abs() * per_mm).fold(0.0, f64::max)
        };
        largest(1, self.per_mm[0]).hypot(largest(width, self.per_mm[1]))
    }

    /// In a cell the second derivatives are convex combinations of second differences of its 4 x 4 control points; the
    /// bound is the largest norm of such a Hessian.
    fn bend(&self) -> f64 {
        let width = self.columns + 2;
        let at = |x: usize, y: usize| self.control[y * width + x];
        let [sx, sy] = self.per_mm;
        let largest = |differences: &mut dyn Iterator<Item = f64>| differences.map(f64::abs).fold(0.0, f64::max);
        let bound = |x: usize, y: usize| {
            let xx = largest(&mut (0..8).map(|k| {
                let (i, j) = (x + k % 2, y + k / 2);
                (at(i, j) - 2.0 * at(i + 1, j) + at(i + 2, j)) * sx * sx
            }));
            let yy = largest(&mut (0..8).map(|k| {
                let (i, j) = (x + k / 2, y + k % 2);
                (at(i, j) - 2.0 * at(i, j + 1) + at(i, j + 2)) * sy * sy
            }));
            let xy = largest(&mut (0..9).map(|k| {
                let (i, j) = (x + k % 3, y + k / 3);
                (at(i, j) - at(i + 1, j) - at(i, j + 1) + at(i + 1, j + 1)) * sx * sy
            }));
            // Largest eigenvalue of [[xx, xy], [xy, yy]].
            0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy)
        };
        let cells = (0..self.columns - 1).flat_map(|x| (0..self.rows - 1).map(move |y| (x, y)));
        cells.map(|(x, y)| bound(x, y)).fold(0.0, f64::max)
    }

    fn at(&self, x: f64, y: f64) -> [f64; 3] {
        let half = |n: usize, per: f64| (n - 1) as f64 / per / 2.0;
        let gx = (x + half(self.columns, self.per_mm[0])) * self.per_mm[0];
        let gy = (y + half(self.rows, self.per_mm[1])) * self.per_mm[1];
        let cx = gx.floor().clamp(0.0, (self.columns - 2) as f64);
        let cy = gy.floor().clamp(0.0, (self.rows - 2) as f64);
        let (ux, uy) = ((gx - cx).clamp(0.0, 1.0), (gy - cy).clamp(0.0, 1.0));
        let (wx, dx, wy, dy) = (weights(ux), slopes(ux), weights(uy), slopes(uy));
        let mut sum = [0.0; 3];
        for (j, (w, d)) in wy.iter().zip(dy).enumerate() {
            let at = (cy as usize + j) * (self.columns + 2) + cx as usize;
            let row = &self.control[at..at + 4];
            let value: f64 = row.iter().zip(wx).map(|(c, w)| c * w).sum();
            let slope: f64 = row.iter().zip(dx).map(|(c, d)| c * d).sum();
            sum[0] += w * value;
            sum[1] += w * slope * self.per_mm[0];
            sum[2] += d * value * self.per_mm[1];
        }
        sum
    }
}

fn weights(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    [v * v * v, (3.0 * u - 6.0) * u * u + 4.0, (3.0 * v - 6.0) * v * v + 4.0, u * u * u].map(|w| w / 6.0)
}

fn slopes(u: f64) -> [f64; 4] {
    let v = 1.0 - u;
    [-v * v, (3.0 * u - 4.0) * u, (4.0 - 3.0 * v) * v, u * u].map(|w| w / 2.0)
}

/// Control points (two more than samples) of the natural cubic B-spline through the samples, by the Thomas algorithm.
fn control_points(samples: &[f64]) -> Vec<f64> {
    let n = samples.len();
    let mut c = vec![0.0; n + 2];
    c[1..=n].copy_from_slice(samples);
    // The ends interpolate with zero second derivative: c_0 = f_0. Inside: c_{k-1} + 4 c_k + c_{k+1} = 6 f_k.
    let mut ratio = vec![0.0; n];
    for k in 1..n - 1 {
        let pivot = 4.0 - ratio[k - 1];
        ratio[k] = 1.0 / pivot;
        c[k + 1] = (6.0 * samples[k] - c[k]) / pivot;
    }
    for k in (1..n - 1).rev() {
        c[k + 1] -= ratio[k] * c[k + 2];
    }
    c[0] = 2.0 * c[1] - c[2];
    c[n + 1] = 2.0 * c[n] - c[n - 1];
    c
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn bump(x: f64, y: f64) -> f64 {
        -(-(x * x + 2.0 * y * y) / 8.0).exp()
    }

    #[test]
    fn spline_passes_through_its_samples() {
        let field = HeightField::sample(33, [30.0, 20.0], bump).unwrap();
        for k in 0..field.columns {
            let x = (k as f64 / (field.columns - 1) as f64 - 0.5) * 30.0;
            for j in 0..field.rows {
                let y = (j as f64 / (field.rows - 1) as f64 - 0.5) * 20.0;
                assert!((field.at(x, y)[0] - bump(x, y)).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn error_falls_with_the_fourth_power_of_the_spacing() {
        let error = |points| {
            let field = HeightField::sample(points, [30.0, 30.0], bump).unwrap();
            let points = (1..4000).map(|k| (f64::from(k) * 0.754_877_67 % 1.0, f64::from(k) * 0.569_840_29 % 1.0));
            let squares = points.map(|(u, v)| (20.0 * u - 10.0, 20.0 * v - 10.0));
            squares.map(|(x, y)| (field.at(x, y)[0] - bump(x, y)).powi(2)).sum::<f64>().sqrt()
        };
        // Quasi-random points; the next term of the error falls twice as fast, 3 % of it is left at this spacing.
        let rate = (error(129) / error(257)).log2();
        assert!((rate - 4.0).abs() < 0.1, "{rate}");
    }

    #[test]
    fn slope_and_second_derivative_never_exceed_their_bounds() {
        let field = HeightField::sample(65, [30.0, 30.0], bump).unwrap();
        let bound = field.bend();
        let (mut largest, mut steepest) = (0.0f64, 0.0f64);
        for k in 0..4000 {
            let (x, y) = (0.0173 * k as f64 % 24.0 - 12.0, 0.0531 * k as f64 % 24.0 - 12.0);
            let (c, s) = ((k as f64).cos(), (k as f64).sin());
            let e = 1e-4;
            let h = |t: f64| field.at(x + t * c, y + t * s)[0];
            let [_, along, across] = field.at(x, y);
            steepest = steepest.max(along.hypot(across));
            largest = largest.max(((h(e) - 2.0 * h(0.0) + h(-e)) / (e * e)).abs());
        }
        assert!(steepest <= field.steepest() && steepest > 0.5 * field.steepest(), "{steepest}");
        // 1e-6 covers the rounding of the difference quotient; the bound is attained within a small factor.
        assert!(largest <= bound + 1e-6 && largest > 0.3 * bound, "{largest} against {bound}");
    }
}
