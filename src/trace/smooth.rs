//! Smoothing of a density over a face whose edges it must not feel.
//!
//! The kernel is three boxes along each axis. A straight line is fitted with it about each texel, over the area that
//! there is (local linear regression: Fan and Gijbels 1996, Local Polynomial Modelling), so slopes are kept up to the
//! edges. That, S, is used as 2 S - S S: the twiced kernel has no second moment, so where the density varies smoothly
//! the bias falls with the fourth power of the width (Stuetzle and Mittal 1979).

/// Smooths densities over one face with one width.
pub struct Smoother {
    columns: usize,
    width: usize,
    /// The least rectangle that holds the face: first column and row, columns and rows.
    window: [usize; 4],
    /// Areas within the window.
    area: Vec<f64>,
    /// Of each texel: the fit's value there from the sums of density, and of density times distance along both axes.
    fit: Vec<[f64; 3]>,
}

/// Least determinant of a fit, as a share of that of an unbounded face.
const LEAST: f64 = 1e-3;

impl Smoother {
    /// For a face of `columns` texels in a row with these areas; boxes of `width` texels (odd; 1 does nothing).
    pub fn new(area: &[f64], columns: usize, width: usize) -> Self {
        let mut smoother = Self { columns, width, window: window(area, columns), area: Vec::new(), fit: Vec::new() };
        if width > 1 {
            smoother.area = smoother.cut(area);
            let sum = |powers: [usize; 2]| smoother.sum(&smoother.area, powers);
            let sums = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].map(sum);
            // Variance of a box of w texels is (w^2 - 1) / 12.
            let spread = ((width * width - 1) as f64 / 4.0).powi(2);
            let row = |k: usize| fit(sums.each_ref().map(|sum| sum[k]), smoother.place(k), spread);
            smoother.fit = (0..smoother.area.len()).map(row).collect();
        }
        smoother
    }

    /// A smoothed density; 0 beyond the face's rectangle.
    pub fn smooth(&self, density: &[f64]) -> Vec<f64> {
        if self.width <= 1 {
            return density.to_vec();
        }
        let once = self.once(&self.cut(density));
        let twice = self.once(&once);
        self.whole(once.iter().zip(twice).map(|(once, twice)| 2.0 * once - twice), density.len())
    }

    /// Means of a density under the kernel: never below 0 where the density is not.
    pub fn mean(&self, density: &[f64]) -> Vec<f64> {
        let flux: Vec<f64> = self.cut(density).iter().zip(&self.area).map(|(density, area)| density * area).collect();
        let means = self.sum(&flux, [0, 0]).into_iter().zip(self.sum(&self.area, [0, 0]));
        self.whole(means.map(|(flux, area)| if area > 0.0 { flux / area } else { 0.0 }), density.len())
    }

    /// A field of so many texels from the window's part.
    fn whole(&self, part: impl Iterator<Item = f64>, texels: usize) -> Vec<f64> {
        let [x, y, columns, _] = self.window;
        let mut out = vec![0.0; texels];
        for (k, value) in part.enumerate() {
            out[(y + k / columns) * self.columns + x + k % columns] = value;
        }
        out
    }

    /// The window's part of a field.
    fn cut(&self, field: &[f64]) -> Vec<f64> {
        let [x, y, columns, rows] = self.window;
        let row = |row: usize| &field[(y + row) * self.columns + x..][..columns];
        (0..rows).flat_map(|k| row(k).iter().copied()).collect()
    }

    fn once(&self, density: &[f64]) -> Vec<f64> {
        let flux: Vec<f64> = density.iter().zip(&self.area).map(|(density, area)| density * area).collect();
        let [whole, x, y] = self.moments(flux);
        let value = |(k, fit): (usize, &[f64; 3])| {
            let place = self.place(k);
            fit[0] * whole[k] + fit[1] * (x[k] - place[0] * whole[k]) + fit[2] * (y[k] - place[1] * whole[k])
        };
        self.fit.iter().enumerate().map(value).collect()
    }

    fn place(&self, k: usize) -> [f64; 2] {
        [(k % self.window[2]) as f64, (k / self.window[2]) as f64]
    }

    /// Sums under the kernel of a field times powers, up to 2, of the place.
    fn sum(&self, field: &[f64], powers: [usize; 2]) -> Vec<f64> {
        let power = |x: usize, power: usize| [1.0, x as f64, (x * x) as f64][power];
        let mut field = field.to_vec();
        for (y, row) in field.chunks_mut(self.window[2]).enumerate() {
            row.iter_mut().enumerate().for_each(|(x, v)| *v *= power(x, powers[0]) * power(y, powers[1]));
        }
        self.across(&self.along(field))
    }

    /// Sums under the kernel of a field, and of it times the place along both axes.
    fn moments(&self, field: Vec<f64>) -> [Vec<f64>; 3] {
        let [_, _, columns, rows] = self.window;
        let times = |field: &[f64], length: usize| -> Vec<f64> {
            field.chunks(length).enumerate().flat_map(|(k, line)| line.iter().map(move |v| v * k as f64)).collect()
        };
        let times_y = self.along(times(&field, columns));
        let along = self.along(field);
        let times_x = times(&along, rows);
        [along, times_x, times_y].map(|field| self.across(&field))
    }

    /// The kernel along y of a field by rows; by columns afterwards.
    fn along(&self, mut field: Vec<f64>) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        (0..3).for_each(|_| boxes(&mut field, columns, self.width));
        turned(&field, columns, rows)
    }

    /// The kernel along x of a field by columns; by rows afterwards.
    fn across(&self, field: &[f64]) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        let mut field = field.to_vec();
        (0..3).for_each(|_| boxes(&mut field, rows, self.width));
        turned(&field, rows, columns)
    }
}

