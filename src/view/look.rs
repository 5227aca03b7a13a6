//! An image as the page shows it.

use crate::pages::side::side_picture;
use crate::pipeline::Shot;
use serde_json::{Value, json};
use std::error::Error;

/// An image, and all that is said of it.
#[derive(Debug)]
pub struct Look {
    /// The wish that it answers.
    pub wish: u64,
    /// Which of the wish's images it is, from 1.
    pub step: usize,
    /// Whether it is the image that `render` makes of the scene.
    pub is_last: bool,
    /// Little-endian: width, height and top grey level as u32, then row by row the grey levels as u16, the radiances
    /// and their standard errors as f32, W/(m^2 sr); before each list zeros to a multiple of four bytes.
    pub pixels: Vec<u8>,
    /// The section through the scene, as SVG.
    pub side: String,
    /// The keys of `render --json`, with the truth.
    pub said: Value,
}

impl Look {
    pub(super) fn of(
        shot: &Shot,
        truth: &Value,
        wish: u64,
        step: usize,
        is_last: bool,
    ) -> Result<Self, Box<dyn Error>> {
        let mut said = json!(shot.summary());
        said["truth"] = truth.clone();
        let side = side_picture(shot.prepared, shot.prepared.streams.seed)?;
        Ok(Self { wish, step, is_last, pixels: pixels(shot), side, said })
    }
}

fn pixels(shot: &Shot) -> Vec<u8> {
    let (frame, film) = (&shot.frame, &shot.outcome.film);
    let errors = shot.outcome.unseen.variances(film).into_iter().map(f32::sqrt);
    let mut bytes = Vec::with_capacity(16 + 10 * frame.grey.len());
    for number in [frame.width, frame.height, u32::from(frame.top_grey())] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(frame.grey.iter().flat_map(|grey| grey.to_le_bytes()));
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes.extend(film.mean.iter().copied().chain(errors).flat_map(f32::to_le_bytes));
    bytes
}
