//! Monte Carlo arithmetic (Parker 1997): numbers whose every operation is off by a random rounding error.
//!
//! The twin run in [`Rounded`] asks: which histories could this path have had, had the arithmetic rounded otherwise?
//! Each operation is as inexact as the difference of two tracers that obey the precision Vulkan asks for (in ulps of
//! f32, 2^-23, one half of them the other tracer's): sums and products 1, divisions 3, square roots 3. For exponentials
//! and logarithms 8, and for sines and cosines 2^-20 absolute, which is what drivers deliver (Vulkan would allow
//! 2^-11).

use num_traits::{Float, FromPrimitive, Num, NumCast, One, ToPrimitive, Zero};
use std::cell::Cell;
use std::num::FpCategory;
use std::ops::{Add, Div, Mul, Neg, Rem, Sub};
use tirtouch::trace::model::Real;

/// A number that rounds at random.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Rounded(f64);

const ULP: f64 = f32::EPSILON as f64;

thread_local! {
    static STATE: Cell<u64> = const { Cell::new(1) };
}

/// Chooses this thread's rounding errors.
pub fn reseed(seed: u64) {
    STATE.set(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
}

/// Uniform in [-1, 1): xorshift64* (Vigna 2016).
fn noise() -> f64 {
    let mut x = STATE.get();
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    STATE.set(x);
    (x.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

fn off(v: f64, ulps: f64) -> Rounded {
    Rounded(v * (1.0 + noise() * ulps * ULP))
}

impl Real for Rounded {
    fn of(v: f64) -> Self {
        Self(f64::from_f32(v as f32).unwrap_or(v))
    }
    fn wide(self) -> f64 {
        self.0
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $op:tt, $ulps:literal) => {
        impl $trait for Rounded {
            type Output = Self;
            fn $name(self, b: Self) -> Self {
                off(self.0 $op b.0, $ulps)
            }
        }
    };
}
operator!(Add, add, +, 1.0);
operator!(Sub, sub, -, 1.0);
operator!(Mul, mul, *, 1.0);
operator!(Div, div, /, 3.0);
operator!(Rem, rem, %, 1.0);

impl Neg for Rounded {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Zero for Rounded {
    fn zero() -> Self {
        Self(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Rounded {
    fn one() -> Self {
        Self(1.0)
    }
}

impl Num for Rounded {
    type FromStrRadixErr = num_traits::ParseFloatError;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self)
    }
}

impl ToPrimitive for Rounded {
    fn to_i64(&self) -> Option<i64> {
        self.0.to_i64()
    }
    fn to_u64(&self) -> Option<u64> {
        self.0.to_u64()
    }
    fn to_f64(&self) -> Option<f64> {
        Some(self.0)
    }
}

impl FromPrimitive for Rounded {
    fn from_i64(n: i64) -> Option<Self> {
        f64::from_i64(n).map(Self)
    }
    fn from_u64(n: u64) -> Option<Self> {
        f64::from_u64(n).map(Self)
    }
}

impl NumCast for Rounded {
    fn from<T: ToPrimitive>(n: T) -> Option<Self> {
        n.to_f64().map(Self)
    }
}

macro_rules! forward {
    (constant: $($constant:ident)*; question: $($question:ident)*; exact: $($exact:ident)*;
     inexact: $($inexact:ident $ulps:literal)*; absolute: $($absolute:ident)*; pair: $($pair:ident $pair_ulps:literal)*) => {
        impl Float for Rounded {
            $(fn $constant() -> Self { Self(<f64 as Float>::$constant()) })*
            $(fn $question(self) -> bool { Float::$question(self.0) })*
            $(fn $exact(self) -> Self { Self(Float::$exact(self.0)) })*
            $(fn $inexact(self) -> Self { off(Float::$inexact(self.0), $ulps) })*
            $(fn $absolute(self) -> Self { Self(Float::$absolute(self.0) + noise() * 8.0 * ULP) })*
            $(fn $pair(self, b: Self) -> Self { off(Float::$pair(self.0, b.0), $pair_ulps) })*
            fn max(self, b: Self) -> Self { Self(self.0.max(b.0)) }
            fn min(self, b: Self) -> Self { Self(self.0.min(b.0)) }
            fn classify(self) -> FpCategory { self.0.classify() }
            fn integer_decode(self) -> (u64, i16, i8) { Float::integer_decode(self.0) }
            fn mul_add(self, a: Self, b: Self) -> Self { off(self.0 * a.0 + b.0, 1.0) }
            fn powi(self, n: i32) -> Self { off(self.0.powi(n), 8.0) }
            fn sin_cos(self) -> (Self, Self) { (Float::sin(self), Float::cos(self)) }
        }
    };
}
forward! {
    constant: nan infinity neg_infinity neg_zero min_value min_positive_value max_value;
    question: is_nan is_infinite is_finite is_normal is_sign_positive is_sign_negative;
    exact: floor ceil round trunc fract abs signum;
    inexact: recip 3.0 sqrt 3.0 cbrt 8.0 exp 8.0 exp2 8.0 exp_m1 8.0 ln 8.0 log2 8.0 log10 8.0 ln_1p 8.0 tan 8.0 asin 8.0
        acos 8.0 atan 8.0 sinh 8.0 cosh 8.0 tanh 8.0 asinh 8.0 acosh 8.0 atanh 8.0;
    absolute: sin cos;
    pair: powf 8.0 log 8.0 abs_sub 1.0 hypot 3.0 atan2 8.0
}

#[test]
fn rounding_errors_are_of_the_size_of_f32() {
    reseed(7);
    let (third, three) = (Rounded::of(1.0) / Rounded::of(3.0), Rounded::of(3.0));
    let products: Vec<f64> = (0..1000).map(|_| (third * three).wide() - 1.0).collect();
    let largest = products.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    // A division off by up to 3 ulps and a product off by one.
    assert!(largest < 4.0 * ULP && largest > 0.1 * ULP, "{largest}");
    assert!(products.iter().any(|p| *p != products[0]));
}
