//! A part of a sweep's points.

use std::str::FromStr;

/// Part K of N of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    part: u32,
    parts: u32,
}

impl Shard {
    /// Part `part`, from 1, of `parts`; none where there is no such part.
    pub fn new(part: u32, parts: u32) -> Option<Self> {
        (1..=parts).contains(&part).then_some(Self { part, parts })
    }

    /// Its rows: neighbours stay together.
    pub(super) fn of(self, rows: &[usize]) -> Vec<usize> {
        let end = |part: u32| (rows.len() as u64 * u64::from(part) / u64::from(self.parts)) as usize;
        rows.get(end(self.part - 1)..end(self.part)).unwrap_or_default().to_vec()
    }
}

impl FromStr for Shard {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts = text.split_once('/').and_then(|(k, n)| Self::new(k.parse().ok()?, n.parse().ok()?));
        parts.ok_or("it must be K/N with K from 1 to N, as in 3/8")
    }
}
