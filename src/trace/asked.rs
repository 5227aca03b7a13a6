//! A model rendered as asked. An asked error takes attempts with ever more work.

use super::backend::{Backend, Devices};
use super::batch::{Batch, Times};
use super::error::TraceError;
use super::kernel::Kernel;
use super::model::Model;
use super::plan::{Integrator, Plan};
use super::render::{FEW_PHOTONS, Outcome, REPLICATES, Settings, photons, pixels, render_batch, render_on, shared};
use crate::progress::Observer;
use std::time::Instant;

/// Photons of a replicate that an error of [`FIRST_ERROR`] begins with, and the most times more for a smaller one: in
/// an image of full size these take about as long as its camera paths and its map, which each attempt pays for
/// (docs/decisions/asked-errors.md).
const FIRST_PHOTONS: u64 = 1 << 15;
const FIRST_ERROR: f64 = 0.02;
const MOST_FIRST: f64 = 4.0;
/// Photons for an asked error over those that match the camera paths, where nothing is unfolded: on `phantom-size-8mm`
/// a photon a pixel is 22 times as much of the variance as a camera path a pixel, and takes twice as long.
const PHOTONS_A_PATH: u64 = 3;
/// Most camera paths per pixel for an asked error.
const MOST_SPP: u32 = 1 << 24;
/// What is taken above the work that an error found asks for, and the most at once: a first error may be a poor guess.
const SAFETY: f64 = 1.15;
const MOST_SCALE: f64 = 8.0;

/// Renders a model. `observe` is called between chunks; false stops the work. For an asked error each attempt counts
/// from 0 to 1 by itself.
///
/// # Errors
/// `Unsuited` where the integrator does not suit the scene; as [`Devices::load`] and [`render_on`].
pub fn render(
    devices: &Devices,
    model: &Model<f64>,
    settings: &Settings,
    observe: &mut Observer,
) -> Result<Outcome, TraceError> {
    let start = Instant::now();
    let mut backend = devices.load(model)?;
    let opening = start.elapsed().as_secs_f64();
    let outcome = match settings.target_error {
        Some(target) => until(&mut backend, model, settings, target, observe)?,
        None => render_on(&mut backend, model, settings, observe)?,
    };
    Ok(Outcome {
        notice: devices.notice().map(str::to_owned).into_iter().chain(outcome.notice).reduce(|a, b| a + "; " + &b),
        setup_seconds: opening + outcome.setup_seconds,
        ..outcome
    })
}

/// Renders until the relative error is at most `target`.
///
/// It renders with the least work first, and from what that leaves anew with as much as it takes: the smoothing of a
/// map is then chosen for the noise of the whole, and its bias shrinks with it, where added replicates would keep a
/// kernel for more noise. What the photons of a map have left is kept: it is that of the first of more, bit by bit. The
/// least work is a camera path per pixel and replicate, and few photons, since each path reads the smoothed map, whose
/// noise is most of the error: photons alone grow until they are as many to a camera path as suits the scene, and both
/// from there.
fn until(
    backend: &mut Backend,
    model: &Model<f64>,
    settings: &Settings,
    target: f64,
    observe: &mut Observer,
) -> Result<Outcome, TraceError> {
    let kernel = Kernel::of(model);
    let integrator = Plan::choose(settings.integrator, &kernel)?.integrator;
    let a_path = if integrator == Integrator::Map && kernel.unfolded == 0 { PHOTONS_A_PATH } else { 1 };
    // Each stands for all its images.
    let alike = if integrator == Integrator::Map { u64::from(model.symmetry.order()) } else { 1 };
    let each = (a_path * photons(&kernel, integrator, pixels(model)) / alike).max(FEW_PHOTONS) as f64;
    // Camera paths per pixel that the photons match: at first fewer than there are.
    let mut work = f64::from(REPLICATES);
    if integrator != Integrator::Path {
        let first = FIRST_PHOTONS as f64 / alike as f64 * (FIRST_ERROR / target).powi(2).clamp(1.0, MOST_FIRST);
        work *= (first / each).min(1.0);
    }
    let mut batch = Batch::new(model, backend, integrator, settings.seed).keeping();
    let (mut seconds, mut setup_seconds, mut segments, mut times) = (0.0, 0.0, 0, Times::default());
    loop {
        let spp = (work.ceil() as u32).max(REPLICATES);
        // As many to each path that is traced: a replicate never has fewer than before, and needs those alone that it
        // lacks.
        let [paths, replicates] = shared(spp).map(f64::from);
        let photons = Some((each * if work < f64::from(REPLICATES) { work } else { paths * replicates }) as u64);
        let once = Settings { spp, photons, seconds: None, ..settings.clone() };
        let outcome = render_batch(&mut batch, &once, observe)?;
        seconds += outcome.seconds;
        setup_seconds += outcome.setup_seconds;
        segments += outcome.segments;
        times = times.and(outcome.times);
        let more = match outcome.relative_error {
            Some(error) if error > target => {
                let scale = (SAFETY * (error / target).powi(2)).clamp(SAFETY, MOST_SCALE);
                (work * scale).min(f64::from(MOST_SPP))
            }
            Some(_) => work,
            // Dark, perhaps by chance: not more than the scene asks for is spent on it.
            None => work.max(f64::from(settings.spp)),
        };
        if more <= work {
            return Ok(Outcome { seconds, setup_seconds, segments, times, ..outcome });
        }
        work = more;
    }
}
