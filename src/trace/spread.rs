//! Light that spreads sideways in the tissue: what enters here leaves around here.
//!
//! Light that enters the tissue survives with the chance a (its albedo), leaves it at a distance r of the
//! Christensen-Burley profile p(r) = (exp(-r/d) + exp(-r/3d)) / (8 pi d r) and is mirrored back at the boundary with a
//! chance rho. So the exitance B towards the boundary is that of B = a p * (Phi + rho B) where there is tissue, * the
//! convolution, Phi what enters. Where tissue is a half space, Phi and B are two numbers, what leaves towards the map's
//! two directions (`scatter.rs`): a is in Phi and in rho, which then mixes both. Photons could draw each such step; the
//! convolution, by Fourier transforms, adds no noise and takes most of what Phi has (docs/decisions/spreading.md).
//!
//! B is a series. Half of the largest rho, m, is the same everywhere and is summed by the transform itself: with
//! G = a p / (1 - m a p), B = G * (Phi + (rho - m) B); beyond the map, too, -m is taken off. Of the phantoms' tissue 14
//! terms become 8. In f32, of light over its largest: camera paths read the map so.

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// How far the grid reaches beyond the map, in units of the profile's longer length 3 d: exp(-8) is left there.
const MARGIN: f64 = 8.0;
/// The series ends where what it leaves is about this share of the whole.
const TOLERANCE: f64 = 1e-5;
/// Most terms; tissue, which mirrors back up to 0.7 of what comes, takes 15.
const TERMS: usize = 400;

/// Spreads maps of one grid.
pub struct Spread {
    columns: usize,
    rows: usize,
    /// Size of the padded grid.
    size: [usize; 2],
    /// Spectrum of G, with the area of a texel, over the number of cells; real, since the profile is even.
    spectrum: Vec<f32>,
    /// What the boundary mirrors back into the tissue of the two maps beyond m, rows `[to][from]`; of the padded grid.
    reentry: Vec<[[f32; 2]; 2]>,
    plans: [[Arc<dyn Fft<f32>>; 2]; 2],
}

impl Spread {
    /// Prepares a grid of texels of `texel_mm` with the profile's length `d_mm`; `reentry` per texel.
    pub fn new(columns: usize, texel_mm: [f64; 2], d_mm: f64, albedo: f64, reentry: Vec<[[f64; 2]; 2]>) -> Self {
        let rows = reentry.len() / columns;
        let size = [0, 1].map(|axis| {
            let margin = (MARGIN * 3.0 * d_mm / texel_mm[axis]).ceil() as usize;
            smooth_number([columns, rows][axis] + margin)
        });
        let mut planner = FftPlanner::new();
        let plans = [true, false].map(|forward| {
            size.map(|n| if forward { planner.plan_fft_forward(n) } else { planner.plan_fft_inverse(n) })
        });
        let largest = reentry.iter().flatten().map(|[one, other]| one.abs() + other.abs()).fold(0.0, f64::max);
        let everywhere = 0.5 * largest;
        let beyond = |[[a, b], [c, d]]: [[f64; 2]; 2]| {
            [[a - everywhere, b], [c, d - everywhere]].map(|row| row.map(|value| value as f32))
        };
        let mut padded = vec![beyond([[0.0; 2]; 2]); size[0] * size[1]];
        for (row, given) in padded.chunks_mut(size[0]).zip(reentry.chunks(columns)) {
            row.iter_mut().zip(given).for_each(|(entry, given)| *entry = beyond(*given));
        }
        let reentry = padded;
        let mut spread = Self { columns, rows, size, spectrum: Vec::new(), reentry, plans };
        let cells = (size[0] * size[1]) as f64;
        let mut kernel = profile(size, texel_mm, d_mm);
        spread.transform(&mut kernel, true);
        let summed = |value: Complex<f32>| {
            let once = albedo * f64::from(value.re);
            (once / (1.0 - everywhere * once) / cells) as f32
        };
        spread.spectrum = kernel.into_iter().map(summed).collect();
        spread
    }

