//! Where two images differ, in false colour.

use super::PageError;
use crate::film::Film;
use crate::film::compare::ROUNDING;
use crate::report::{ColorScale, Raster, false_color};

/// Standard errors beyond which a difference has the last colour: what no noise makes.
const MOST_DEVIATES: f64 = 10.0;

/// B - A of each pixel: in standard errors, or in units of radiance where noise does not count.
pub fn picture(a: &Film, b: &Film, plain: bool) -> Result<String, PageError> {
    let pixel = |k: usize| {
        let value = |values: &[f32]| values.get(k).copied().map_or(0.0, f64::from);
        let [mean_a, mean_b] = [a, b].map(|film| value(&film.mean));
        let difference = mean_b - mean_a;
        if plain || difference == 0.0 {
            return difference;
        }
        let floor = ROUNDING * mean_a.abs().max(mean_b.abs());
        let error = (value(&a.variance) + value(&b.variance) + floor * floor).sqrt();
        (difference / error).clamp(-MOST_DEVIATES, MOST_DEVIATES)
    };
    let values: Vec<f64> = (0..a.mean.len()).map(pixel).collect();
    let (quantity, unit) = if plain { ("B - A", "W/(m² sr)") } else { ("B - A, in standard errors", "") };
    let (width, height) = (a.width as usize, a.height as usize);
    let raster = Raster { width, height, values: &values, quantity, unit, mm_per_pixel: None };
    Ok(false_color("difference", &raster, ColorScale::Linear)?)
}
