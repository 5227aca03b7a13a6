//! Whether what is lit is told from noise, and whether it is a spot at all.

use super::image::GreyImage;
use statrs::function::gamma::gamma_lr;

/// Chance of as many lit pixels by noise alone below which what is lit counts as seen.
const LEVEL: f64 = 1e-3;
/// Share of the lit pixels that noise may make before it is said.
const NOISE_SHARE: f64 = 0.05;
/// Share of the frame beyond which what is lit is no spot in it.
const MOST: f64 = 0.5;

/// Says so where `lit` pixels are no more than noise lights: `expected` on average, with the given variance of their
/// number.
///
/// Their number is taken as quasi-Poisson: a Poisson number of clusters of variance/mean pixels each, so
/// P(number >= n) = P(n/c, mean/c), the regularised incomplete gamma function.
pub(super) fn by_noise(lit: usize, expected: f64, variance: f64) -> Option<String> {
    if lit == 0 {
        return None;
    }
    let lit = lit as f64;
    let cluster = if expected > 0.0 { (variance / expected).max(1.0) } else { 1.0 };
    let chance = if expected > 0.0 { gamma_lr(lit / cluster, expected / cluster) } else { 0.0 };
    if chance > LEVEL {
        return Some(format!(
            "what is lit is not told from noise: {lit} pixels are lit, and {expected:.1} would be with nothing to see \
             (as many by chance: {chance:.1e}); d is that of noise"
        ));
    }
    (expected > NOISE_SHARE * lit)
        .then(|| format!("noise alone lights {expected:.0} of the {lit} lit pixels: d is too large by that"))
}

/// Says so where more than half of the frame is lit.
pub(super) fn most_of_the_frame(lit: usize, pixels: usize) -> Option<String> {
    (lit as f64 > MOST * pixels as f64).then(|| {
        format!("{lit} of {pixels} pixels are lit: d is that of the frame, not of a spot in it; subtract a reference")
    })
}

/// Says so where lit pixels lie scattered, as noise of independent pixels would have them: for images whose noise is
/// not known. Compared is the number of neighbouring pairs that are both lit with that of as many pixels in a random
/// order (join counts; Moran 1948).
pub fn scattered(image: &GreyImage, threshold_grey: f64) -> Option<String> {
    let (width, height) = (image.width(), image.height());
    let lit: Vec<bool> = image.grey().iter().map(|grey| *grey > threshold_grey).collect();
    let count = lit.iter().filter(|lit| **lit).count();
    let rows = || lit.chunks_exact(width);
    let across: usize = rows().map(|row| row.windows(2).filter(|pair| pair.iter().all(|lit| *lit)).count()).sum();
    let down: usize =
        rows().zip(rows().skip(1)).map(|(a, b)| a.iter().zip(b).filter(|(a, b)| **a && **b).count()).sum();
    let pairs = (height * (width - 1) + width * (height - 1)) as f64;
    let (n, pixels) = (count as f64, lit.len() as f64);
    let share = n / pixels;
    let expected = pairs * share * (n - 1.0) / (pixels - 1.0).max(1.0);
    // Given the number of lit pixels, joins vary as independent ones do, by p^2 (1 - p)^2 each.
    let spread = (pairs * (share * (1.0 - share)).powi(2)).sqrt();
    let found = (across + down) as f64;
    // Four standard deviations; two pairs more, for few lit pixels are far from normal.
    (count > 0 && count < lit.len() && found <= expected + 4.0 * spread + 2.0)
        .then(|| format!("the {count} lit pixels lie scattered like noise: d and h say nothing of an object"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::camera::noise::PixelRandom;

    fn image(offset: f64, spot: f64, seed: u32) -> GreyImage {
        let (width, height) = (120, 90);
        let pixel = |i: usize| {
            let inside = ((i % width) as f64 - 60.0).hypot((i / width) as f64 - 45.0) < 6.0;
            let noise = 2.0 * PixelRandom::new(seed, i as u32).normal();
            (offset + noise + if inside { spot } else { 0.0 }).round().max(0.0)
        };
        GreyImage::new(width, height, &(0..width * height).map(pixel).collect::<Vec<_>>(), Some(255.0)).unwrap()
    }

    #[test]
    fn noise_is_scattered_and_a_spot_is_not() {
        let said = |offset, spot| (0..200).filter(|&seed| scattered(&image(offset, spot, seed), 5.0).is_some()).count();
        // Four standard deviations one-sided is 3e-5; of rare pixels two pairs beyond expectation are 1e-3: none or two
        // of 200.
        assert!(said(6.0, 0.0) >= 199 && said(0.0, 0.0) >= 198, "{} {}", said(6.0, 0.0), said(0.0, 0.0));
        assert_eq!(said(0.0, 10.0), 0);
        assert_eq!(said(3.0, 10.0), 0);
    }

    #[test]
    fn numbers_of_noise_are_told_from_more() {
        assert!(by_noise(17, 15.0, 16.0).unwrap().contains("not told from noise"));
        assert!(by_noise(100, 15.0, 16.0).unwrap().contains("noise alone lights 15 of the 100"));
        assert_eq!(by_noise(10_000, 15.0, 16.0), None);
        // Clusters of ten pixels: forty are four of them where 1.5 are expected.
        assert!(by_noise(40, 15.0, 150.0).is_some_and(|text| text.contains("not told")));
        assert_eq!(by_noise(3, 0.0, 0.0), None);
        assert_eq!(by_noise(0, 15.0, 16.0), None);
    }

    #[test]
    fn a_frame_that_is_lit_all_over_has_no_spot() {
        assert!(most_of_the_frame(51, 100).is_some() && most_of_the_frame(50, 100).is_none());
    }
}
