//! From a model to a film with its error, its ledger and what it cost.
//!
//! An image is the mean of at least [`REPLICATES`] replicates, each with its own seed (and its own photons). The
//! variance of the mean comes from their spread, for pixels and for blocks of pixels, because neighbours share photons.
//! Within a replicate sums are 64-bit fixed point, so they do not depend on the order of the work.

use super::backend::Backend;
use super::batch::{Batch, Times, Totals, Work};
use super::error::TraceError;
use super::exitance::{Smoothing, TouchedFace};
use super::kernel::Kernel;
use super::model::Model;
use super::plan::{Integrator, Plan};
use super::unseen::{Traced, Unseen};
use crate::film::{BlockAccumulator, Film, Ledger};
use crate::progress::{Observer, Stage};
use crate::scene::{self, IntegratorChoice};
use std::time::Instant;

/// Fewest replicates behind an error estimate, but where a budget of seconds ends before.
pub const REPLICATES: u32 = 16;
/// Fewest where a budget of seconds ends before.
const LEAST_REPLICATES: u32 = 3;
/// Largest share of a budget of seconds above it that goes without saying.
const BUDGET_TOLERANCE: f64 = 0.2;
/// Most camera paths per pixel in a replicate: the film's sums hold 65,536 paths that each see the brightest LED.
const REPLICATE_PATHS: u32 = 1 << 15;
/// Photons of the ledger where the integrator sends none of its own or not all, unless asked for fewer.
const LEDGER_PHOTONS: u64 = 1 << 20;
/// Camera paths to a photon where photons find only what unfolding leaves.
const PATHS_TO_A_PHOTON: u64 = 8;
/// Fewest photons for a map or a splat, unless asked for fewer, however few the camera paths: with 2^20 of them an 8 x
/// 8 block of `phantom-size-8mm` without mirror images lies up to 10 % off that across the axis, and blocks of 16 x 16
/// pixels are known to 1 %; this halves both.
const LEAST_PHOTONS: u64 = 1 << 22;
/// The same where unfolding finds most light.
const LEAST_PHOTONS_BESIDE_UNFOLDING: u64 = 1 << 20;
/// Fewest photons of a replicate for an asked time.
pub(super) const FEW_PHOTONS: u64 = 1 << 12;
/// Share of the photons in the time of a replicate, for the progress alone.
const PHOTON_SHARE: f64 = 0.5;
/// Edge of the blocks in which a shape is looked for, and that in images of few pixels.
const AREA_PIXELS: u32 = 16;
const FEW_AREA_PIXELS: u32 = 4;
/// Largest error of such a block without a word. Where it is 1 %, blocks of 8 x 8 pixels may differ by 10 % from
/// those across the axis, and 1 % of contrast is 4 to 10 % of an inclusion's modulus (docs/PHYSICS.md, 11).
const BLOTCHES: f64 = 0.0075;
/// Largest share of photons, and of camera paths, that may get lost; a single one of few tells nothing about the share.
const LOST_TOLERANCE: f64 = 1e-6;
/// Largest share of the light, and of the camera paths' weight, that may be cut off by the cap on interactions.
const TERMINATED_TOLERANCE: f64 = 1e-4;

/// How to render.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Integrator asked for.
    pub integrator: IntegratorChoice,
    /// Camera paths per pixel; at least 16, rounded up to whole replicates, of which there are 16 to 31, or more of
    /// 2^15 paths.
    pub spp: u32,
    /// Photons; `None`: as many as camera paths, at least 2^22; an eighth of that where unfolding finds most light, at
    /// least 2^20.
    pub photons: Option<u64>,
    /// Budget of tracing time after compilation, seconds; replaces `spp`.
    pub seconds: Option<f64>,
    /// Relative error to reach; replaces `spp` and `photons`.
    pub target_error: Option<f64>,
    /// Seed.
    pub seed: u32,
}

