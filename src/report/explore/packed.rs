//! Arrays of numbers as text that a page carries.
//!
//! Each number is a code of 8 or 16 bits: `low + step code`, or `low exp(step (code - 1))` with code 0 for 0. Codes are
//! stored as differences from the one before (their least bytes first, then the others), compressed by deflate with the
//! header of zlib, in base64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::Serialize;
use std::io::Write;

/// How a code becomes a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// Even steps.
    Linear,
    /// Even ratios, and 0.
    Log,
}

/// An array.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Packed {
    law: Law,
    bits: u32,
    count: usize,
    low: f64,
    step: f64,
    data: String,
}

/// A number this far below the greatest becomes 0 where ratios are even: so 16 bits keep each to 0.02 %, 8 to 3 %.
const LEAST_SHARE: [f64; 2] = [1e-12, 1e-6];

impl Packed {
    /// Numbers in even steps. Whole numbers that fit are exact, others are off by at most half of a 65,535th of their
    /// range.
    pub fn linear(values: &[f64]) -> Self {
        let [low, high] = range(values);
        let is_whole = values.iter().all(|value| value.fract() == 0.0);
        let bits = if is_whole && high - low <= 255.0 { 8 } else { 16 };
        let top = f64::from(top(bits));
        let step = if is_whole && high - low <= top { 1.0 } else { (high - low) / top };
        let code = |value: f64| if step > 0.0 { (value - low) / step } else { 0.0 };
        Self::new(Law::Linear, bits, low, step, values.iter().map(|&value| code(value)))
    }

    /// Numbers in 16 bits of even ratios, which keeps each to 0.02 % of itself; in even steps where one is negative.
    pub fn ratios(values: &[f64]) -> Self {
        Self::logarithmic(values, 16)
    }

    /// Numbers in 8 bits of even ratios, such as standard errors: each to 3 % of itself.
    pub fn rough_ratios(values: &[f64]) -> Self {
        Self::logarithmic(values, 8)
    }

    fn logarithmic(values: &[f64], bits: u32) -> Self {
        let [least, high] = range(values);
        if least < 0.0 {
            return Self::linear(values);
        }
        let floor = high * LEAST_SHARE[usize::from(bits == 8)];
        let low = values.iter().copied().filter(|&value| value >= floor && value > 0.0).fold(high, f64::min);
        let step = if low > 0.0 { (high / low).ln() / f64::from(top(bits) - 1) } else { 0.0 };
        let code = |value: f64| match value >= low && value > 0.0 {
            true => 1.0 + if step > 0.0 { (value / low).ln() / step } else { 0.0 },
            false => 0.0,
        };
        Self::new(Law::Log, bits, low, step, values.iter().map(|&value| code(value)))
    }

    fn new(law: Law, bits: u32, low: f64, step: f64, codes: impl Iterator<Item = f64>) -> Self {
        let top = f64::from(top(bits));
        let codes: Vec<u16> = codes.map(|code| code.round().clamp(0.0, top) as u16).collect();
        let mut before = 0;
        let change = |&code: &u16| {
            let change = code.wrapping_sub(before);
            before = code;
            change
        };
        let changes: Vec<u16> = codes.iter().map(change).collect();
        let mut bytes: Vec<u8> = changes.iter().map(|change| *change as u8).collect();
        if bits == 16 {
            bytes.extend(changes.iter().map(|change| (change >> 8) as u8));
        }
        Self { law, bits, count: codes.len(), low, step, data: STANDARD.encode(deflated(&bytes)) }
    }
}

/// Writing into memory does not fail; were it to, the page would have no numbers.
fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.unwrap_or_default()
}

fn top(bits: u32) -> u32 {
    (1 << bits) - 1
}

fn range(values: &[f64]) -> [f64; 2] {
    let first = values.first().copied().unwrap_or(0.0);
    values.iter().fold([first, first], |[low, high], &value| [low.min(value), high.max(value)])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use flate2::read::ZlibDecoder;
    use std::io::Read;

    /// As the page's script does it.
    fn unpacked(packed: &Packed) -> Vec<f64> {
        let mut bytes = Vec::new();
        ZlibDecoder::new(&STANDARD.decode(&packed.data).unwrap()[..]).read_to_end(&mut bytes).unwrap();
        let mut code = 0u16;
        let value = |i: usize| {
            let high = if packed.bits == 16 { u16::from(bytes[packed.count + i]) << 8 } else { 0 };
            code = code.wrapping_add(high + u16::from(bytes[i])) & top(packed.bits) as u16;
            match packed.law {
                Law::Linear => packed.low + packed.step * f64::from(code),
                Law::Log if code == 0 => 0.0,
                Law::Log => packed.low * (packed.step * f64::from(code - 1)).exp(),
            }
        };
        (0..packed.count).map(value).collect()
    }

    #[test]
    fn whole_numbers_come_back_exactly() {
        let cases = [(vec![3.0, 0.0, 255.0, 7.0], 8), (vec![-40.0, 12.0, 200.0], 8), (vec![0.0, 65535.0, 256.0], 16)];
        for (values, bits) in cases {
            let packed = Packed::linear(&values);
            assert_eq!((packed.bits, unpacked(&packed)), (bits, values));
        }
    }

    #[test]
    fn other_numbers_come_back_to_a_share_of_their_range_or_of_themselves() {
        let values: Vec<f64> =
            (0..5000).map(|i| 1e-7 * f64::from(i).powi(2) * (1.0 + 0.3 * f64::from(i % 7))).collect();
        let high = values.iter().copied().fold(0.0, f64::max);
        for (value, back) in values.iter().zip(unpacked(&Packed::linear(&values))) {
            assert!((value - back).abs() <= 0.5001 * high / 65535.0, "{value} {back}");
        }
        // Half a step: 27.6 of natural logarithm in 65,534 steps, 13.8 in 254.
        for (packed, most) in [(Packed::ratios(&values), 2.2e-4), (Packed::rough_ratios(&values), 2.8e-2)] {
            let floor = high * LEAST_SHARE[usize::from(packed.bits == 8)];
            for (&value, back) in values.iter().zip(unpacked(&packed)) {
                assert!((value - back).abs() <= most * value || value < floor && back == 0.0, "{value} {back}");
            }
        }
    }

    #[test]
    fn what_is_empty_even_dark_or_negative_is_packed() {
        for values in [vec![], vec![0.0; 4], vec![2.5; 3], vec![0.0, 0.7]] {
            for packed in [Packed::linear(&values), Packed::ratios(&values), Packed::rough_ratios(&values)] {
                let back = unpacked(&packed);
                assert!(back.len() == values.len(), "{back:?}");
                assert!(back.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-9), "{values:?} {back:?}");
            }
        }
        assert_eq!(Packed::ratios(&[-1.0, 1.5]).law, Law::Linear);
    }
}
