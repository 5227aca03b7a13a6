//! Faults of the size that a comparison says it would see: light that is brighter, and noisier by as much.

use tirtouch::film::Film;
use tirtouch::film::compare::LevelTest;

/// `b` with another radiance of one pixel, that of median noise; none where no pixel was tested.
pub fn planted_pixel(b: &Film, pixels: &LevelTest) -> Option<Film> {
    let (mut faulty, pixel) = (b.clone(), pixels.median_cell?);
    let change = 1.0 + pixels.smallest_change? as f32;
    *faulty.mean.get_mut(pixel)? *= change;
    *faulty.variance.get_mut(pixel)? *= change * change;
    Some(faulty)
}

/// `b` with another radiance throughout.
pub fn planted_whole(b: &Film, whole: &LevelTest) -> Option<Film> {
    let change = 1.0 + whole.smallest_change? as f32;
    let mut faulty = b.clone();
    let levels = faulty.blocks.iter_mut();
    let all =
        levels.map(|level| (&mut level.mean, &mut level.variance)).chain([(&mut faulty.mean, &mut faulty.variance)]);
    for (mean, variance) in all {
        mean.iter_mut().for_each(|mean| *mean *= change);
        variance.iter_mut().for_each(|variance| *variance *= change * change);
    }
    Some(faulty)
}