impl Settings {
    /// What a scene asks for.
    pub fn of(render: &scene::Render) -> Self {
        Self {
            integrator: render.integrator,
            spp: render.spp,
            photons: render.photons,
            seconds: None,
            target_error: None,
            seed: render.seed,
        }
    }
}

/// A finished render.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The image with its variance.
    pub film: Film,
    /// Where the light went.
    pub ledger: Ledger,
    /// Integrator and reason.
    pub plan: Plan,
    /// Backend.
    pub backend: &'static str,
    /// Adapter.
    pub adapter: String,
    /// What was not done as asked, and why: the CPU taken where no GPU was found, a budget of seconds that was too
    /// small.
    pub notice: Option<String>,
    /// Camera paths.
    pub paths: u64,
    /// Photons.
    pub photons: u64,
    /// Photons of the ledger: those, or all that were traced for it.
    pub ledger_photons: u64,
    /// How the photons' maps were smoothed, where there are any.
    pub smoothing: Option<Smoothing>,
    /// Segments of both, without those of a ledger traced on its own.
    pub segments: u64,
    /// Camera paths per pixel.
    pub spp: u64,
    /// Tracing time after compilation, seconds.
    pub seconds: f64,
    /// Where that went, and the time of the ledger beside it; the rest is sums and the error estimate.
    pub times: Times,
    /// Time to load the model and build kernels, seconds.
    pub setup_seconds: f64,
    /// Mean radiance of the image, W/(m^2 sr).
    pub mean_radiance: f64,
    /// Root-mean-square standard error over the lit pixels over their mean; `None` for a dark image.
    pub relative_error: Option<f64>,
    /// What may be where no light was found.
    pub unseen: Unseen,
}

/// Says where blocks of a map or a splat are too noisy to be read: neighbours share photons, whose noise has shapes.
fn blotches(integrator: Integrator, film: &Film) -> Option<String> {
    let edge = if film.width.min(film.height) >= 2 * AREA_PIXELS { AREA_PIXELS } else { FEW_AREA_PIXELS };
    let level = film.blocks.iter().find(|level| level.edge == edge && integrator != Integrator::Path)?;
    let error = relative_error(&level.mean, &level.variance).filter(|error| *error > BLOTCHES)?;
    Some(format!(
        "blocks of {edge} x {edge} pixels are known to {:.2} % only: what looks like an inclusion may be noise; more photons or \
         samples make it quieter",
        100.0 * error
    ))
}

/// Renders on a backend that holds the model already: one device for many seeds. Work is that of the settings, or for
/// their seconds; an asked error plays no part.
///
/// # Errors
/// `Unsuited` where the integrator does not suit the scene, what the backend says, `Stopped` where `observe` says so;
/// `Overflow` where sums of light are full, else as [`accepted`].
pub fn render_on(
    backend: &mut Backend,
    model: &Model<f64>,
    settings: &Settings,
    observe: &mut Observer,
) -> Result<Outcome, TraceError> {
    let integrator = Plan::choose(settings.integrator, &Kernel::of(model))?.integrator;
    render_batch(&mut Batch::new(model, backend, integrator, settings.seed), settings, observe)
}

