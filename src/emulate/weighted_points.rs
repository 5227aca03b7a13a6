//! Sums over points of a function of their distances from a place, in vectors as wide as the CPU has. What is added in
//! which order stays as it is written: the bits are the same on every CPU.

use std::array;
use std::f64::consts::LOG2_E;

/// Points that are worked at together: a loop over so many compiles to vectors.
const TOGETHER: usize = 64;
/// Sums that are kept apart until the end.
const SUMS: usize = 8;

/// A number of each of some points.
pub type Numbers = [f64; TOGETHER];

/// A function of squares of distances.
pub trait Profile {
    /// Its value for each of the squares.
    fn of(&self, squares: Numbers) -> Numbers;
}

/// Points with a weight each.
#[derive(Debug, Clone)]
pub struct WeightedPoints {
    /// Numbers of a point.
    variables: usize,
    /// Of points that are worked at together each variable, then the weights; these are 0 beyond the last point.
    numbers: Vec<Numbers>,
}

impl WeightedPoints {
    /// Points, each of so many numbers, and their weights.
    pub fn new<P: AsRef<[f64]>>(variables: usize, points: impl IntoIterator<Item = (P, f64)>) -> Self {
        let mut numbers = Vec::new();
        for (k, (point, weight)) in points.into_iter().enumerate() {
            if k.is_multiple_of(TOGETHER) {
                numbers.resize(numbers.len() + variables + 1, [0.0; TOGETHER]);
            }
            let first = numbers.len() - variables - 1;
            for (of_all, number) in numbers[first..].iter_mut().zip(point.as_ref().iter().chain([&weight])) {
                of_all[k % TOGETHER] = *number;
            }
        }
        Self { variables, numbers }
    }

    /// Sum over the points of weight times the profile of the square of the distance from a place.
    pub fn sum(&self, place: &[f64], profile: impl Profile) -> f64 {
        pulp::Arch::new().dispatch(Sum { points: self, place, profile })
    }
}

struct Sum<'a, P> {
    points: &'a WeightedPoints,
    place: &'a [f64],
    profile: P,
}

impl<P: Profile> pulp::NullaryFnOnce for Sum<'_, P> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let mut sums = [0.0; SUMS];
        for some in self.points.numbers.chunks_exact(self.points.variables + 1) {
            let Some((weights, variables)) = some.split_last() else { continue };
            let mut squares = [0.0; TOGETHER];
            for (variable, x) in variables.iter().zip(self.place) {
                for (square, point) in squares.iter_mut().zip(variable) {
                    *square += (x - point) * (x - point);
                }
            }
            let values = self.profile.of(squares);
            for (values, weights) in values.as_chunks::<SUMS>().0.iter().zip(weights.as_chunks::<SUMS>().0) {
                for ((sum, value), weight) in sums.iter_mut().zip(values).zip(weights) {
                    *sum += weight * value;
                }
            }
        }
        sums.iter().sum()
    }
}

/// exp(-square / 2), to two units in the last place; where it is less than 1e-304, that.
#[derive(Debug, Clone, Copy)]
pub struct Gauss;

/// What rounds to a whole number, which is then in the last bits, when it is added.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// The logarithm of 2 in two parts: products of the first with whole numbers below 2^20 are exact.
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Terms of exp that count up to half the logarithm of 2, and 1 / k! for each.
const TERMS: usize = 14;
const INVERSE_FACTORIALS: [f64; TERMS] = {
    let mut inverse = [1.0; TERMS];
    let (mut k, mut product) = (1, 1.0);
    while k < TERMS {
        product *= k as f64;
        inverse[k] = 1.0 / product;
        k += 1;
    }
    inverse
};
/// Powers of e are followed down to this one.
const LEAST: f64 = -700.0;

