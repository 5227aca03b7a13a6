//! Where photons start: evenly over all that a launch may be.
//!
//! The launches of a seed are points of Sobol's sequence (USSR Comput. Math. Math. Phys. 7(4), 86, 1967) with the
//! numbers of Joe and Kuo (SIAM J. Sci. Comput. 30(5), 2635, 2008), each coordinate scrambled at random after Owen
//! (SIAM J. Numer. Anal. 34(5), 1884, 1997) by a hash (Laine and Karras, Comput. Graph. Forum 30(4), 1255, 2011; its
//! numbers are Vegdahl's, 2021). Photon (a, b) of thread a is point a + 2^14 b, so that those which are added later go
//! on where the others ended. docs/decisions/launch.md has what this is worth.

use super::constants::{SCRAMBLE_FIRST, SCRAMBLE_LAST, SCRAMBLE_SECOND};
use super::pcg::pcg3d;
use std::fmt::Write as _;

/// The choice of the LED: the first coordinate, whose points are the numbers themselves with their bits reversed.
pub const LED: usize = 0;
/// The place's distance from the LED's centre.
pub const RADIUS: usize = 1;
/// Its azimuth there.
pub const TURN: usize = 2;
/// The direction's angle to the normal.
pub const POLAR: usize = 3;
/// The direction's azimuth.
pub const AZIMUTH: usize = 4;
/// Whether a clear wall reflects it.
pub const SIDE: usize = 5;

const BITS: usize = u32::BITS as usize;
/// Bits of the numbers of few photons.
const FEW: usize = 18;
/// Names of all but the first, in WGSL.
const NAMES: [&str; 5] = ["radius", "turn", "polar", "azimuth", "side"];
/// Degree, inner coefficients and first numbers of each one's primitive polynomial.
const POLYNOMIALS: [(usize, u32, [u32; 4]); 5] =
    [(1, 0, [1, 0, 0, 0]), (2, 1, [1, 3, 0, 0]), (3, 1, [1, 3, 1, 0]), (3, 2, [1, 1, 1, 0]), (4, 1, [1, 1, 3, 3])];
/// What each bit of a number adds to its point, least digit first: the digits from the last to the first.
const ADDED: [[u32; BITS]; 5] = {
    let mut all = [[0; BITS]; 5];
    let mut k = 0;
    while k < all.len() {
        all[k] = added(POLYNOMIALS[k]);
        k += 1;
    }
    all
};

const fn added((degree, inner, first): (usize, u32, [u32; 4])) -> [u32; BITS] {
    let mut digits = [0u32; BITS];
    let mut k = 0;
    while k < BITS {
        digits[k] = if k < degree {
            first[k] << (BITS - 1 - k)
        } else {
            let mut v = digits[k - degree] ^ (digits[k - degree] >> degree);
            let mut j = 1;
            while j < degree {
                if inner >> (degree - 1 - j) & 1 == 1 {
                    v ^= digits[k - j];
                }
                j += 1;
            }
            v
        };
        k += 1;
    }
    let mut k = 0;
    while k < BITS {
        digits[k] = digits[k].reverse_bits();
        k += 1;
    }
    digits
}

/// A coordinate of a point, the digits from the last to the first.
fn point(number: u32, coordinate: usize) -> u32 {
    match coordinate.checked_sub(1) {
        None => number,
        Some(k) => (0..BITS).filter(|b| number >> b & 1 == 1).fold(0, |sum, b| sum ^ ADDED[k][b]),
    }
}

/// What scrambles a coordinate of a seed's points.
pub fn scramble(seed: u32, coordinate: usize) -> u32 {
    pcg3d([seed, coordinate as u32, 0x736f_626f])[0]
}

/// A coordinate of a point from 0 to 1, in units of 2^-32.
pub fn even(number: u32, coordinate: usize, scramble: u32) -> u32 {
    let mut y = point(number, coordinate);
    y ^= y.wrapping_mul(SCRAMBLE_FIRST);
    y = y.wrapping_add(scramble).wrapping_mul((scramble >> 16) | 1);
    y ^= y.wrapping_mul(SCRAMBLE_SECOND);
    y ^= y.wrapping_mul(SCRAMBLE_LAST);
    y.reverse_bits()
}

