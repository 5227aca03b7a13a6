//! Ladders of the light: samples and integrator, texels of the map, points of height fields, arithmetic.

use super::{ErrorEstimate, Rung, is_lit, is_soft, square_error};
use crate::film::Film;
use crate::mechanics::press::{PressStep, Pressed};
use crate::pipeline::model_of;
use crate::progress::{Observer, Stage};
use crate::scene::{IntegratorChoice, LoadedScene};
use crate::streams::{Role, Streams};
use crate::surface::SurfaceError;
use crate::trace::{Devices, Integrator, Kernel, Model, Outcome, Plan, Precision, Settings, TraceError, render};
use thiserror::Error;

/// Fewest camera paths a pixel: a render has 16 replicates.
const LEAST_SPP: u32 = 16;
/// The reference has so many times the samples of the highest rung.
const REFERENCE: u32 = 4;

/// Why a rung could not be rendered.
#[derive(Debug, Error)]
#[allow(missing_docs)] // each variant is the error of one stage
pub enum LightError {
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// Sizes that must agree do not.
    #[error("the reference has another size than the image")]
    Size,
}

/// The scene whose ladders are climbed.
pub struct Subject<'a> {
    /// The scene, its camera as wanted.
    pub loaded: &'a LoadedScene,
    /// Its press and the load that is traced, where it has one.
    pub press: Option<(&'a Pressed, &'a PressStep)>,
    /// What is asked of the light; work and integrator are the rungs'.
    pub settings: Settings,
    /// What traces it.
    pub devices: &'a Devices,
    /// Highest number of samples.
    pub most_spp: u32,
    /// Runs of each rung.
    pub repeats: u32,
    /// Fewer rungs.
    pub quick: bool,
}

/// Settings of one rung, or of the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The ladder and which of its series.
    pub family: &'static str,
    /// Which of the family's ladders.
    pub series: String,
    /// In words.
    pub setting: String,
    /// The value varied.
    pub level: Option<f64>,
    /// Camera paths a pixel; as many photons a pixel.
    pub spp: u32,
    /// Integrator asked for.
    pub integrator: IntegratorChoice,
    /// Texel of the map, mm.
    pub texel_mm: f64,
    /// Points of height fields.
    pub points: u32,
    /// The built-in tracer in this precision, in place of what else traces.
    pub twin: Option<Precision>,
    /// Whether a run without flags takes these.
    pub is_default: bool,
}

