//! The variances of blocks in a file, from those of its pixels and a few numbers.
//!
//! A block of N pixels has the variance sum v_i / N^2 where its pixels are independent. What neighbours share
//! (photons, texels) adds to it. Shared light is smooth: in each pixel it has at most the variance of the block's
//! quiet pixels, the lower quartile q; what a pixel has above is its own (the glint of an LED). With s_i^2 = min(v_i,
//! q), the block's variance is
//!
//! ```text
//! (sum v_i + g ((sum s_i)^2 - sum s_i^2)) / N^2
//! ```
//!
//! where g is the share of s_i^2 that is common: one number for the blocks of one edge in a tile of the image, fitted
//! to the variances that the replicates gave. On `contact-disc` at 96 x 72 pixels nine tenths of the blocks of 4 are
//! within -25 and +90 % of their variance over many seeds, where a block's own 16 replicates leave ± 37 % each.

use super::Film;
use super::blocks::{EDGES, Grid};
use serde::{Deserialize, Serialize};

/// Most tiles of an image along x and y.
const TILES: [usize; 2] = [8, 6];
/// A pixel's share in the order of a block's variances that marks the quiet ones.
const QUIET: f64 = 0.25;
/// The least share kept, 2 to this power; shares grow by 2^(1/8) from byte to byte.
const LEAST_EXPONENT: f64 = -20.0;

/// How much of their noise the pixels of the blocks of one edge share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sharing {
    /// Edge of a block, pixels; 0: the whole image.
    pub edge: u32,
    /// The share g of each tile, row-major, to 4.5 %; 0 where nothing is shared.
    #[serde(with = "shares")]
    pub shares: Vec<f64>,
}

/// A share in a byte: 0, or the binary logarithm in steps of 1/8.
mod shares {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(shares: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> = shares.iter().map(|share| super::coded(*share)).collect();
        serializer.serialize_str(&STANDARD.encode(bytes))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = STANDARD.decode(text).map_err(D::Error::custom)?;
        Ok(bytes.into_iter().map(super::decoded).collect())
    }
}

fn coded(share: f64) -> u8 {
    if share > 0.0 { ((share.log2() - LEAST_EXPONENT) * 8.0).round().clamp(0.0, 255.0) as u8 } else { 0 }
}

fn decoded(byte: u8) -> f64 {
    if byte == 0 { 0.0 } else { (f64::from(byte) / 8.0 + LEAST_EXPONENT).exp2() }
}

impl Sharing {
    /// Whether it is of an image of this size.
    pub fn fits(&self, width: u32, height: u32) -> bool {
        let [across, down] = tiles(Grid::new(width, height, self.edge));
        EDGES.contains(&self.edge) && self.shares.len() == across * down
    }
}

fn tiles(grid: Grid) -> [usize; 2] {
    [TILES[0].min(grid.columns as usize), TILES[1].min(grid.rows as usize)]
}

fn tile_of(grid: Grid, block: usize) -> usize {
    let ([across, down], columns) = (tiles(grid), grid.columns as usize);
    block / columns * down / grid.rows as usize * across + block % columns * across / columns
}

/// What independent noise leaves in the variance of a block's mean, and what noise adds that its pixels share in
/// whole.
#[derive(Debug, Clone, Copy, Default)]
struct Parts {
    independent: f64,
    common: f64,
}

/// Both for each block.
fn parts(film: &Film, grid: Grid) -> Vec<Parts> {
    let mut blocks: Vec<Vec<f64>> = vec![Vec::new(); grid.cells()];
    for (index, &variance) in film.variance.iter().enumerate() {
        if let Some(block) = blocks.get_mut(grid.block_of(index)) {
            block.push(variance.into());
        }
    }
    let of = |mut variances: Vec<f64>| {
        let count = variances.len().max(1) as f64;
        variances.sort_by(f64::total_cmp);
        let lit = variances.partition_point(|&v| v <= 0.0);
        let quiet = variances.get(lit + ((variances.len() - lit) as f64 * QUIET) as usize).copied().unwrap_or(0.0);
        let (mut sum, mut smooth, mut squares) = (0.0, 0.0, 0.0);
        for variance in variances {
            let shared = variance.min(quiet);
            sum += variance;
            smooth += shared.sqrt();
            squares += shared;
        }
        Parts { independent: sum / (count * count), common: (smooth * smooth - squares).max(0.0) / (count * count) }
    };
    blocks.into_iter().map(of).collect()
}

