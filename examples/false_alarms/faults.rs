//! Faults of the size that a comparison says it would see.

use tirtouch::film::Film;
use tirtouch::film::compare::LevelTest;

/// `b` with another radiance of one pixel, that of median noise; none where no pixel was tested.
pub fn planted_pixel(b: &Film, pixels: &LevelTest) -> Option<Film> {
    let mut faulty = b.clone();
    *faulty.mean.get_mut(pixels.median_cell?)? *= 1.0 + pixels.smallest_change? as f32;
    Some(faulty)
}

/// `b` with another radiance throughout.
pub fn planted_whole(b: &Film, whole: &LevelTest) -> Option<Film> {
    let change = 1.0 + whole.smallest_change? as f32;
    let mut faulty = b.clone();
    faulty.mean.iter_mut().for_each(|mean| *mean *= change);
    faulty.blocks.iter_mut().flat_map(|level| &mut level.mean).for_each(|mean| *mean *= change);
    Some(faulty)
}