    /// Exitance of two maps at once, from the flux that enters: the kernel is even, so one may travel as the imaginary
    /// part.
    pub fn exitance(&self, entering: [&[f64]; 2]) -> [Vec<f64>; 2] {
        let (mut source, unit) = self.padded(entering);
        let mut total = vec![Complex::new(0.0, 0.0); source.len()];
        let mut before = f64::sqrt(source.iter().map(|v| f64::from(v.norm_sqr())).sum());
        for _ in 0..TERMS {
            source = self.convolved(source);
            let (mut last, mut whole) = (0.0f64, 0.0f64);
            for ((total, source), reentry) in total.iter_mut().zip(&mut source).zip(&self.reentry) {
                *total += *source;
                let back = reentry.map(|[re, im]| re * source.re + im * source.im);
                *source = Complex::new(back[0], back[1]);
                last += f64::from(source.norm_sqr());
                whole += f64::from(total.norm_sqr());
            }
            // What is left falls about as the last terms did.
            let (last, falls) = (last.sqrt(), if before > 0.0 { last.sqrt() / before } else { 0.0 });
            if last <= (1.0 - falls) * TOLERANCE * whole.sqrt() {
                break;
            }
            before = last;
        }
        self.cut(&total, unit)
    }

    /// The first term of it, of two maps that have nothing to do with each other.
    pub fn first_term(&self, entering: [&[f64]; 2]) -> [Vec<f64>; 2] {
        let (source, unit) = self.padded(entering);
        self.cut(&self.convolved(source), unit)
    }

    /// Two maps on the padded grid, over their largest value.
    fn padded(&self, entering: [&[f64]; 2]) -> (Vec<Complex<f32>>, f64) {
        let largest = entering.iter().copied().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
        let unit = if largest > 0.0 { largest } else { 1.0 };
        let mut grid = vec![Complex::new(0.0, 0.0); self.size[0] * self.size[1]];
        let rows = entering[0].chunks(self.columns).zip(entering[1].chunks(self.columns));
        for (row, (re, im)) in grid.chunks_mut(self.size[0]).zip(rows) {
            for (cell, (re, im)) in row.iter_mut().zip(re.iter().zip(im)) {
                *cell = Complex::new((re / unit) as f32, (im / unit) as f32);
            }
        }
        (grid, unit)
    }

    /// The maps' part of a padded grid.
    fn cut(&self, grid: &[Complex<f32>], unit: f64) -> [Vec<f64>; 2] {
        let light = |part: fn(&Complex<f32>) -> f32| {
            let rows = grid.chunks(self.size[0]).take(self.rows);
            rows.flat_map(|row| row[..self.columns].iter().map(|v| unit * f64::from(part(v)))).collect()
        };
        [light(|v| v.re), light(|v| v.im)]
    }

    fn convolved(&self, mut grid: Vec<Complex<f32>>) -> Vec<Complex<f32>> {
        self.transform(&mut grid, true);
        grid.iter_mut().zip(&self.spectrum).for_each(|(v, s)| *v *= s);
        self.transform(&mut grid, false);
        grid
    }

    /// Fourier transform over both axes, without a factor; the forward one leaves the grid transposed, the other turns
    /// it back.
    fn transform(&self, grid: &mut Vec<Complex<f32>>, forward: bool) {
        let [columns, rows] = self.size;
        let [ahead, back] = &self.plans;
        if forward {
            ahead[0].process(grid);
            *grid = transposed(grid, columns);
            ahead[1].process(grid);
        } else {
            back[1].process(grid);
            *grid = transposed(grid, rows);
            back[0].process(grid);
        }
    }
}

/// The least number of 2, 3 and 5 as factors that is not below `n`: quick to transform.
fn smooth_number(n: usize) -> usize {
    let left = |m: usize| [2, 3, 5].iter().fold(m, |m, f| (0..64).fold(m, |m, _| if m % f == 0 { m / f } else { m }));
    (n..).find(|&m| left(m) == 1).unwrap_or(n)
}

fn transposed(grid: &[Complex<f32>], columns: usize) -> Vec<Complex<f32>> {
    let rows = grid.len() / columns;
    let mut out = Vec::with_capacity(grid.len());
    for x in 0..columns {
        out.extend((0..rows).map(|y| grid[y * columns + x]));
    }
    out
}