impl Film {
    /// What pixels share, fitted to the variances of this film's blocks by least squares of relative errors.
    #[must_use]
    pub fn sharing(&self) -> Vec<Sharing> {
        let level = |level: &super::BlockLevel| {
            let grid = Grid::new(self.width, self.height, level.edge);
            let mut fits = vec![[0.0; 2]; tiles(grid).iter().product::<usize>()];
            for (block, (part, &variance)) in parts(self, grid).into_iter().zip(&level.variance).enumerate() {
                let whole = part.independent + part.common;
                if let (Some([above, below]), true) = (fits.get_mut(tile_of(grid, block)), part.common > 0.0) {
                    *above += (f64::from(variance) - part.independent) * part.common / (whole * whole);
                    *below += part.common * part.common / (whole * whole);
                }
            }
            let share = |[above, below]: [f64; 2]| if below > 0.0 { decoded(coded(above / below)) } else { 0.0 };
            Sharing { edge: level.edge, shares: fits.into_iter().map(share).collect() }
        };
        self.blocks.iter().map(level).collect()
    }

    /// This film with blocks made from its pixels and what they share.
    #[must_use]
    pub fn with_sharing(self, sharing: &[Sharing]) -> Self {
        self.with_block_variances(|film, grid| {
            let shares = sharing.iter().find(|entry| entry.edge == grid.edge).map_or(&[][..], |entry| &entry.shares);
            let share = |block: usize| shares.get(tile_of(grid, block)).copied().unwrap_or(0.0);
            let parts = parts(film, grid).into_iter().enumerate();
            parts.map(|(block, part)| part.independent + share(block) * part.common).collect()
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::BlockAccumulator;
    use crate::film::compare::tests::Noise;

    #[test]
    fn shares_survive_their_byte() {
        for share in [2e-6, 0.01, 1.0, 3.0, 1000.0] {
            assert!((decoded(coded(share)) / share - 1.0).abs() < 0.045, "{share}");
        }
        assert_eq!((coded(0.0), coded(-1.0), decoded(0)), (0, 0, 0.0));
    }

    #[test]
    fn blocks_of_smooth_noise_and_of_glints_keep_their_variances() {
        // Replicates of common noise 0.01 in all pixels of a square of 16 and own noise of 0.01; each 13th pixel a
        // glint with noise 1.
        let mut noise = Noise(3);
        let mut sums = BlockAccumulator::new(64, 48);
        for _ in 0..400 {
            let shared: Vec<f64> = (0..12).map(|_| noise.normal()).collect();
            let image = (0..64 * 48_usize).map(|k| {
                let common = shared[k / 64 / 16 * 4 + k % 64 / 16];
                let own = noise.normal() * if k % 13 == 0 { 1.0 } else { 0.01 };
                10.0 + 0.01 * common + own
            });
            sums.add(&image.collect::<Vec<_>>()).unwrap();
        }
        let film = sums.finish();
        let again = Film { blocks: Vec::new(), ..film.clone() }.with_sharing(&film.sharing());
        for (measured, rebuilt) in film.blocks.iter().zip(&again.blocks) {
            let sum = |variance: &[f32]| variance.iter().map(|&v| f64::from(v)).sum::<f64>();
            let ratio = sum(&rebuilt.variance) / sum(&measured.variance);
            assert!((ratio - 1.0).abs() < 0.1, "{}: {ratio}", measured.edge);
        }
        // Blocks of 4 without a glint: 1e-4 (1 + 1/16); of independent pixels they would have 2e-4/16.
        let quiet = again.blocks[0].variance.iter().fold(f32::INFINITY, |least, &v| least.min(v)) * 400.0;
        assert!((quiet / 1.06e-4 - 1.0).abs() < 0.3, "{quiet}");
    }
}