/// Renders by a batch that begins anew, but for what it keeps.
pub(super) fn render_batch(
    batch: &mut Batch,
    settings: &Settings,
    observe: &mut Observer,
) -> Result<Outcome, TraceError> {
    let (model, start) = (batch.model, Instant::now());
    let kernel = Kernel::of(model);
    let plan = Plan::choose(settings.integrator, &kernel)?;
    batch.totals = Totals::default();
    let pixels = pixels(model);
    let [spp, mut replicates] = shared(settings.spp);
    batch.keep_first(replicates);
    let least = if kernel.unfolded > 0 { LEAST_PHOTONS_BESIDE_UNFOLDING } else { LEAST_PHOTONS };
    let all_photons = || photons(&kernel, plan.integrator, pixels * u64::from(settings.spp)).max(least);
    let mut work = Work { spp, photons: settings.photons.unwrap_or_else(all_photons).div_ceil(u64::from(replicates)) };
    if !observe(Stage { done: 0.0, what: "compiling kernels" }) {
        return Err(TraceError::Stopped);
    }
    batch.backend.prepare(plan.integrator)?;
    let setup_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    if let Some(budget) = settings.seconds {
        (replicates, work) = within(batch, &kernel, budget, work, observe)?;
    }
    let mut sum = BlockAccumulator::new(model.camera.size[0], model.camera.size[1]);
    let needs_ledger = batch.integrator == Integrator::Path || kernel.aimed;
    let first = replicates.min(2 * REPLICATES);
    let mut gather = match batch.integrator {
        Integrator::Map => Some(Gather::collect(batch, first, work, &mut |done| {
            observe(Stage { done: PHOTON_SHARE * done, what: "photons" })
        })?),
        Integrator::Path | Integrator::Splat => None,
    };
    let before = if gather.is_some() { PHOTON_SHARE } else { 0.0 };
    let mut index = 0;
    let mut longest = 0.0f64;
    loop {
        let timer = Instant::now();
        let mut observe = |Stage { done: part, what }: Stage| {
            let done = match settings.seconds {
                Some(budget) => start.elapsed().as_secs_f64() / budget,
                None => before + (1.0 - before) * (f64::from(index) + part) / f64::from(replicates.max(index + 1)),
            };
            observe(Stage { done: done.min(1.0), what })
        };
        let replicate = match &mut gather {
            Some(gather) => gather.replicate(batch, index, work, &mut observe)?,
            None => batch.replicate(index, work, &mut observe)?,
        };
        sum.add(&replicate).map_err(|e| TraceError::Driver(e.to_string()))?;
        index += 1;
        longest = longest.max(timer.elapsed().as_secs_f64());
        let enough = match settings.seconds {
            Some(budget) => index >= LEAST_REPLICATES && start.elapsed().as_secs_f64() + 0.5 * longest > budget,
            None => index >= replicates,
        };
        if enough {
            break;
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    let Totals { segments, mut times, photons, .. } = batch.totals;
    if needs_ledger {
        times.ledger = fill_ledger(batch, settings.photons, observe)?;
    }
    let totals = batch.totals;
    let ledger = accepted(&totals)?;
    let late = settings.seconds.filter(|budget| seconds > (1.0 + BUDGET_TOLERANCE) * budget).map(|budget| {
        let spp = work.spp;
        format!("more than the {budget} s asked for: {index} images of {spp} paths per pixel took {seconds:.1} s")
    });
    let spp = totals.paths / pixels;
    let film = Film { samples: u32::try_from(spp).unwrap_or(u32::MAX), ..sum.finish() };
    let mean_radiance = film.mean.iter().map(|&v| f64::from(v)).sum::<f64>() / film.mean.len() as f64;
    let blotches = blotches(plan.integrator, &film);
    Ok(Outcome {
        relative_error: relative_error(&film.mean, &film.variance),
        unseen: Unseen::of(model, &film, Traced { integrator: plan.integrator, spp, photons }),
        mean_radiance,
        ledger,
        plan,
        backend: batch.backend.name(),
        adapter: batch.backend.adapter(),
        notice: late.into_iter().chain(blotches).reduce(|a, b| a + "; " + &b),
        paths: totals.paths,
        photons,
        ledger_photons: totals.photons,
        smoothing: gather.map(|gather| gather.smoothing),
        segments,
        spp,
        film,
        seconds,
        times,
        setup_seconds,
    })
}

/// How many replicates, and of what work, fill a budget of seconds: a throw-away pilot of one path a pixel measures the
/// machine.
fn within(
    batch: &mut Batch,
    kernel: &Kernel,
    budget: f64,
    work: Work,
    observe: &mut Observer,
) -> Result<(u32, Work), TraceError> {
    let fewest = photons(kernel, batch.integrator, pixels(batch.model)).max(FEW_PHOTONS);
    let pilot = Work { spp: 1, photons: work.photons.min(fewest) };
    let timer = Instant::now();
    batch.replicate(u32::MAX, pilot, &mut |_| observe(Stage { done: 0.0, what: "measuring the machine" }))?;
    let Times { photons, map, camera, .. } = batch.totals.times;
    batch.totals = Totals { times: batch.totals.times, ..Totals::default() };
    let left = budget - timer.elapsed().as_secs_f64();
    let few = (FEW_PHOTONS as f64 / pilot.photons as f64).min(1.0);
    let replicates = ((left / (few * photons + map + camera)) as u32).clamp(LEAST_REPLICATES, REPLICATES);
    // Two thirds of the budget for so many: the choice of a smoothing takes time too. More replicates fill the rest.
    let each = left / f64::from(replicates) / 1.5 - map;
    let scale = (each / (photons + camera)).clamp(1.0, f64::from(REPLICATE_PATHS)).floor();
    let share = ((each - scale * camera) / photons).clamp(few, 2.0 * scale);
    Ok((replicates, Work { spp: scale as u32, photons: (pilot.photons as f64 * share) as u64 }))
}

/// Sends photons for the ledger alone; how long that takes, s.
fn fill_ledger(batch: &mut Batch, asked: Option<u64>, observe: &mut Observer) -> Result<f64, TraceError> {
    let start = Instant::now();
    let photons = match (asked, batch.integrator) {
        (None, _) => LEDGER_PHOTONS,
        (Some(asked), Integrator::Path) => asked,
        (Some(asked), Integrator::Map | Integrator::Splat) => asked.min(LEDGER_PHOTONS),
    };
    batch.ledger(photons, &mut |_| observe(Stage { done: 1.0, what: "flux ledger" }))?;
    Ok(start.elapsed().as_secs_f64())
}

/// The ledger, unless too much light is missing from the image: lost, or cut off by the cap on interactions.
///
/// # Errors
/// `Lost` where more than one of the photons or of the camera paths, and 1e-6 of them, were lost; `Truncated` where the
/// cap on interactions cut off more than 1e-4 of the light or of the paths' weight.
pub fn accepted(totals: &Totals) -> Result<Ledger, TraceError> {
    let counts = [("photons", totals.lost(), totals.photons), ("camera paths", totals.fates.lost, totals.paths)];
    for (what, lost, sent) in counts {
        if lost as f64 > (LOST_TOLERANCE * sent as f64).max(1.0) {
            return Err(TraceError::Lost { what, lost, sent });
        }
    }
    let ledger = totals.ledger();
    let shares = [("light", ledger.terminated), ("camera paths' weight", totals.paths_cut_off())];
    for (what, share) in shares {
        if share > TERMINATED_TOLERANCE {
            return Err(TraceError::Truncated { what, share });
        }
    }
    Ok(ledger)
}

/// The maps of the first replicates, and how all are smoothed.
struct Gather {
    face: TouchedFace,
    texels: std::vec::IntoIter<Vec<[f64; 4]>>,
    smoothing: Smoothing,
}

impl Gather {
    /// Sends the photons of the first replicates and chooses the smoothing from what they leave.
    fn collect(
        batch: &mut Batch,
        replicates: u32,
        work: Work,
        observe: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Self, TraceError> {
        let model = batch.model;
        let face = batch.at_map(|| TouchedFace::new(model));
        let maps = (0..replicates)
            .map(|index| {
                let mut observe = |stage: Stage| observe((f64::from(index) + stage.done) / f64::from(replicates));
                batch.contact_light(index, work, &face, &mut observe)
            })
            .collect::<Result<Vec<_>, _>>()?;
        let smoothing = batch.at_map(|| face.choose(&maps));
        Ok(Self { texels: batch.at_map(|| face.texels(&maps, smoothing)).into_iter(), face, smoothing })
    }

    fn replicate(
        &mut self,
        batch: &mut Batch,
        index: u32,
        work: Work,
        observe: &mut Observer,
    ) -> Result<Vec<f64>, TraceError> {
        let texels = match self.texels.next() {
            Some(texels) => texels,
            None => {
                let light = batch.contact_light(index, work, &self.face, observe)?;
                batch.at_map(|| self.face.texels(&[light], self.smoothing)).pop().unwrap_or_default()
            }
        };
        batch.mapped(index, work, &texels, observe)
    }
}

/// Camera paths per pixel in a replicate, and replicates, of so many asked for.
pub(super) fn shared(spp: u32) -> [u32; 2] {
    let each = (spp / REPLICATES).clamp(1, REPLICATE_PATHS);
    [each, spp.div_ceil(each).max(REPLICATES)]
}

/// Photons to match so many camera paths.
pub(super) fn photons(kernel: &Kernel, integrator: Integrator, paths: u64) -> u64 {
    match integrator {
        Integrator::Path => 0,
        Integrator::Map if kernel.unfolded > 0 => paths.div_ceil(PATHS_TO_A_PHOTON),
        Integrator::Map | Integrator::Splat => paths,
    }
}

pub(super) fn pixels(model: &Model<f64>) -> u64 {
    model.camera.size.map(u64::from).iter().product()
}

impl Outcome {
    /// Relative errors of the means over the film's blocks: the edge of a block (0: the whole image), and the error as
    /// `relative_error` has it, of blocks for pixels. They know that pixels share photons.
    pub fn block_errors(&self) -> Vec<(u32, Option<f64>)> {
        let levels = self.film.blocks.iter();
        levels.map(|level| (level.edge, relative_error(&level.mean, &level.variance))).collect()
    }
}

/// Root-mean-square standard error over the lit means (above 0.3 of the 99th percentile), over their mean.
fn relative_error(means: &[f32], variances: &[f32]) -> Option<f64> {
    let mut sorted = means.to_vec();
    sorted.sort_by(f32::total_cmp);
    let percentile = *sorted.get(sorted.len().saturating_sub(1) * 99 / 100)?;
    let lit = means.iter().zip(variances).filter(|(m, _)| **m > 0.3 * percentile);
    let (mut count, mut mean, mut variance) = (0.0, 0.0, 0.0);
    for (&m, &v) in lit {
        count += 1.0;
        mean += f64::from(m);
        variance += f64::from(v);
    }
    (mean > 0.0).then(|| (variance / count).sqrt() / (mean / count))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A film whose blocks of 16 x 16 pixels move together by a share of their light.
    fn film(size: u32, noise: f64) -> Film {
        let mut sum = BlockAccumulator::new(size, size);
        for index in 0..REPLICATES {
            let block = |k: u32| (k % size / 16 + k / size / 16 * 7 + index * 5).wrapping_mul(2_654_435_761) % 1001;
            let pixel = |k: u32| 1.0 + noise * (f64::from(block(k)) / 1001.0 - 0.5);
            let image: Vec<f64> = (0..size * size).map(pixel).collect();
            assert_eq!(sum.add(&image), Ok(()));
        }
        sum.finish()
    }

    /// Uniform noise of a width has 0.29 of it as its deviation, a mean of 16 a fourth of that.
    #[test]
    fn blocks_that_are_noisy_are_told_where_photons_are_shared() {
        let told = |size, noise| blotches(Integrator::Map, &film(size, noise));
        assert!(told(64, 0.2).is_some_and(|said| said.contains("16 x 16") && said.contains("inclusion")));
        assert_eq!(told(64, 0.02), None);
        assert!(told(16, 0.2).is_some_and(|said| said.contains("4 x 4")));
        assert_eq!(blotches(Integrator::Path, &film(64, 0.2)), None);
        assert_eq!(told(64, 0.0), None);
    }
}
