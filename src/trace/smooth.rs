//! Smoothing of a density over a face whose edges it must not feel.
//!
//! The kernel is three boxes along each axis. A straight line is fitted with it about each texel, over the area that
//! there is (local linear regression: Fan and Gijbels 1996, Local Polynomial Modelling), so slopes are kept up to the
//! edges. That, S, is used as 2 S - S S: the twiced kernel has no second moment, so where the density varies smoothly
//! the bias falls with the fourth power of the width (Stuetzle and Mittal 1979).
//!
//! Of a face that is its own mirror image along an axis the half is held; the other is seen in the mirror at its end.

/// Smooths densities over one face with one width.
pub struct Smoother {
    columns: usize,
    width: usize,
    /// Along which axes the last texels lie at a mirror.
    mirrors: [bool; 2],
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
    /// For a face of `columns` texels in a row with these areas, mirrored at the end of each row and of each column or
    /// not; boxes of `width` texels (odd; 1 does nothing).
    pub fn new(area: &[f64], columns: usize, mirrors: [bool; 2], width: usize) -> Self {
        let window = window(area, columns, mirrors);
        let mut smoother = Self { columns, width, mirrors, window, area: Vec::new(), fit: Vec::new() };
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
        [self.coordinate(0, k % self.window[2]), self.coordinate(1, k / self.window[2])]
    }

    /// Place along an axis, from the mirror if there is one: odd there.
    fn coordinate(&self, axis: usize, k: usize) -> f64 {
        k as f64 - if self.mirrors[axis] { self.window[2 + axis] as f64 - 0.5 } else { 0.0 }
    }

    /// What a mirror along an axis makes of a field that goes with such a power of the place; 0 where there is none.
    fn mirrored(&self, axis: usize, power: usize) -> f64 {
        if self.mirrors[axis] { [1.0, -1.0][power % 2] } else { 0.0 }
    }

    /// Sums under the kernel of a field times powers, up to 2, of the place.
    fn sum(&self, field: &[f64], powers: [usize; 2]) -> Vec<f64> {
        let power = |axis: usize, k: usize| self.coordinate(axis, k).powi(powers[axis] as i32);
        let mut field = field.to_vec();
        for (y, row) in field.chunks_mut(self.window[2]).enumerate() {
            row.iter_mut().enumerate().for_each(|(x, v)| *v *= power(0, x) * power(1, y));
        }
        self.across(&self.along(field, powers[1]), powers[0])
    }

    /// Sums under the kernel of a field, and of it times the place along both axes.
    fn moments(&self, field: Vec<f64>) -> [Vec<f64>; 3] {
        let [_, _, columns, rows] = self.window;
        let times = |field: &[f64], axis: usize, length: usize| -> Vec<f64> {
            let line = |(k, line): (usize, &[f64])| {
                let at = self.coordinate(axis, k);
                line.iter().map(|v| v * at).collect::<Vec<_>>()
            };
            field.chunks(length).enumerate().flat_map(line).collect()
        };
        let times_y = self.along(times(&field, 1, columns), 1);
        let along = self.along(field, 0);
        let times_x = times(&along, 0, rows);
        [self.across(&along, 0), self.across(&times_x, 1), self.across(&times_y, 0)]
    }

    /// The kernel along y of a field by rows that goes with such a power of y; by columns afterwards.
    fn along(&self, mut field: Vec<f64>, power: usize) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        (0..3).for_each(|_| boxes(&mut field, columns, self.width, self.mirrored(1, power)));
        turned(&field, columns, rows)
    }

    /// The kernel along x of a field by columns that goes with such a power of x; by rows afterwards.
    fn across(&self, field: &[f64], power: usize) -> Vec<f64> {
        let [_, _, columns, rows] = self.window;
        let mut field = field.to_vec();
        (0..3).for_each(|_| boxes(&mut field, rows, self.width, self.mirrored(0, power)));
        turned(&field, rows, columns)
    }
}

/// The least rectangle that holds all area, and reaches to the mirrors: first column and row, columns and rows.
fn window(area: &[f64], columns: usize, mirrors: [bool; 2]) -> [usize; 4] {
    let whole = [columns, area.len() / columns];
    let there = || area.iter().enumerate().filter(|(_, area)| **area > 0.0).map(|(k, _)| [k % columns, k / columns]);
    let bounds = |axis: usize| {
        let low = there().map(|place| place[axis]).min().unwrap_or(0);
        let end = there().map(|place| place[axis] + 1).max().unwrap_or(low);
        (low, if mirrors[axis] && end > low { whole[axis] } else { end } - low)
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

/// Means of `width` neighbours in each column, all columns side by side. Beyond the ends there is nothing, or beyond the
/// last row its mirror image times `mirrored`.
fn boxes(field: &mut [f64], columns: usize, width: usize, mirrored: f64) {
    let (half, each) = (width / 2, 1.0 / width as f64);
    let before = field.to_vec();
    let rows = before.len() / columns.max(1);
    let row = |y: usize| before.get(y * columns..(y + 1) * columns).unwrap_or_default();
    let mut sums = vec![0.0; columns];
    let add = |sums: &mut [f64], y: usize, sign: f64| {
        let (row, sign) = match (2 * rows).checked_sub(y + 1) {
            _ if y < rows => (row(y), sign),
            Some(image) if mirrored != 0.0 => (row(image), sign * mirrored),
            _ => (&[][..], sign),
        };
        sums.iter_mut().zip(row).for_each(|(s, v)| *s += sign * v);
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

    /// A face with a mirror along each axis, and its density: the whole gives the same as the quarter.
    #[test]
    fn half_of_a_face_at_a_mirror_is_smoothed_as_the_whole() {
        let (columns, rows) = (40, 24);
        let fold = |k: usize, n: usize| k.min(2 * n - 1 - k);
        let area = |k: usize| f64::from(u8::from(k % columns + 2 * (k / columns) >= 9));
        let density = |k: usize| ((k * k) % 89) as f64;
        for mirrors in [[true, true], [true, false], [false, true]] {
            let whole = [columns << usize::from(mirrors[0]), rows << usize::from(mirrors[1])];
            let from = |k: usize| fold(k / whole[0], rows) * columns + fold(k % whole[0], columns);
            let unfolded = |value: &dyn Fn(usize) -> f64| (0..whole[0] * whole[1]).map(|k| value(from(k))).collect();
            let (all, light): (Vec<f64>, Vec<f64>) = (unfolded(&area), unfolded(&density));
            let part: Vec<f64> = (0..columns * rows).map(area).collect();
            let own: Vec<f64> = (0..columns * rows).map(density).collect();
            for width in [3, 9, 27] {
                let expected = Smoother::new(&all, whole[0], [false; 2], width);
                let found = Smoother::new(&part, columns, mirrors, width);
                for (expected, found) in
                    [(expected.smooth(&light), found.smooth(&own)), (expected.mean(&light), found.mean(&own))]
                {
                    for (k, value) in expected.iter().enumerate().filter(|(k, _)| all[*k] > 0.0) {
                        assert!(
                            (found[from(k)] - value).abs() < 1e-8,
                            "{mirrors:?} {width}: {value} {}",
                            found[from(k)]
                        );
                    }
                }
            }
        }
    }

    proptest! {
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
