//! Errors of images and what to make of them.

use super::{ErrorEstimate, Rung};
use crate::film::{Film, mean_interval};

/// The normal deviate of a two-sided 95 %.
const NORMAL: f64 = 1.959_964;

/// Which pixels are lit: above 0.3 of the 99th percentile, as for a render's relative error.
pub fn is_lit(film: &Film) -> Vec<bool> {
    let mut sorted = film.mean.clone();
    sorted.sort_by(f32::total_cmp);
    let percentile = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    film.mean.iter().map(|&mean| mean > 0.3 * percentile).collect()
}

/// Which pixels are lit softly: above 0.3 of the 90th percentile and at most three times the median of those. What is
/// left out are glints, whose edges within a pixel hide all else.
pub fn is_soft(film: &Film) -> Vec<bool> {
    let mut sorted = film.mean.clone();
    sorted.sort_by(f32::total_cmp);
    let floor = 0.3 * sorted.get(sorted.len().saturating_sub(1) * 9 / 10).copied().unwrap_or(0.0);
    let lit: Vec<f32> = sorted.into_iter().filter(|&mean| mean > floor).collect();
    let most = 3.0 * lit.get(lit.len() / 2).copied().unwrap_or(0.0);
    film.mean.iter().map(|&mean| mean > floor && mean <= most).collect()
}

/// Mean square difference to the reference over the lit pixels as a share of their mean's square, and what of it is the
/// reference's own noise. `None` where nothing is lit, or sizes differ.
pub fn square_error(film: &Film, reference: &Film, lit: &[bool]) -> Option<[f64; 2]> {
    if film.mean.len() != reference.mean.len() {
        return None;
    }
    let (mut count, mut mean, mut square, mut noise) = (0.0, 0.0, 0.0, 0.0);
    let pixels = film.mean.iter().zip(reference.mean.iter().zip(&reference.variance)).zip(lit);
    for ((&found, (&exact, &variance)), _) in pixels.filter(|(_, lit)| **lit) {
        count += 1.0;
        mean += f64::from(exact);
        square += f64::from(found - exact).powi(2);
        noise += f64::from(variance);
    }
    let scale = count / (mean * mean);
    (mean > 0.0).then_some([square * scale, noise * scale])
}

impl ErrorEstimate {
    /// From the square errors of independent runs, less the reference's noise, which is itself known to a share.
    pub fn of_squares(squares: &[f64], noise: f64, noise_share: f64) -> Self {
        let [mean, half] = mean_interval(squares);
        let half = half.hypot(NORMAL * noise_share * noise);
        let root = |square: f64| square.max(0.0).sqrt();
        let square = mean - noise;
        Self { value: root(square), low: root(square - half), high: root(square + half) }
    }

    /// The best value, or the upper end where there is none above 0.
    pub fn bound(&self) -> f64 {
        if self.value > 0.0 { self.value } else { self.high }
    }

    /// A difference to a reference that is itself known to `uncertainty`.
    pub fn of_difference(difference: f64, uncertainty: f64) -> Self {
        let value = difference.abs();
        Self { value, low: (value - uncertainty).max(0.0), high: value + uncertainty }
    }
}

/// Which rungs no other beats in both time and error; rungs of one quantity compete, by the upper end of an error that
/// is not told from 0.
pub fn pareto(rungs: &[&Rung]) -> Vec<bool> {
    let beats = |a: &Rung, b: &Rung| {
        let errors = [a, b].map(|rung| rung.error.bound());
        let no_worse = a.seconds <= b.seconds && errors[0] <= errors[1];
        a.quantity == b.quantity && no_worse && (a.seconds < b.seconds || errors[0] < errors[1])
    };
    rungs.iter().map(|rung| !rungs.iter().any(|other| beats(other, rung))).collect()
}