impl Subject<'_> {
    fn model(&self, choice: &Choice) -> Result<Model<f64>, LightError> {
        let mut loaded = self.loaded.clone();
        loaded.scene.render.map_texel_mm = choice.texel_mm;
        loaded.scene.render.height_field_points = choice.points;
        Ok(model_of(&loaded, self.press)?.2)
    }

    /// The settings of a run without flags, as a rung.
    fn default(&self) -> Choice {
        let render = &self.loaded.scene.render;
        Choice {
            family: "samples",
            series: String::new(),
            setting: String::new(),
            level: None,
            spp: render.spp.max(LEAST_SPP).min(self.most_spp),
            integrator: render.integrator,
            texel_mm: render.map_texel_mm,
            points: render.height_field_points,
            twin: None,
            is_default: false,
        }
    }

    /// The reference, and why it is a reference, in words.
    ///
    /// Methods without bias where they suit; otherwise a map of finer texels.
    ///
    /// # Errors
    /// [`LightError::Surface`]: as [`model_of`].
    pub fn reference(&self) -> Result<(Choice, String), LightError> {
        let model = self.model(&self.default())?;
        let kernel = Kernel::of(&model);
        let mut choice = Choice { spp: self.most_spp.saturating_mul(REFERENCE), ..self.default() };
        // The highest rung of each ladder of geometry is beside it: the reference is finer than all.
        if kernel.has_fields() {
            choice.points *= 2;
        }
        let spp = choice.spp;
        let why = if !kernel.touched {
            choice.integrator = IntegratorChoice::Path;
            format!("path, without bias, {spp} samples a pixel")
        } else if Plan::choose(IntegratorChoice::Splat, &kernel).is_ok() {
            choice.integrator = IntegratorChoice::Splat;
            format!("splat, without bias, {spp} samples a pixel")
        } else {
            choice.integrator = IntegratorChoice::Map;
            choice.texel_mm *= 0.5;
            format!("map with texels of {} mm, {spp} samples a pixel", choice.texel_mm)
        };
        Ok((choice, why))
    }

    /// All rungs.
    ///
    /// # Errors
    /// As [`Self::reference`]; [`TraceError::Unsuited`] where the scene's own integrator does not suit it.
    pub fn choices(&self) -> Result<Vec<Choice>, LightError> {
        let default = self.default();
        let kernel = Kernel::of(&self.model(&default)?);
        let chosen = Plan::choose(default.integrator, &kernel)?.integrator;
        let mut choices = self.samples(&kernel, chosen);
        if chosen == Integrator::Map {
            // Half the default costs several times as much, in the choice of the smoothing alone.
            let factors: &[f64] = if self.quick { &[4.0, 2.0, 1.0] } else { &[8.0, 4.0, 2.0, 1.0, 0.5] };
            choices.extend(factors.iter().map(|factor| factor * default.texel_mm).map(|texel_mm| Choice {
                family: "map texel",
                series: "map".into(),
                setting: format!("texels of {texel_mm} mm"),
                level: Some(texel_mm),
                texel_mm,
                is_default: texel_mm == default.texel_mm,
                ..default.clone()
            }));
        }
        if kernel.has_fields() {
            let points = [16, 8, 4, 2, 1].map(|divisor| default.points / divisor);
            choices.extend(points.into_iter().filter(|&points| points >= 8).map(|points| Choice {
                family: "height field",
                series: chosen.name().into(),
                setting: format!("{points} points"),
                level: Some(f64::from(points)),
                points,
                is_default: points == default.points,
                ..default.clone()
            }));
        }
        choices.extend(self.precisions(&default, chosen));
        Ok(choices)
    }

    /// A ladder of samples for each integrator that suits the scene.
    fn samples(&self, kernel: &Kernel, chosen: Integrator) -> Vec<Choice> {
        let default = self.default();
        let mut choices = Vec::new();
        for integrator in [Integrator::Path, Integrator::Map, Integrator::Splat] {
            let asked = IntegratorChoice::from(integrator);
            if Plan::choose(asked, kernel).is_err() {
                continue;
            }
            let mut spp = self.most_spp;
            let mut ladder = Vec::new();
            while spp >= LEAST_SPP && ladder.len() < 5 {
                ladder.push(spp);
                spp /= if self.most_spp >= 16 * LEAST_SPP { 4 } else { 2 };
            }
            choices.extend(ladder.into_iter().rev().map(|spp| Choice {
                series: integrator.name().into(),
                setting: format!("{spp} samples a pixel"),
                level: Some(f64::from(spp)),
                spp,
                integrator: asked,
                is_default: integrator == chosen && spp == default.spp,
                ..default.clone()
            }));
        }
        choices
    }

    /// The same image in f32 and f64 on the CPU, and on the GPU where that is what is asked for.
    fn precisions(&self, default: &Choice, chosen: Integrator) -> Vec<Choice> {
        let is_gpu = self.devices.is_gpu();
        let cpu = [(Some(Precision::F32), "cpu f32"), (Some(Precision::F64), "cpu f64")];
        let choice = |(twin, name): (Option<Precision>, &str)| Choice {
            family: "precision",
            series: name.into(),
            setting: format!("{name}, {}", chosen.name()),
            twin,
            is_default: twin == (!is_gpu).then_some(Precision::F32),
            ..default.clone()
        };
        is_gpu.then_some((None, "gpu f32")).into_iter().chain(cpu).map(choice).collect()
    }

    fn render(&self, choice: &Choice, role: Role, observe: &mut Observer) -> Result<Outcome, LightError> {
        let model = self.model(choice)?;
        let pixels = u64::from(model.camera.size[0]) * u64::from(model.camera.size[1]);
        let settings = Settings {
            integrator: choice.integrator,
            spp: choice.spp,
            // As many photons as camera paths on every rung, so that a ladder of samples is one of both.
            photons: Some((pixels * u64::from(choice.spp)).max(1 << 14)),
            seconds: None,
            target_error: None,
            seed: Streams::new(self.settings.seed, &*self.loaded.sha256, role).light(),
        };
        let twin = choice.twin.map(Devices::cpu);
        Ok(render(twin.as_ref().unwrap_or(self.devices), &model, &settings, observe)?)
    }

    /// Renders the reference.
    ///
    /// # Errors
    /// As [`model_of`] and [`render()`].
    pub fn render_reference(&self, choice: &Choice, observe: &mut Observer) -> Result<Film, LightError> {
        Ok(self.render(choice, Role::Reference, observe)?.film)
    }

    /// Renders a rung, each time with random numbers of its own, and compares it: over the lit pixels, and where tissue
    /// touches over the softly lit ones too. Empty where the reference is dark.
    ///
    /// # Errors
    /// As [`Self::render_reference`]; [`LightError::Size`] where the reference has another number of pixels.
    pub fn measure(&self, choice: &Choice, reference: &Film, observe: &mut Observer) -> Result<Vec<Rung>, LightError> {
        let mut parts = vec![("radiance", "", is_lit(reference))];
        if self.loaded.scene.touch.contact.is_some() {
            parts.push(("soft light", ", soft light", is_soft(reference)));
        }
        let (mut films, mut seconds) = (Vec::new(), 0.0);
        for repeat in 0..self.repeats {
            let done = f64::from(repeat) / f64::from(self.repeats);
            let outcome = self.render(choice, Role::Rung(repeat), &mut |stage| {
                observe(Stage { done: done + stage.done / f64::from(self.repeats), ..stage })
            })?;
            if outcome.film.mean.len() != reference.mean.len() {
                return Err(LightError::Size);
            }
            films.push(outcome.film);
            seconds += outcome.seconds / f64::from(self.repeats);
        }
        let rung = |(quantity, suffix, mask): &(&str, &str, Vec<bool>)| {
            let both: Option<Vec<[f64; 2]>> = films.iter().map(|film| square_error(film, reference, mask)).collect();
            let squares: Vec<f64> = both.as_ref()?.iter().map(|both| both[0]).collect();
            let noise = both.as_ref()?.first()?[1];
            // The mean variance of n replicates is known to sqrt(2/(n - 1)) a patch of pixels that share photons.
            let patches = (mask.iter().filter(|lit| **lit).count() as f64 / 256.0).max(1.0);
            let share = (2.0 / f64::from(reference.replicates.max(2) - 1) / patches).sqrt();
            Some(Rung {
                family: choice.family.into(),
                series: format!("{}{suffix}", choice.series),
                setting: choice.setting.clone(),
                level: choice.level,
                quantity: (*quantity).into(),
                error: ErrorEstimate::of_squares(&squares, noise, share),
                seconds,
                repeats: self.repeats,
                is_default: choice.is_default,
            })
        };
        Ok(parts.iter().filter_map(rung).collect())
    }
}
