//! How far two films are apart, pixel by pixel, whatever their noise.

use super::error::CompareError;
use crate::film::Film;
use serde::Serialize;

/// What pixels may differ by: either of both.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Tolerance {
    /// Share of the larger of both radiances.
    pub relative: f64,
    /// Radiance, W/(m^2 sr).
    pub absolute: f64,
}

/// One pixel that differs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// `mean` or `variance`.
    pub channel: &'static str,
    /// Row, from 1 at the top.
    pub row: usize,
    /// Column, from 1 at the left.
    pub column: usize,
    /// Value in the first film.
    pub a: f32,
    /// Value in the second film.
    pub b: f32,
}

impl Deviation {
    fn absolute(&self) -> f64 {
        (f64::from(self.b) - f64::from(self.a)).abs()
    }

    fn relative(&self) -> f64 {
        let larger = f64::from(self.a.abs().max(self.b.abs()));
        if larger > 0.0 { self.absolute() / larger } else { 0.0 }
    }
}

/// How two films deviate.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviations {
    /// Whether none is larger than allowed.
    pub passed: bool,
    /// What is allowed; none: not a bit, in means and variances.
    pub tolerance: Option<Tolerance>,
    /// Pixels in each film.
    pub pixels: usize,
    /// Values outside of what is allowed.
    pub outside: usize,
    /// The first of them, row by row, means before variances.
    pub first: Option<Deviation>,
    /// Largest deviation of a mean over the larger of both.
    pub largest_relative: f64,
    /// Largest deviation of a mean, W/(m^2 sr).
    pub largest_absolute: f64,
}

/// Looks at every pixel: at its mean where there is a tolerance, at the bits of mean and variance where there is none.
///
/// # Errors
/// When the sizes differ.
pub fn deviations(a: &Film, b: &Film, tolerance: Option<Tolerance>) -> Result<Deviations, CompareError> {
    if (a.width, a.height) != (b.width, b.height) {
        let [first, second] = [a, b].map(|film| [film.width, film.height]);
        return Err(CompareError::Size { first, second });
    }
    let width = a.width.max(1) as usize;
    let pairs = |channel: &'static str, a: &[f32], b: &[f32]| -> Vec<Deviation> {
        let pair = |(k, (&a, &b)): (usize, (&f32, &f32))| Deviation {
            channel,
            row: k / width + 1,
            column: k % width + 1,
            a,
            b,
        };
        a.iter().zip(b).enumerate().map(pair).collect()
    };
    let means = pairs("mean", &a.mean, &b.mean);
    let largest = |size: fn(&Deviation) -> f64| means.iter().map(size).fold(0.0, f64::max);
    let (largest_relative, largest_absolute) = (largest(Deviation::relative), largest(Deviation::absolute));
    let outside: Vec<Deviation> = match tolerance {
        Some(Tolerance { relative, absolute }) => {
            let within = |pixel: &Deviation| pixel.absolute() <= absolute || pixel.relative() <= relative;
            means.iter().filter(|pixel| !within(pixel)).copied().collect()
        }
        None => {
            let variances = pairs("variance", &a.variance, &b.variance);
            means.iter().copied().chain(variances).filter(|pixel| pixel.a.to_bits() != pixel.b.to_bits()).collect()
        }
    };
    Ok(Deviations {
        passed: outside.is_empty(),
        tolerance,
        pixels: a.mean.len(),
        outside: outside.len(),
        first: outside.first().copied(),
        largest_relative,
        largest_absolute,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn film(change: impl Fn(usize) -> f32) -> Film {
        let mean = (0..12).map(|k| 1.0 + change(k)).collect();
        Film { width: 4, height: 3, mean, variance: vec![0.5; 12], ..Film::default() }
    }

    #[test]
    fn a_single_bit_is_found_with_its_place() {
        let same = film(|_| 0.0);
        let bit = film(|k| if k >= 6 { f32::EPSILON } else { 0.0 });
        assert!(deviations(&same, &same, None).unwrap().passed);
        let found = deviations(&same, &bit, None).unwrap();
        let first = found.first.unwrap();
        assert!(!found.passed && found.outside == 6);
        assert_eq!((first.channel, first.row, first.column), ("mean", 2, 3));
        let mut noisier = same.clone();
        noisier.variance[0] = 0.6;
        assert_eq!(deviations(&same, &noisier, None).unwrap().first.unwrap().channel, "variance");
    }

    #[test]
    fn tolerances_are_relative_or_absolute() {
        let (a, b) = (film(|_| 0.0), film(|k| if k == 5 { 0.25 } else { 0.0 }));
        let passed = |relative, absolute| deviations(&a, &b, Some(Tolerance { relative, absolute })).unwrap().passed;
        // 0.25 of 1.25.
        assert!(passed(0.2, 0.0) && !passed(0.19, 0.0));
        assert!(passed(0.0, 0.25) && !passed(0.0, 0.24));
        let found = deviations(&a, &b, Some(Tolerance::default())).unwrap();
        assert_eq!((found.outside, found.largest_relative, found.largest_absolute), (1, 0.2, 0.25));
        let other = Film { width: 3, height: 4, ..a.clone() };
        assert!(matches!(deviations(&a, &other, None), Err(CompareError::Size { .. })));
    }
}
