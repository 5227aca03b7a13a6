//! Smoothing of a density over a face whose edges it must not feel.
//!
//! The kernel is three boxes along each axis. A straight line is fitted with it about each texel, over the area that
//! there is (local linear regression: Fan and Gijbels 1996, Local Polynomial Modelling), so slopes are kept up to the
//! edges. That, S, is used as 2 S - S S: the twiced kernel has no second moment, so where the density varies smoothly
//! the bias falls with the fourth power of the width (Stuetzle and Mittal 1979).

/// Smooths densities over one face with one width.
pub struct Smoother {
    columns: usize,
    mirrored: [bool; 2],
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
    /// For a face of `columns` texels in a row with these areas, which along each axis may go on beyond its upper end
    /// as its mirror image; boxes of `width` texels (odd; 1 does nothing).
    pub fn new(area: &[f64], columns: usize, mirrored: [bool; 2], width: usize) -> Self {
        let window = window(area, columns, mirrored);
        let mut smoother = Self { columns, mirrored, width, window, area: Vec::new(), fit: Vec::new() };
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
        [self.along_axis(0, k % self.window[2]), self.along_axis(1, k / self.window[2])]
    }

    /// Place of a column or row: from the mirror, if there is one, so that powers of it are their own images or their
    /// negatives.
    fn along_axis(&self, axis: usize, k: usize) -> f64 {
        k as f64 - if self.mirrored[axis] { self.window[2 + axis] as f64 - 0.5 } else { 0.0 }
    }

    /// Sums under the kernel of a field times powers, up to 2, of the place.
    fn sum(&self, field: &[f64], powers: [usize; 2]) -> Vec<f64> {
        let power = |place: f64, power: usize| [1.0, place, place * place][power];
        let field = field.iter().enumerate().map(|(k, v)| {
            let place = self.place(k);
            v * power(place[0], powers[0]) * power(place[1], powers[1])
        });
        self.across(&self.along(field.collect(), powers[1]), powers[0])
    }

    /// Sums under the kernel of a field, and of it times the place along both axes.
    fn moments(&self, field: Vec<f64>) -> [Vec<f64>; 3] {
        let [_, _, columns, rows] = self.window;
        let times = |field: &[f64], length: usize, axis: usize| -> Vec<f64> {
            let lines = field.chunks(length).enumerate();
            lines.flat_map(|(k, line)| line.iter().map(move |v| v * self.along_axis(axis, k))).collect()
        };
        let times_y = self.along(times(&field, columns, 1), 1);
        let along = self.along(field, 0);
        let times_x = times(&along, rows, 0);
        [self.across(&along, 0), self.across(&times_x, 1), self.across(&times_y, 0)]
    }

    /// The kernel along y of a field by rows, times that power of the place; by columns afterwards.
    fn along(&self, mut field: Vec<f64>, power: usize) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        (0..3).for_each(|_| boxes(&mut field, columns, self.width, self.beyond(1, power)));
        turned(&field, columns, rows)
    }

    /// The kernel along x of a field by columns; by rows afterwards.
    fn across(&self, field: &[f64], power: usize) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        let mut field = field.to_vec();
        (0..3).for_each(|_| boxes(&mut field, rows, self.width, self.beyond(0, power)));
        turned(&field, rows, columns)
    }

    /// What a value beyond the upper end of an axis is of its mirror image, times that power of the place.
    fn beyond(&self, axis: usize, power: usize) -> f64 {
        match (self.mirrored[axis], power % 2) {
            (false, _) => 0.0,
            (true, 0) => 1.0,
            (true, _) => -1.0,
        }
    }
}