/// The standard library's exp is a call for each number, which no vector does: e^x = 2^n e^r with r at most half the
/// logarithm of 2 (Muller, Elementary Functions, 3rd ed., section 11.1).
impl Profile for Gauss {
    #[inline(always)]
    fn of(&self, mut squares: Numbers) -> Numbers {
        for square in &mut squares {
            let power = -0.5 * *square;
            // Not `max`, which would take what is no number for the bound.
            let power = if power < LEAST { LEAST } else { power };
            let moved = power * LOG2_E + ROUNDING;
            let whole = moved - ROUNDING;
            let rest = power - whole * LN_2[0] - whole * LN_2[1];
            let mut sum = 0.0;
            for inverse in INVERSE_FACTORIALS.iter().rev() {
                sum = sum * rest + inverse;
            }
            *square = sum * f64::from_bits((moved.to_bits() << 52).wrapping_add(1023 << 52));
        }
        squares
    }
}

/// Student's t of so many degrees of freedom and dimensions, but for a factor: (1 + square / freedom) to the power of
/// minus half of both.
#[derive(Debug, Clone, Copy)]
pub struct Student {
    /// Degrees of freedom.
    pub freedom: u32,
    /// Dimensions.
    pub dimensions: u32,
}

impl Profile for Student {
    #[inline(always)]
    fn of(&self, squares: Numbers) -> Numbers {
        let twice = self.freedom + self.dimensions;
        let near = squares.map(|square| 1.0 / (1.0 + square / f64::from(self.freedom)));
        let mut values = if twice.is_multiple_of(2) { [1.0; TOGETHER] } else { near.map(f64::sqrt) };
        for _ in 0..twice / 2 {
            values = array::from_fn(|k| values[k] * near[k]);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;

    #[test]
    fn profiles_are_those_of_the_standard_library() {
        let mut random = PixelRandom::new(1, 0);
        for round in 0..2_000 {
            // From squares that are tiny to those of the bound, and of them the ends.
            let mut squares: Numbers = array::from_fn(|_| 1_400.0 * random.uniform().powi(1 + round % 8));
            (squares[0], squares[1]) = (0.0, 1_400.0);
            let gauss = Gauss.of(squares);
            let dimensions = 1 + round as u32 % 7;
            let student = Student { freedom: 5, dimensions }.of(squares);
            for ((square, gauss), student) in squares.into_iter().zip(gauss).zip(student) {
                let exact = (-0.5 * square).exp();
                assert!((gauss - exact).abs() <= 2.0 * f64::EPSILON * exact, "{square}: {gauss} {exact}");
                let exact = (1.0 + square / 5.0).powf(-0.5 * (5.0 + f64::from(dimensions)));
                assert!((student - exact).abs() <= 1e-14 * exact, "{square}: {student} {exact}");
            }
        }
        let ends = Gauss.of(array::from_fn(|k| [1e9, f64::INFINITY, f64::NAN, 0.0][k % 4]));
        assert!(ends[0] > 0.0 && ends[0] < 1.1e-304 && ends[1] == ends[0] && ends[2].is_nan() && ends[3] == 1.0);
    }

    #[test]
    fn sums_are_those_of_point_after_point() {
        let mut random = PixelRandom::new(2, 0);
        for count in [0, 1, 63, 64, 65, 200] {
            for variables in 0..6 {
                let mut drawn = |n: usize| (0..n).map(|_| 4.0 * random.uniform() - 2.0).collect::<Vec<f64>>();
                let points: Vec<Vec<f64>> = (0..count).map(|_| drawn(variables)).collect();
                let (weights, place) = (drawn(count), drawn(variables));
                let plain: f64 = points
                    .iter()
                    .zip(&weights)
                    .map(|(point, weight)| {
                        let square: f64 = point.iter().zip(&place).map(|(p, x)| (p - x).powi(2)).sum();
                        weight * (-0.5 * square).exp()
                    })
                    .sum();
                let sum = WeightedPoints::new(variables, points.iter().zip(weights)).sum(&place, Gauss);
                assert!((sum - plain).abs() < 1e-12, "{count} {variables}: {sum} {plain}");
            }
        }
    }
}
