//! How files kept the variances of their blocks at first: a factor for each. They are still read.

use super::blocks::{EDGES, cells};
use super::{Correlation, Film};
use serde::{Deserialize, Serialize};

/// How much the variances of a level's blocks exceed what independent pixels would give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Inflation {
    /// Edge of a block, pixels; 0: the whole image.
    pub edge: u32,
    /// The median over the blocks that are clear of noise.
    pub factor: f64,
    /// Of each block, row-major, to 4.5 % of the variance; empty: `factor` for all.
    #[serde(with = "factors", default)]
    pub blocks: Vec<f64>,
}

/// A factor in a byte: the binary logarithm in steps of 1/8, from 2^-4 on.
mod factors {
    use base64::{Engine, engine::general_purpose::STANDARD};
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(factors: &[f64], serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> =
            factors.iter().map(|factor| ((factor.log2() + 4.0) * 8.0).round().clamp(0.0, 255.0) as u8).collect();
        serializer.serialize_str(&STANDARD.encode(bytes))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
        let text = String::deserialize(deserializer)?;
        let bytes = STANDARD.decode(text).map_err(D::Error::custom)?;
        Ok(bytes.into_iter().map(|byte| (f64::from(byte) / 8.0 - 4.0).exp2()).collect())
    }
}

impl Film {
    /// This film with blocks made from its pixels: variances as of independent pixels times their `inflation` (1 where it
    /// has none). Cells count as clusters of as many as the largest blocks vary together.
    #[must_use]
    pub fn with_inflation(self, inflation: &[Inflation]) -> Self {
        let mut film = self.with_block_variances(|film, grid| {
            let given = inflation.iter().find(|entry| entry.edge == grid.edge);
            let factor = |block: usize| given.map_or(1.0, |e| e.blocks.get(block).copied().unwrap_or(e.factor));
            let variance: Vec<f64> = film.variance.iter().map(|&v| v.into()).collect();
            let pixels = grid.sums(&vec![1.0; variance.len()]);
            let sums = grid.sums(&variance).into_iter().zip(pixels).enumerate();
            sums.map(|(block, (sum, pixels))| factor(block) * sum / (pixels * pixels).max(1.0)).collect()
        });
        let factor = |edge: u32| inflation.iter().find(|entry| entry.edge == edge).map_or(1.0, |entry| entry.factor);
        let level = |edge: u32| {
            let larger = EDGES.into_iter().filter(|&other| other == 0 || other > edge);
            let together = larger.map(|other| factor(other) / factor(edge)).fold(1.0, f64::max);
            let clusters = cells(film.width, film.height, edge) as f64 / together;
            Correlation::independent(edge, clusters)
        };
        film.correlation = std::iter::once(1).chain(EDGES).filter(|&edge| edge != 0).map(level).collect();
        film
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn factors_of_an_old_file_widen_its_blocks_and_tell_how_many_cells_move_together() {
        // 16 is coded as (4 + 4) * 8 = 64, `@`; four blocks of 4 in an image of 8 x 8.
        let json = r#"[{"edge":4,"factor":16.0,"blocks":"QEBAQA=="},{"edge":0,"factor":16.0,"blocks":"QA=="}]"#;
        let inflation: Vec<Inflation> = serde_json::from_str(json).unwrap();
        assert_eq!(inflation[0].blocks, [16.0; 4]);
        assert_eq!(serde_json::to_string(&inflation).unwrap(), json);
        let film = Film { width: 8, height: 8, mean: vec![1.0; 64], variance: vec![0.5; 64], ..Film::default() };
        let film = film.with_inflation(&inflation);
        assert_eq!(film.blocks[0].variance, [0.5; 4], "0.5 over 16 pixels, 16 times");
        assert_eq!(film.blocks[3].variance, [0.5 / 4.0]);
        // 64 pixels in 4 clusters; the blocks are as many clusters.
        assert_eq!((film.correlation[0].pairs, film.correlation[1].pairs), (0.25, 0.25));
    }

    #[test]
    fn independent_pixels_have_a_factor_of_one() {
        let film = Film { width: 8, height: 8, mean: vec![1.0; 64], variance: vec![0.5; 64], ..Film::default() };
        let film = film.with_inflation(&[]);
        assert_eq!(film.blocks[3].variance, [0.5 / 64.0]);
        assert!(film.blocks.iter().all(|level| level.mean.iter().all(|&mean| mean == 1.0)));
        assert_eq!(film.correlation[0].pairs, 1.0 / 64.0);
    }
}
