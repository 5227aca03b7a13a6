//! Rays followed far: what is invariant stays so, and they come out where they must.

use super::row::{Part, Row, Subject};
use super::scenes::{THIN, cavity, dented_cavity, layers};
use super::tracer::{Start, Tracer, follow_exactly};
use super::{Context, StabilityError};
use crate::trace::Model;
use crate::trace::cpu::End;

/// Spacing of f32 between 8 and 16, mm: heights of a stack.
const ULP_MM: f64 = 9.54e-7;

/// A ray under the mirrors: s = 1.39 sin 60 degrees, above the surround's index and below every layer's.
fn guided(steps: u32) -> Start {
    let scale = 1.39 / (0.81f32 + 0.64 + 0.475_9).sqrt();
    Start { o: [0.3, -0.7, 4.0], p: [0.9, 0.8, 0.689_855].map(|p| p * scale), layer: 2, steps }
}

/// Depth of a dent that only rounding knows of, and of one that turns rays by up to 0.3 mrad, mm.
const DENTS: [f64; 2] = [1e-9, 1e-3];

/// Ten thousand bounces without loss: the weight stays 1, the invariants keep their values.
pub fn lossless_bounces(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let steps = if context.quick { 2_000 } else { 10_000 };
    let mut rows = Vec::new();
    for (name, model, flat) in [
        ("planes", cavity(|_| {})?, true),
        ("flat height fields", dented_cavity(DENTS[0])?, true),
        ("height fields with a dent of 1 um", dented_cavity(DENTS[1])?, false),
    ] {
        let case = format!("{steps} lossless bounces between {name}");
        let subject = Subject::new(Part::Light, case, tracer.name());
        for finish in tracer.follow(&model, &[guided(steps)])? {
            let taken = [f64::from(finish.steps), f64::from(steps)];
            rows.push(subject.absolute("steps taken", taken, "as asked", 0.0, "no ray ends in a closed cavity"));
            rows.push(subject.absolute("weight", [finish.weight, 1.0], "no loss", 0.0, "exactly 1"));
            let why = "some ulps a bounce, adding up";
            if flat {
                let drift = [finish.drift, 0.0];
                rows.push(subject.absolute("largest drift of s, as a share", drift, "Snell", 1e-3, why));
            }
            let stretch = [finish.stretch, 0.0];
            rows.push(subject.absolute("largest drift of |p|/n", stretch, "p = n d", 1e-3, why));
        }
    }
    Ok(rows)
}

/// The drift of a momentum after so many bounces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriftSample {
    /// Bounces.
    pub bounces: u32,
    /// Largest drift of |p|/n up to there, between planes.
    pub planes: f64,
    /// The same with a dent of 1 um.
    pub dented: f64,
}

/// Drift of |p|/n against bounces, to `most` bounces.
///
/// # Errors
/// As [`Tracer::follow`].
pub fn drift_curve(tracer: &Tracer, most: u32) -> Result<Vec<DriftSample>, StabilityError> {
    let mut counts: Vec<u32> = (0..=24).map(|k| f64::from(most).powf(f64::from(k) / 24.0).round() as u32).collect();
    counts.dedup();
    // Equal rays, one for each number of bounces.
    let starts: Vec<Start> = counts.iter().map(|&bounces| guided(bounces)).collect();
    let planes = tracer.follow(&cavity(|_| {})?, &starts)?;
    let dented = tracer.follow(&dented_cavity(DENTS[1])?, &starts)?;
    let sample = |((bounces, planes), dented): ((u32, super::Finish), super::Finish)| DriftSample {
        bounces,
        planes: planes.stretch,
        dented: dented.stretch,
    };
    Ok(counts.into_iter().zip(planes).zip(dented).map(sample).collect())
}

/// Guided rays after a hundred segments, against the same rays in f64.
pub fn guided_positions(context: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let count = if context.quick { 64 } else { 4_096 };
    let model = cavity(|_| {})?;
    let starts: Vec<Start> = (0..count).map(|k| spread(&model, k)).collect();
    let found = tracer.follow(&model, &starts)?;
    let exact = follow_exactly(&model, &starts);
    let off = |(a, b): (&super::Finish, &super::Finish)| {
        let off = (0..3).map(|k| (a.o[k] - b.o[k]).powi(2)).sum::<f64>().sqrt();
        if off.is_nan() { f64::INFINITY } else { off }
    };
    let worst = found.iter().zip(&exact).map(off).fold(0.0, f64::max);
    let subject = Subject::new(Part::Light, format!("{SEGMENTS} guided segments, {count} rays"), tracer.name());
    // Each segment rounds its length of about 10 mm, and the momentum at its end, by a few parts in 2^24.
    let allowed = f64::from(SEGMENTS) * 10.0 * 10.0 / f64::from(1u32 << 24);
    let why = "ten roundings of 10 mm a segment, all one way";
    Ok(vec![subject.absolute("position, mm, worst ray", [worst, 0.0], "the same rays in f64", allowed, why)])
}

/// Segments that positions are compared after.
const SEGMENTS: u32 = 100;

/// Ray `k` of an even spread of guided rays.
fn spread(model: &Model<f64>, k: u32) -> Start {
    let share = |step: f64| (f64::from(k) * step).fract();
    // Golden ratios of one and two dimensions spread evenly (Roberts 2018).
    let (s, turn, at) = (1.1 + 0.2 * share(0.618_034), std::f64::consts::TAU * share(0.754_878), share(0.569_840));
    let n_sq = model.layers[2].n_sq;
    let p = [s * turn.cos(), s * turn.sin(), (n_sq - s * s).sqrt()];
    Start { o: [(10.0 * at - 5.0) as f32, 1.0, 4.0], p: p.map(|v| v as f32), layer: 2, steps: SEGMENTS }
}

/// Sideways shift of a ray on its way up through layers, some of them thinner than rounding can hold.
pub fn lateral_shift(_: &Context, tracer: &Tracer) -> Result<Vec<Row>, StabilityError> {
    let usual = [[2.0, 1.41], [3.0, 1.40], [5.0, 1.39]];
    let mut rows = Vec::new();
    for (name, stack) in [("2, 3, 5 mm of 1.41, 1.40, 1.39", &usual[..]), ("layers of 1 um and 10 nm, index 4", &THIN)]
    {
        let model = cavity(|scene| layers(scene, stack))?;
        // From air at 30 degrees. One in some of the rays is transmitted at every interface.
        let start = Start { o: [0.0; 3], p: [0.5, 0.0, 0.75f32.sqrt()], layer: 0, steps: 2 * stack.len() as u32 };
        let finishes = tracer.follow(&model, &[start; 64])?;
        let straight = |f: &&super::Finish| f.end == End::Top as u32 && f.steps == stack.len() as u32 + 1;
        let subject = Subject::new(Part::Light, format!("lateral shift, {name}"), tracer.name());
        let s = 0.5f64;
        let exact: f64 = stack.iter().map(|[d, n]| d * s / (n * n - s * s).sqrt()).sum();
        let Some(finish) = finishes.iter().find(straight) else {
            rows.push(subject.failed("no ray came straight through"));
            continue;
        };
        let allowed = 2.0 * ULP_MM * (stack.len() + 1) as f64;
        let why = "two ulps of the height an interface";
        rows.push(subject.absolute("shift, mm", [finish.o[0], exact], "sum of d s / sqrt(n^2 - s^2)", allowed, why));
    }
    Ok(rows)
}