/// The points in WGSL: `sobol_NAME(number)` for each coordinate but the first. Written out they are four instructions a
/// bit, and half of them for few photons; a table would be gathered from.
pub fn wgsl() -> String {
    let mut text = String::new();
    for (name, added) in NAMES.iter().zip(&ADDED) {
        let _ = writeln!(text, "fn sobol_{name}(number: u32) -> u32 {{\n    var y = 0u;");
        for (b, digits) in added.iter().enumerate() {
            if b == FEW {
                let _ = writeln!(text, "    if (number < {:#x}u) {{ return y; }}", 1u32 << FEW);
            }
            let _ = writeln!(text, "    y ^= select(0u, {digits:#x}u, (number & {:#x}u) != 0u);", 1u32 << b);
        }
        text.push_str("    return y;\n}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;
    use rayon::prelude::*;
    use std::f64::consts::TAU;

    const SEEDS: u32 = 40;
    const COLUMNS: usize = 10;
    const ROWS: usize = 12;

    fn unit(digits: u32) -> f64 {
        f64::from(digits) / 4_294_967_296.0
    }

    /// Every coordinate has one point in each of 2^k equal parts, and every one of the pairs that matter one in each of
    /// 2^(k-1) parts of equal sides, whatever the scramble.
    #[test]
    fn points_are_even() {
        let points = 1u32 << 10;
        for seed in 0..4 {
            let all: Vec<Vec<u32>> =
                (0..6).map(|k| (0..points).map(|i| even(i, k, scramble(seed, k))).collect()).collect();
            for (k, own) in all.iter().enumerate() {
                let mut parts: Vec<u32> = own.iter().map(|x| x >> 22).collect();
                parts.sort_unstable();
                assert!(parts.iter().copied().eq(0..points), "coordinate {k} of seed {seed}");
            }
            for [a, b] in [[LED, RADIUS], [LED, POLAR], [RADIUS, TURN], [POLAR, AZIMUTH], [TURN, AZIMUTH]] {
                let mut parts: Vec<u32> = all[a].iter().zip(&all[b]).map(|(x, y)| x >> 28 << 4 | y >> 28).collect();
                parts.sort_unstable();
                parts.dedup();
                assert_eq!(parts.len(), 256, "coordinates {a} and {b} of seed {seed}");
            }
        }
    }

    /// Where photons of one of four LEDs, at half the height of a guide of 12 mm, would meet its face within 12 mm:
    /// counts over seeds, less their means, in the noise of random launches. Gives their variance, and the largest
    /// along any pattern of them.
    fn noise(coordinate: impl Fn(u32, usize, u32) -> f64 + Sync) -> [f64; 2] {
        let counts = |seed: u32| -> Vec<f64> {
            let mut counts = vec![0.0; COLUMNS * ROWS];
            for number in 0..1u32 << 18 {
                let x = |k: usize| coordinate(number, k, seed);
                if x(LED) >= 0.25 {
                    continue;
                }
                let (radius, (across, up)) = (1.5 * x(RADIUS).sqrt(), (TAU * x(TURN)).sin_cos());
                let sin_sq = 0.9 * x(POLAR);
                let (aside, rise) = (TAU * x(AZIMUTH)).sin_cos();
                let [aside, rise] = [aside, rise].map(|part| part * sin_sq.sqrt());
                if rise <= 0.0 {
                    continue;
                }
                let steps = (6.0 - radius * up) / rise;
                let (far, along) = ((1.0 - sin_sq).sqrt() * steps, radius * across + aside * steps);
                let (column, row) = ((far - 2.0).floor(), (along + 6.0).floor());
                if column >= 0.0 && row >= 0.0 && column < COLUMNS as f64 && row < ROWS as f64 {
                    counts[column as usize * ROWS + row as usize] += 1.0;
                }
            }
            counts
        };
        let all: Vec<Vec<f64>> = (0..SEEDS).into_par_iter().map(counts).collect();
        let mean = |cell: usize| all.iter().map(|one| one[cell]).sum::<f64>() / f64::from(SEEDS);
        let means: Vec<f64> = (0..COLUMNS * ROWS).map(mean).collect();
        let freedom = f64::from(SEEDS - 1);
        let off = |seed: usize, cell: usize| (all[seed][cell] - means[cell]) / (means[cell] * freedom).sqrt();
        let off = Mat::from_fn(SEEDS as usize, COLUMNS * ROWS, off);
        let shared = &off * off.transpose();
        let trace: f64 = (0..SEEDS as usize).map(|k| shared[(k, k)]).sum();
        let most = shared
            .self_adjoint_eigenvalues(faer::Side::Lower)
            .map_or(f64::INFINITY, |all| all.into_iter().fold(0.0, f64::max));
        [trace / (COLUMNS * ROWS) as f64, most]
    }

    /// Of random launches the variance is 1, and the largest along any pattern (1 + sqrt(120 / 40))^2 = 7.5 (Marchenko
    /// and Pastur, 1967). These have less of both: no pattern shows in an image. The fault is the lattice that was used
    /// before them, whose launches are stripes.
    #[test]
    fn launches_leave_no_stripes() {
        let [variance, most] = noise(|number, k, seed| unit(even(number, k, scramble(seed, k))));
        assert!(variance < 0.5 && most < 5.0, "{variance} {most}");
        let generators = [1u32, 761_135, 257_481, 617_715, 488_567, 94_035];
        let [variance, most] = noise(|number, k, seed| {
            unit(number.reverse_bits().wrapping_mul(generators[k]).wrapping_add(scramble(seed, k)))
        });
        assert!(variance > 1.0 && most > 20.0, "{variance} {most}");
    }
}