/// The least rectangle that holds all area, and reaches to the mirrors: first column and row, columns and rows.
fn window(area: &[f64], columns: usize, mirrored: [bool; 2]) -> [usize; 4] {
    let there = || area.iter().enumerate().filter(|(_, area)| **area > 0.0).map(|(k, _)| [k % columns, k / columns]);
    let whole = [columns, area.len() / columns.max(1)];
    let bounds = |axis: usize| {
        let low = there().map(|place| place[axis]).min().unwrap_or(0);
        let high = there().map(|place| place[axis] + 1).max().unwrap_or(low);
        (low, if mirrored[axis] { whole[axis] } else { high } - low)
    };
    let ((x, width), (y, height)) = (bounds(0), bounds(1));
    [x, y, width.max(1), height.max(1)]
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

/// Means of `width` neighbours in each column, all columns side by side; before the first row there is nothing, beyond
/// the last the mirror images of rows times `beyond`.
fn boxes(field: &mut [f64], columns: usize, width: usize, beyond: f64) {
    let (half, each) = (width / 2, 1.0 / width as f64);
    let (before, rows) = (field.to_vec(), field.len() / columns.max(1));
    let mut sums = vec![0.0; columns];
    let add = |sums: &mut [f64], y: usize, sign: f64| {
        let (y, sign) = match y {
            _ if y < rows => (y, sign),
            _ if y < 2 * rows && beyond != 0.0 => (2 * rows - 1 - y, sign * beyond),
            _ => return,
        };
        sums.iter_mut().zip(&before[y * columns..][..columns]).for_each(|(sum, v)| *sum += sign * v);
    };
    (0..half).for_each(|y| add(&mut sums, y, 1.0));
    for (y, means) in field.chunks_mut(columns).enumerate() {
        add(&mut sums, y + half, 1.0);
        if y > half {
            add(&mut sums, y - half - 1, -1.0);
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
        let kept = Smoother::new(&area, COLUMNS, [false; 2], 9).smooth(&slope);
        let off = |k: usize| if area[k] > 0.0 { (kept[k] - slope[k]).abs() } else { 0.0 };
        assert!((0..area.len()).all(|k| off(k) < 1e-8));
        let (parabola, middle) = (along(2), 30 * COLUMNS + 32);
        assert!(
            (Smoother::new(&area, COLUMNS, [false; 2], 5).smooth(&parabola)[middle] - parabola[middle]).abs() < 1e-8
        );
    }

    proptest! {
        /// Faces and densities at random that are their own mirror images, smoothed whole and by their part.
        #[test]
        fn a_part_is_smoothed_as_the_whole(
            half in prop::array::uniform2(1usize..24), mirrored in prop::array::uniform2(any::<bool>()),
            width in prop::sample::select(vec![3usize, 9, 27]), seed in any::<u32>(),
        ) {
            let whole = half.map(|n| 2 * n);
            let size = [0, 1].map(|axis| if mirrored[axis] { half[axis] } else { whole[axis] });
            let mut random = crate::camera::noise::PixelRandom::new(seed, 0);
            let missing = random.uniform();
            let mut number = || random.uniform();
            let area: Vec<f64> =
                (0..size[0] * size[1]).map(|_| if number() < missing { 0.0 } else { number() }).collect();
            let density: Vec<f64> = area.iter().map(|_| number()).collect();
            let image = |k: usize| {
                let at = [k % whole[0], k / whole[0]];
                let own = [0, 1].map(|axis| if at[axis] < size[axis] { at[axis] } else { whole[axis] - 1 - at[axis] });
                own[1] * size[0] + own[0]
            };
            let unfold = |part: &[f64]| (0..whole[0] * whole[1]).map(|k| part[image(k)]).collect::<Vec<f64>>();
            let part = Smoother::new(&area, size[0], mirrored, width);
            let all = Smoother::new(&unfold(&area), whole[0], [false; 2], width);
            let near = |part: Vec<f64>, all: Vec<f64>| {
                let pairs = unfold(&part).into_iter().zip(all).zip(unfold(&area));
                pairs.into_iter().all(|((one, other), area)| area <= 0.0 || (one - other).abs() < 1e-7)
            };
            prop_assert!(near(part.smooth(&density), all.smooth(&unfold(&density))));
            prop_assert!(near(part.mean(&density), all.mean(&unfold(&density))));
        }

        #[test]
        fn what_is_far_is_not_felt(width in prop::sample::select(vec![3usize, 7, 13]), place in 0usize..COLUMNS * 50) {
            let area = vec![1.0; COLUMNS * 50];
            let mut light = vec![0.0; area.len()];
            light[place] = 1.0;
            let smooth = Smoother::new(&area, COLUMNS, [false; 2], width).smooth(&light);
            let reach = 6 * (width / 2) + 1;
            let far = |a: usize, b: usize| a.abs_diff(b) > reach;
            for (k, v) in smooth.iter().enumerate() {
                let apart = far(k % COLUMNS, place % COLUMNS) || far(k / COLUMNS, place / COLUMNS);
                prop_assert!(!apart || v.abs() < 1e-9);
            }
        }
    }
}