/// Share of the profile in each texel about a source in the middle of texel 0, wrapped about the grid.
fn profile(size: [usize; 2], texel_mm: [f64; 2], d_mm: f64) -> Vec<Complex<f32>> {
    let half = size.map(|n| n / 2 + 1);
    // Integrals from the source to the corners of the texels; the first corner lies half a texel away.
    let corner = |k: usize, axis: usize| (k as f64 + 0.5) * texel_mm[axis];
    let corners: Vec<f64> =
        (0..half[0] * half[1]).map(|k| quarter(corner(k % half[0], 0), corner(k / half[0], 1), d_mm)).collect();
    let at = |x: usize, y: usize| corners[y * half[0] + x];
    let near = |k: usize, n: usize| k.min(n - k);
    let cell = |k: usize| {
        let (x, y) = (near(k % size[0], size[0]), near(k / size[0], size[1]));
        let share = match (x, y) {
            (0, 0) => 4.0 * at(0, 0),
            (x, 0) => 2.0 * (at(x, 0) - at(x - 1, 0)),
            (0, y) => 2.0 * (at(0, y) - at(0, y - 1)),
            (x, y) => at(x, y) - at(x - 1, y) - at(x, y - 1) + at(x - 1, y - 1),
        };
        Complex::new(share as f32, 0.0)
    };
    (0..size[0] * size[1]).map(cell).collect()
}

/// Integral of the profile over the rectangle from the source to (x, y), in polar coordinates.
fn quarter(x: f64, y: f64, d_mm: f64) -> f64 {
    // Of r p(r) from 0 to r.
    let within = |r: f64| ((1.0 - (-r / d_mm).exp()) + 3.0 * (1.0 - (-r / (3.0 * d_mm)).exp())) / (8.0 * PI);
    let wedge = |side: f64, end: f64| {
        // The integrand is even in the angle and bends most at its end: Gauss-Legendre over two halves.
        let halves = [[0.0, 0.5 * end], [0.5 * end, end]];
        let part = |[a, b]: [f64; 2]| -> f64 {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            GAUSS_8.iter().map(|[at, weight]| half * weight * within(side / (middle + half * at).cos())).sum()
        };
        halves.map(part).iter().sum::<f64>()
    };
    let angle = y.atan2(x);
    wedge(x, angle) + wedge(y, FRAC_PI_2 - angle)
}

