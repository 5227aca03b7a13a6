//! Reflectance where it is hardest: near the critical angle, at vanishing steps of the index, at grazing incidence.
//!
//! A tracer decides by cos^2(theta_t) n_t^2 = (n_t^2 - n_i^2) + n_i^2 cos^2(theta_i) with the bracket prepared in f64.
//! The reference is the closed form in f64 at the inputs as f32 rounds them: rounding an input is no error of the
//! tracer.

use super::row::{Part, Row, Subject};
use super::scenes::cavity;
use super::tracer::Tracer;
use super::{Context, StabilityError};
use crate::optics::fresnel::reflectance as exact;

/// Steps of the index: against air, from layer to layer, and vanishing ones.
const STEPS: [[f64; 2]; 5] = [[1.41, 1.0], [1.41, 1.40], [1.39, 1.38], [1.411, 1.41], [1.410_000_1, 1.41]];
/// What an image may be off by: far below the noise of any render.
const UNSEEN: f64 = 2e-4;
const WHY: &str = "2e-4, or what one rounding of cos^2 makes there if that is more";
const REFERENCE: &str = "Fresnel in f64 at the f32 inputs";

/// A reflectance beside its closed form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Angle of incidence less the critical angle, rad.
    pub off_rad: f64,
    /// Closed form at the same f32 inputs.
    pub exact: f64,
    /// What the tracer computes.
    pub found: f64,
    /// Largest error that passes.
    pub allowed: f64,
}

impl Sample {
    fn error(&self) -> f64 {
        let error = (self.found - self.exact).abs();
        if error.is_nan() { f64::INFINITY } else { error }
    }

    fn is_wild(&self) -> bool {
        !(0.0..=1.0).contains(&self.found)
    }
}

/// Reflectances at angles about the critical one, `offsets` rad away.
///
/// # Errors
/// As [`Tracer::reflectances`].
pub fn about_critical(tracer: &Tracer, step: [f64; 2], offsets: &[f64]) -> Result<Vec<Sample>, StabilityError> {
    let critical = (step[1] / step[0]).asin();
    let inside = |off: &&f64| (0.0..std::f64::consts::FRAC_PI_2).contains(&(critical + **off));
    let offsets: Vec<f64> = offsets.iter().filter(inside).copied().collect();
    let mut samples = at(tracer, step, offsets.iter().map(|off| (critical + off).cos()))?;
    samples.iter_mut().zip(offsets).for_each(|(sample, off)| sample.off_rad = off);
    Ok(samples)
}

/// Closed form and tracer at incidence cosines.
fn at(
    tracer: &Tracer,
    [n_i, n_t]: [f64; 2],
    cosines: impl Iterator<Item = f64>,
) -> Result<Vec<Sample>, StabilityError> {
    let (dn_sq, n_sq) = (((n_t - n_i) * (n_t + n_i)) as f32, (n_i * n_i) as f32);
    let inputs: Vec<[f32; 3]> = cosines.map(|cos| [(n_i * cos) as f32, dn_sq, n_sq]).collect();
    let found = tracer.reflectances(&cavity(|_| {})?, &inputs)?;
    Ok(inputs.iter().zip(found).map(|(input, found)| sample(input.map(f64::from), f64::from(found))).collect())
}

fn sample([a, dn_sq, n_sq]: [f64; 3], found: f64) -> Sample {
    let n_i = n_sq.sqrt();
    let exact_at = |a_sq: f64| exact(a_sq.sqrt() / n_i, n_i, (n_sq + dn_sq).sqrt());
    let exact = exact_at(a * a);
    // a^2 is rounded to half an ulp, 2^-24 of it at most.
    let rounded = [1.0, -1.0].map(|side| exact_at(a * a * (1.0 + side * 2f64.powi(-24))));
    let allowed = rounded.iter().fold(UNSEEN, |most, r| most.max((r - exact).abs()));
    Sample { off_rad: 0.0, exact, found, allowed }
}

/// Near-critical incidence, 1e-1 to 1e-7 rad on both sides, and at the angle itself.
pub fn near_critical(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let per_decade = if context.quick { 1 } else { 40 };
    let sizes: Vec<f64> =
        (0..=6 * per_decade).map(|k| 10f64.powf(-1.0 - f64::from(k) / f64::from(per_decade))).collect();
    let mut offsets: Vec<f64> = sizes.iter().map(|s| -s).chain([0.0]).collect();
    offsets.extend(sizes.iter().rev());
    let mut rows = Vec::new();
    for step in STEPS {
        let samples = about_critical(tracer, step, &offsets)?;
        let case = format!("near-critical incidence, {} to {}", step[0], step[1]);
        let subject = Subject::new(Part::Light, case, tracer.name());
        let worst = worst(&samples)?;
        let quantity = format!("reflectance, worst of {} angles ({:.0e} rad off)", samples.len(), worst.off_rad);
        rows.push(subject.absolute(quantity, [worst.found, worst.exact], REFERENCE, worst.allowed, WHY));
        // Near Brewster's angle R falls; the closed form says where it rises.
        let falls =
            |pair: &&[Sample]| pair[1].exact >= pair[0].exact && pair[1].found < pair[0].found - pair[0].allowed;
        let falls = samples.windows(2).filter(falls).count();
        let wild = samples.iter().filter(|sample| sample.is_wild()).count();
        let quantity = "reflectances outside 0 to 1, not rising, or none";
        rows.push(subject.none(quantity, (wild + falls) as f64, "R + T = 1, R monotone"));
    }
    Ok(rows)
}

/// Steps of the index of 0, 1e-7, 1e-3 and from 1 to 4, at all angles up to 90 degrees.
pub fn index_steps(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let count = if context.quick { 200 } else { 20_000 };
    let grazing = (0..=60).map(|k| 10f64.powf(-1.0 - 0.1 * f64::from(k)).to_radians().sin());
    let cosines: Vec<f64> = (1..=count).map(|k| f64::from(k) / f64::from(count)).rev().chain(grazing).collect();
    let mut rows = Vec::new();
    for step in [[1.41, 1.41], [1.41, 1.410_000_1], [1.41, 1.411], [1.0, 4.0], [4.0, 1.0], [1.0, 1.41]] {
        let case = format!("index {} to {}, 0 to 90 degrees", step[0], step[1]);
        let subject = Subject::new(Part::Light, case, tracer.name());
        let samples = at(tracer, step, cosines.iter().copied())?;
        let worst = worst(&samples)?;
        let quantity = format!("reflectance, worst of {} angles", samples.len());
        rows.push(subject.absolute(quantity, [worst.found, worst.exact], REFERENCE, worst.allowed, WHY));
        let wild = samples.iter().filter(|sample| sample.is_wild()).count();
        rows.push(subject.none("reflectances outside 0 to 1, or none", wild as f64, "R + T = 1"));
    }
    Ok(rows)
}

/// The sample that is nearest to failing, or furthest beyond.
fn worst(samples: &[Sample]) -> Result<Sample, StabilityError> {
    let by = |a: &&Sample, b: &&Sample| (a.error() / a.allowed).total_cmp(&(b.error() / b.allowed));
    samples.iter().max_by(by).copied().ok_or(StabilityError::Missing("no angle is possible"))
}