/// The least rectangle that holds all area: first column and row, columns and rows.
fn window(area: &[f64], columns: usize) -> [usize; 4] {
    let there = || area.iter().enumerate().filter(|(_, area)| **area > 0.0).map(|(k, _)| [k % columns, k / columns]);
    let bounds = |axis: usize| {
        let low = there().map(|place| place[axis]).min().unwrap_or(0);
        (low, there().map(|place| place[axis] + 1).max().unwrap_or(low) - low)
    };
    let ((x, width), (y, height)) = (bounds(0), bounds(1));
    [x, y, width.max(1), height]
}

/// First row of the inverse of the fit's normal matrix, from the moments of the area about the origin.
fn fit([m, mx, my, mxx, mxy, myy]: [f64; 6], [x, y]: [f64; 2], spread: f64) -> [f64; 3] {
    if m <= 0.0 {
        return [0.0; 3];
    }
    let (a, b) = (mx - x * m, my - y * m);
    let (aa, ab, bb) =
        (mxx - 2.0 * x * mx + x * x * m, mxy - x * my - y * mx + x * y * m, myy - 2.0 * y * my + y * y * m);
    let minors = [aa * bb - ab * ab, b * ab - a * bb, a * ab - b * aa];
    let determinant = m * minors[0] + a * minors[1] + b * minors[2];
    if determinant <= LEAST * m * m * m * spread {
        return [1.0 / m, 0.0, 0.0];
    }
    minors.map(|minor| minor / determinant)
}

/// Means of `width` neighbours in each column, all columns side by side; beyond the ends there is nothing.
fn boxes(field: &mut [f64], columns: usize, width: usize) {
    let (half, each) = (width / 2, 1.0 / width as f64);
    let before = field.to_vec();
    let row = |y: usize| before.get(y * columns..(y + 1) * columns).unwrap_or_default();
    let mut sums = vec![0.0; columns];
    let add = |sums: &mut [f64], row: &[f64], sign: f64| sums.iter_mut().zip(row).for_each(|(s, v)| *s += sign * v);
    (0..half).for_each(|y| add(&mut sums, row(y), 1.0));
    for (y, means) in field.chunks_mut(columns).enumerate() {
        add(&mut sums, row(y + half), 1.0);
        if y > half {
            add(&mut sums, row(y - half - 1), -1.0);
        }
        means.iter_mut().zip(&sums).for_each(|(mean, sum)| *mean = sum * each);
    }
}

/// Rows for columns, in tiles that caches hold.
fn turned(field: &[f64], columns: usize, rows: usize) -> Vec<f64> {
    const TILE: usize = 16;
    let mut turned = vec![0.0; field.len()];
    for y in (0..rows).step_by(TILE) {
        for x in (0..columns).step_by(TILE) {
            for y in y..(y + TILE).min(rows) {
                (x..(x + TILE).min(columns)).for_each(|x| turned[x * rows + y] = field[y * columns + x]);
            }
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const COLUMNS: usize = 64;

    fn along(power: i32) -> Vec<f64> {
        (0..COLUMNS * 50).map(|k| ((k % COLUMNS) as f64).powi(power) + (k / COLUMNS) as f64).collect()
    }

    /// A face without its first rows and beyond a slanted edge.
    fn cut() -> Vec<f64> {
        let there = |k: usize| k >= 700 && k % COLUMNS + k / COLUMNS < 95;
        (0..COLUMNS * 50).map(|k| f64::from(u8::from(there(k)))).collect()
    }

    #[test]
    fn slopes_are_kept_up_to_the_edges_and_parabolas_within() {
        let (area, slope) = (cut(), along(1));
        let kept = Smoother::new(&area, COLUMNS, 9).smooth(&slope);
        let off = |k: usize| if area[k] > 0.0 { (kept[k] - slope[k]).abs() } else { 0.0 };
        assert!((0..area.len()).all(|k| off(k) < 1e-8));
        let (parabola, middle) = (along(2), 30 * COLUMNS + 32);
        assert!((Smoother::new(&area, COLUMNS, 5).smooth(&parabola)[middle] - parabola[middle]).abs() < 1e-8);
    }

    proptest! {
        #[test]
        fn what_is_far_is_not_felt(width in prop::sample::select(vec![3usize, 7, 13]), place in 0usize..COLUMNS * 50) {
            let area = vec![1.0; COLUMNS * 50];
            let mut light = vec![0.0; area.len()];
            light[place] = 1.0;
            let smooth = Smoother::new(&area, COLUMNS, width).smooth(&light);
            let reach = 6 * (width / 2) + 1;
            let far = |a: usize, b: usize| a.abs_diff(b) > reach;
            for (k, v) in smooth.iter().enumerate() {
                let apart = far(k % COLUMNS, place % COLUMNS) || far(k / COLUMNS, place / COLUMNS);
                prop_assert!(!apart || v.abs() < 1e-9);
            }
        }
    }
}
