//! Relative stiffness from two frames under different compression (section 2.5.4 of the TSIS paper).
//!
//! F = f(M) by calibration, P = F / C with C the area of the waveguide's bottom, T = |d2 - d1| / d1, E = P / T. The
//! force is that of the second frame. E is relative: it carries a unit of pressure but is no Young's modulus.
//!
//! Intervals are those of images whose noise is not known: rounding to whole grey levels and counting of pixels.

use super::calibration::{Calibration, Force};
use super::image::GreyImage;
use super::paper::{PaperEstimate, Settings, equivalent_diameter, estimate};
use super::value::Value;
use serde::Serialize;

/// What two frames say about stiffness.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stiffness {
    /// Force F of the second frame, N.
    pub force_n: Value,
    /// Pressure P = F / C, kPa.
    pub pressure_kpa: Value,
    /// Relative change T of the diameter between the frames.
    pub deformation: Value,
    /// Relative stiffness E = P / T, kPa.
    pub relative_stiffness_kpa: Value,
}

/// Compares two frames; the second is usually pressed harder.
pub fn stiffness(first: &GreyImage, second: &GreyImage, settings: &Settings, calibration: &Calibration) -> Stiffness {
    let force_n = force(&estimate(second, settings), calibration);
    let pressure_kpa = match calibration.bottom_area_mm2 {
        // N/mm^2 are MPa.
        Some(area) => force_n.scaled(1e3 / area),
        None => Value::undefined("the calibration gives no bottom_area_mm2"),
    };
    let deformation = deformation(first, second, settings);
    let relative_stiffness_kpa = ratio(&pressure_kpa, &deformation);
    Stiffness { force_n, pressure_kpa, deformation, relative_stiffness_kpa }
}

/// The force that the calibration gives for an image's sum of grey values.
pub fn force(paper: &PaperEstimate, calibration: &Calibration) -> Value {
    let Value::Known { value, low, high } = paper.sum_grey else {
        return paper.sum_grey.clone();
    };
    let Some(table) = &calibration.force_n_from_sum_grey else {
        return Value::undefined("the calibration gives no force_n_from_sum_grey");
    };
    match table.at(value) {
        Force::Inside(newton) => Value::known(newton, table.extended(low).max(0.0), table.extended(high)),
        Force::Outside { least, most } => Value::undefined(format!(
            "the sum of grey values, {value:.6e}, is outside the calibrated range {least:.6e} to {most:.6e}"
        )),
    }
}

/// T = |d2 - d1| / d1; its interval from the same shift of the threshold in both frames and the count of edge pixels.
fn deformation(first: &GreyImage, second: &GreyImage, settings: &Settings) -> Value {
    let at = |threshold: f64| {
        let (d1, error1) = equivalent_diameter(first.brighter_than(threshold));
        let (d2, error2) = equivalent_diameter(second.brighter_than(threshold));
        (d1 > 0.0).then(|| ((d2 - d1) / d1, error1.hypot(error2) / d1))
    };
    let k = settings.threshold_grey;
    let step = settings.threshold_step();
    let Some((change, _)) = at(k) else {
        return Value::undefined(format!(
            "no pixel of the first frame is brighter than the threshold of {k} grey levels"
        ));
    };
    if second.brighter_than(k) == 0 {
        return Value::undefined(format!(
            "no pixel of the second frame is brighter than the threshold of {k} grey levels"
        ));
    }
    let (mut low, mut high) = (change, change);
    for (change, error) in [at(k - step), at(k), at(k + step)].into_iter().flatten() {
        low = low.min(change - error);
        high = high.max(change + error);
    }
    // The interval of the magnitude: folded at 0 where the change may have either sign.
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    Value::known(change.abs(), least, low.abs().max(high.abs()))
}

fn ratio(pressure: &Value, deformation: &Value) -> Value {
    match (pressure, deformation) {
        (Value::Undefined { .. }, _) => pressure.clone(),
        (_, Value::Undefined { .. }) => deformation.clone(),
        (_, Value::Known { value, low, .. }) if *value == 0.0 || *low <= 0.0 => Value::undefined(
            "the diameters of the two frames do not differ beyond their uncertainty: T = 0 has no P / T",
        ),
        (Value::Known { value: p, low: p_low, high: p_high }, Value::Known { value: t, low: t_low, high: t_high }) => {
            Value::known(p / t, p_low / t_high, p_high / t_low)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn disc(radius: f64, grey: f64) -> GreyImage {
        let n = 200;
        let pixel = |i: usize| {
            let (x, y) = ((i % n) as f64 + 0.5 - 100.3, (i / n) as f64 + 0.5 - 99.6);
            if x.hypot(y) < radius { grey } else { 0.0 }
        };
        GreyImage::new(n, n, &(0..n * n).map(pixel).collect::<Vec<_>>(), Some(255.0)).unwrap()
    }

    fn calibration() -> Calibration {
        // F = 1e-5 N per grey level from 1e5 to 1e6.
        let text = "mm_per_pixel = 0.02\nbottom_area_mm2 = 900.0\nforce_n_from_sum_grey = [[1e5, 1.0], [1e6, 10.0]]\n";
        Calibration::parse(text, "test.toml").unwrap()
    }

    #[test]
    fn stiffness_of_two_discs_is_pressure_over_relative_growth() {
        let (first, second) = (disc(40.0, 100.0), disc(60.0, 50.0));
        let got = stiffness(&first, &second, &Settings::default(), &calibration());
        let Value::Known { value, low, high } = got.relative_stiffness_kpa else { panic!("{got:?}") };
        // M = 50 pi 60^2 = 565487, F = 5.65487 N, P = 6.28319 kPa, T = 0.5. Counting pixels: T good to 0.003.
        assert!((value / (1e3 * 50.0 * 3600.0 * PI * 1e-5 / 900.0 / 0.5) - 1.0).abs() < 0.01, "{value}");
        assert!(low < 12.566 && 12.566 < high && high / low < 1.1, "{low} {high}");
    }

    #[test]
    fn equal_frames_leave_the_stiffness_undefined_and_the_force_known() {
        let frame = disc(40.0, 100.0);
        let got = stiffness(&frame, &frame, &Settings::default(), &calibration());
        assert!(got.force_n.best().is_some());
        assert_eq!(got.deformation.best(), Some(&0.0));
        assert!(matches!(got.relative_stiffness_kpa, Value::Undefined { reason } if reason.contains("T = 0")));
    }

    #[test]
    fn change_within_the_uncertainty_leaves_the_stiffness_undefined() {
        let got = stiffness(&disc(40.0, 100.0), &disc(40.02, 100.0), &Settings::default(), &calibration());
        assert_eq!(got.relative_stiffness_kpa.best(), None);
    }

    #[test]
    fn sum_outside_the_calibrated_range_is_undefined_and_names_the_range() {
        let got = stiffness(&disc(40.0, 100.0), &disc(90.0, 200.0), &Settings::default(), &calibration());
        let Value::Undefined { reason } = got.force_n else { panic!("known") };
        assert!(reason.contains("1.000000e5 to 1.000000e6"), "{reason}");
        assert_eq!(got.relative_stiffness_kpa.best(), None);
    }

    #[test]
    fn blank_frame_has_no_deformation() {
        let got = stiffness(&disc(0.0, 0.0), &disc(60.0, 50.0), &Settings::default(), &calibration());
        assert!(matches!(got.deformation, Value::Undefined { reason } if reason.contains("first frame")));
    }
}