/// Slope of error against time in logarithms, by least squares over errors that are told from 0; `None` of fewer than
/// two apart.
pub fn fitted_slope(rungs: &[&Rung]) -> Option<f64> {
    let points = rungs.iter().filter(|r| r.error.low > 0.0 && r.seconds > 0.0);
    let points: Vec<[f64; 2]> = points.map(|r| [r.seconds.ln(), r.error.value.ln()]).collect();
    let n = points.len() as f64;
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / n);
    let across: f64 = points.iter().map(|p| (p[0] - mean[0]).powi(2)).sum();
    let both: f64 = points.iter().map(|p| (p[0] - mean[0]) * (p[1] - mean[1])).sum();
    (points.len() > 1 && across > 1e-6).then(|| both / across)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn film(values: &[f32], variance: f32) -> Film {
        Film {
            width: values.len() as u32,
            height: 1,
            mean: values.to_vec(),
            variance: vec![variance; values.len()],
            ..Film::default()
        }
    }

    fn rung(seconds: f64, error: f64) -> Rung {
        Rung {
            family: "samples".into(),
            series: "path".into(),
            setting: String::new(),
            level: None,
            quantity: "radiance".into(),
            error: ErrorEstimate { value: error, low: error, high: error },
            seconds,
            repeats: 1,
            is_default: false,
        }
    }

    #[test]
    fn the_reference_s_noise_is_taken_out_in_quadrature() {
        // Four pixels of 2 and a dark one; found is off by 0.2, the reference's variance is 0.01.
        let reference = film(&[2.0, 2.0, 2.0, 2.0, 0.1], 0.01);
        let lit = is_lit(&reference);
        assert_eq!(lit, [true, true, true, true, false]);
        let [square, noise] = square_error(&film(&[2.2, 1.8, 2.2, 1.8, 9.0], 0.0), &reference, &lit).unwrap();
        assert!((square - 0.01).abs() < 1e-7 && (noise - 0.0025).abs() < 1e-9, "{square} {noise}");
        let error = ErrorEstimate::of_squares(&[square; 3], noise, 0.0);
        assert!((error.value - 0.0075f64.sqrt()).abs() < 1e-6 && error.high - error.low < 1e-9, "{error:?}");
        assert_eq!(square_error(&reference, &film(&[0.0; 5], 0.0), &[true; 5]), None);
    }

    #[test]
    fn soft_light_is_without_glints() {
        let mut values = vec![1.0f32; 80];
        values.extend([0.0; 15]);
        values.extend([50.0; 5]);
        let soft = is_soft(&film(&values, 0.0));
        assert!(soft[..80].iter().all(|soft| *soft) && !soft[80..].contains(&true));
    }

    #[test]
    fn intervals_hold_the_truth_nineteen_times_in_twenty() {
        // Square errors of 200 pixels of unit noise: chi-square, mean 1.
        let mut state = 1u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let mut square = || (0..200).map(|_| normal().powi(2)).sum::<f64>() / 200.0;
        let holds = |_: &u32| {
            let error = ErrorEstimate::of_squares(&[square(), square(), square(), square()], 0.0, 0.0);
            error.low <= 1.0 && 1.0 <= error.high
        };
        let held = (0..1000u32).filter(holds).count();
        // 950 expected; 4 standard deviations are 28.
        assert!((922..=978).contains(&held), "{held}");
    }

    #[test]
    fn the_front_keeps_what_nothing_beats() {
        let rungs = [rung(1.0, 0.1), rung(2.0, 0.05), rung(2.0, 0.2), rung(4.0, 0.05)];
        let all: Vec<&Rung> = rungs.iter().collect();
        assert_eq!(pareto(&all), [true, true, false, false]);
        // Below 0.15 is not below 0.1.
        let mut unknown = rung(1.5, 0.0);
        unknown.error.high = 0.15;
        assert_eq!(pareto(&[&rungs[0], &unknown]), [true, false]);
    }

    #[test]
    fn a_root_law_has_a_slope_of_one_half() {
        let rungs = [1.0, 4.0, 16.0].map(|t: f64| rung(t, 0.3 / t.sqrt()));
        let all: Vec<&Rung> = rungs.iter().collect();
        assert!((fitted_slope(&all).unwrap() + 0.5).abs() < 1e-12);
        assert_eq!(fitted_slope(&all[..1]), None);
    }
}