/// Places and weights of Gauss and Legendre on (-1, 1).
const GAUSS_8: [[f64; 2]; 8] = [
    [-0.960_289_856_497_536_2, 0.101_228_536_290_376_26],
    [-0.796_666_477_413_626_7, 0.222_381_034_453_374_47],
    [-0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [-0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_47],
    [0.960_289_856_497_536_2, 0.101_228_536_290_376_26],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_profile_keeps_all_light() {
        let whole = quarter(60.0, 60.0, 0.4) * 4.0;
        assert!((whole - 1.0).abs() < 1e-9, "{whole}");
        let grid: f64 = profile([400, 320], [0.1, 0.125], 0.4).iter().map(|v| f64::from(v.re)).sum();
        assert!((grid - 1.0).abs() < 1e-6, "{grid}");
    }

    /// Half of the profile lies within the radius where 1 - exp(-r/d)/4 - 3 exp(-r/3d)/4 is one half.
    #[test]
    fn a_disc_holds_what_the_closed_form_says() {
        let (texel, d) = (0.05, 0.4);
        let radius: f64 = 1.0;
        let kernel = profile([400, 400], [texel, texel], d);
        let place = |k: usize| if k < 200 { k as f64 } else { k as f64 - 400.0 } * texel;
        let within: f64 = (0..400 * 400)
            .filter(|k| place(k % 400).hypot(place(k / 400)) <= radius)
            .map(|k| f64::from(kernel[k].re))
            .sum();
        let exact = 1.0 - 0.25 * (-radius / d).exp() - 0.75 * (-radius / (3.0 * d)).exp();
        assert!((within - exact).abs() < 3e-3, "{within} {exact}");
    }

    /// Even light over tissue without end: B = a Phi / (1 - a rho).
    #[test]
    fn even_light_is_a_geometric_series() {
        let (albedo, reentry) = (0.76, 0.5);
        let spread = Spread::new(200, [0.25, 0.25], 0.2, albedo, vec![[[reentry, 0.0], [0.0, reentry]]; 200 * 180]);
        let [once, twice] = spread.exitance([&vec![1.0; 200 * 180], &vec![2.0; 200 * 180]]);
        let middle = 90 * 200 + 100;
        let exact = albedo / (1.0 - albedo * reentry);
        assert!((once[middle] - exact).abs() < 1e-4 * exact, "{} {exact}", once[middle]);
        assert!((twice[middle] - 2.0 * exact).abs() < 2e-4 * exact);
        // Light is lost beyond the edges.
        assert!(once[0] < 0.5 * exact);
    }

    /// Exitance by plain sums over all texels, one return after the other.
    fn summed(
        texel: [f64; 2],
        d: f64,
        albedo: f64,
        reentry: &[[[f64; 2]; 2]],
        columns: usize,
        entering: &[Vec<f64>; 2],
    ) -> Vec<[f64; 2]> {
        let kernel = profile([32, 32], texel, d);
        let share = |a: usize, b: usize| {
            let apart = [(a % columns).abs_diff(b % columns), (a / columns).abs_diff(b / columns)];
            albedo * f64::from(kernel[apart[1] * 32 + apart[0]].re)
        };
        let mut source: Vec<[f64; 2]> = (0..reentry.len()).map(|k| [entering[0][k], entering[1][k]]).collect();
        let mut whole = vec![[0.0; 2]; reentry.len()];
        for _ in 0..120 {
            let sum = |to: usize, map: usize| (0..source.len()).map(|k| share(k, to) * source[k][map]).sum::<f64>();
            let term: Vec<[f64; 2]> = (0..reentry.len()).map(|to| [sum(to, 0), sum(to, 1)]).collect();
            for (k, term) in term.iter().enumerate() {
                (0..2).for_each(|map| whole[k][map] += term[map]);
                source[k] = reentry[k].map(|row| row[0] * term[0] + row[1] * term[1]);
            }
        }
        whole
    }

    /// Grids, profiles, albedos, light from 1e-12 to 1e6 and boundaries at random, which mix the two maps, are missing
    /// in places, and mirror back up to 0.8 of what comes, more than tissue does.
    #[test]
    fn returns_at_random_are_those_of_plain_sums() {
        let random = std::cell::RefCell::new(crate::camera::noise::PixelRandom::new(7, 0));
        let between = |low: f64, high: f64| low + (high - low) * random.borrow_mut().uniform();
        for case in 0..300 {
            let [columns, rows] = [0, 1].map(|_| between(2.0, 13.0) as usize);
            let texel = [0, 1].map(|_| between(0.05, 0.5));
            let (d, albedo, light) = (between(0.02, 0.4), between(0.1, 1.0), 10f64.powf(between(-12.0, 6.0)));
            let (most, gaps) = (between(0.0, 0.8), between(0.0, 0.6));
            let reentry: Vec<[[f64; 2]; 2]> = (0..columns * rows)
                .map(|_| {
                    let row = || {
                        let (all, share) = (between(0.0, most), between(-0.05, 1.0));
                        [all * share, all * (1.0 - share.abs())]
                    };
                    if between(0.0, 1.0) < gaps { [[0.0; 2]; 2] } else { [row(), row()] }
                })
                .collect();
            let entering = [0, 1].map(|_| (0..columns * rows).map(|_| light * between(0.0, 1.0)).collect::<Vec<_>>());
            let expected = summed(texel, d, albedo, &reentry, columns, &entering);
            let found = Spread::new(columns, texel, d, albedo, reentry).exitance([&entering[0], &entering[1]]);
            let largest = expected.iter().flatten().fold(0.0f64, |most, v| most.max(v.abs()));
            for (k, expected) in expected.iter().enumerate() {
                for map in 0..2 {
                    let off = (found[map][k] - expected[map]).abs() / largest;
                    assert!(off < 1e-4, "case {case}: {off:e} off, {most} mirrored back");
                }
            }
        }
        let dark = Spread::new(5, [0.2; 2], 0.1, 0.9, vec![[[0.5, 0.0], [0.0, 0.5]]; 20]);
        assert_eq!(dark.exitance([&[0.0; 20], &[0.0; 20]]), [vec![0.0; 20], vec![0.0; 20]]);
    }

    /// A source beside a region without re-entry: what returns from there is nothing.
    #[test]
    fn what_leaves_beyond_the_tissue_is_lost() {
        let columns = 120;
        let half = |k: usize| if k % columns < 60 { HALF } else { [[0.0; 2]; 2] };
        const HALF: [[f64; 2]; 2] = [[0.5, 0.0], [0.0, 0.5]];
        let part = Spread::new(columns, [0.2, 0.2], 0.3, 0.8, (0..columns * 100).map(half).collect());
        let whole = Spread::new(columns, [0.2, 0.2], 0.3, 0.8, vec![HALF; columns * 100]);
        let mut source = vec![0.0; columns * 100];
        source[50 * columns + 58] = 1.0;
        let at = |spread: &Spread| spread.exitance([&source, &source])[0].iter().sum::<f64>();
        assert!(at(&part) < 0.95 * at(&whole), "{} {}", at(&part), at(&whole));
    }
}
