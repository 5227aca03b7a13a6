//! What is said of a shot and of a press: one set of names and units for tables, `--json` and whoever calls the
//! library.

use super::{Reading, Shot, Truth};
use crate::camera::{Frame, Suited};
use crate::estimate::{Estimates, PaperEstimate};
use crate::figure::{Digits, Figure};
use crate::film::Ledger;
use crate::mechanics::kinematics::Kinematics;
use crate::mechanics::newton::LinearSolver;
use crate::mechanics::press::{Load, PressStep, Pressed, PressureError, Setup};
use crate::trace::Outcome;
use crate::trace::batch::Times;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Why there are no mechanics.
pub const NO_MECHANICS: &str = "the scene presses nothing: it prescribes shape and contact, or has neither";

/// A traced image.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShotSummary {
    /// Name of the scene.
    pub scene: String,
    /// SHA-256 of each file that the scene names.
    pub inputs: BTreeMap<PathBuf, String>,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// What traced it.
    pub adapter: String,
    /// What was not done as asked, and why.
    pub notice: Option<String>,
    /// Method.
    pub integrator: &'static str,
    /// Why that one.
    pub why: &'static str,
    /// The user's seed.
    pub seed: u32,
    /// The light's own, made of it.
    pub stream: u32,
    /// What images share random numbers.
    pub random_numbers: &'static str,
    /// Camera paths per pixel.
    pub spp: u64,
    /// Images of which this is the mean.
    pub replicates: u32,
    /// Camera paths.
    pub paths: u64,
    /// Photons.
    pub photons: u64,
    /// Photons of the ledger.
    pub ledger_photons: u64,
    /// The map of light, if there is one.
    pub map: Figure<MapSummary>,
    /// Segments of paths and photons.
    pub segments: u64,
    /// Time to load the model and build kernels, seconds.
    pub setup_seconds: f64,
    /// Tracing time after that, seconds.
    pub seconds: f64,
    /// Where all time went.
    pub stages_seconds: StageSeconds,
    /// Segments for each second of tracing.
    pub segments_per_second: f64,
    /// Mean radiance, W/(m^2 sr).
    pub mean_radiance: f64,
    /// Root-mean-square standard error over the lit pixels over their mean.
    pub relative_error: Figure,
    /// The same of blocks of pixels.
    pub block_errors: Vec<BlockError>,
    /// Root-mean-square standard error of a pixel with what may be where no light was found, W/(m^2 sr).
    pub absolute_error: f64,
    /// Bound of the mean of a dark image, W/(m^2 sr).
    pub mean_radiance_below: Figure,
    /// Why the image must be dark, if it must.
    pub known_dark: Option<&'static str>,
    /// Where the light went.
    pub ledger: Ledger,
    /// The camera's frame.
    pub camera: CameraSummary,
}

/// Where time went, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct StageSeconds {
    /// The press with its error estimate.
    pub mechanics: f64,
    /// From the press to the surface that the tracer sees.
    pub surface: f64,
    /// Loading and kernels.
    pub setup: f64,
    /// Photons.
    pub photons: f64,
    /// The map of light.
    pub map: f64,
    /// Camera paths.
    pub camera: f64,
    /// A ledger traced on its own.
    pub ledger: f64,
    /// Sums and error estimate.
    pub sums: f64,
    /// Files and pictures; 0 until there are some.
    pub files: f64,
}

/// The map of light.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapSummary {
    /// Edge of a texel, mm.
    pub texel_mm: f64,
    /// Width of the smoothing through true contact and through the gap, mm.
    pub smoothing_mm: [f64; 2],
    /// Bias of the smoothing in either, relative.
    pub relative_bias: [f64; 2],
    /// Places whose photons count for one, as the scene is its own mirror image: 1, 2 or 4.
    pub mirror_images: u32,
}

/// Error of a block of pixels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlockError {
    /// Edge of the block, pixels.
    pub edge_pixels: u32,
    /// Root-mean-square standard error over the lit blocks over their mean.
    pub relative_error: Figure,
}

/// A camera's frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CameraSummary {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Scale at the touched face.
    pub mm_per_pixel: f64,
    /// Highest grey level.
    pub max_grey: u16,
    /// Highest that there is.
    pub top_grey: u16,
    /// Pixels at that.
    pub saturated_pixels: usize,
    /// Sum of all grey levels.
    pub sum_grey: u64,
    /// Pixels brighter than the threshold of a reading, if the frame was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lit_pixels: Option<usize>,
    /// Exposure that would suit the image, ms.
    pub suggested_exposure_ms: Figure,
}

/// A press: its last load, and all of them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PressSummary {
    /// The last load.
    #[serde(flatten)]
    pub last: Option<StepSummary>,
    /// Axisymmetric, plane strain or three dimensions.
    pub setting: &'static str,
    /// Newton iterations.
    pub iterations: usize,
    /// Unknown displacements.
    pub dofs: usize,
    /// Elements.
    pub elements: usize,
    /// Least scaled Jacobian of an element.
    pub least_scaled_jacobian: f64,
    /// Time of the press, seconds.
    pub seconds: f64,
    /// Time of the error estimate, seconds.
    pub error_seconds: f64,
    /// How linear systems were solved.
    pub method: &'static str,
    /// Memory for that, MiB.
    pub factor_mib: f64,
    /// Each load.
    pub steps: Vec<StepSummary>,
}

/// A press at one load. Errors are relative.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepSummary {
    /// Motion of the phantom's base along z, mm.
    pub depth_mm: f64,
    /// Along x and y, mm.
    pub slide_mm: [f64; 2],
    /// How long it was held, s.
    pub hold_s: f64,
    /// Force along z, N.
    pub force_n: f64,
    /// Largest pressure over 0.8 of the footprint's radius, kPa.
    pub peak_pressure_kpa: f64,
    /// Its place on the undeformed face, x and y (r and 0 where axisymmetric), mm; none where nothing is borne.
    pub peak_at_mm: Option<[f64; 2]>,
    /// Of the pressure, root mean square.
    pub pressure_error: Figure,
    /// Of the peak pressure.
    pub peak_error: Figure,
    /// Of the force.
    pub force_error: Figure,
    /// What a sharp edge would change of the pressure.
    pub pressure_rounding: Figure,
    /// And of the force.
    pub force_rounding: Figure,
}

/// The paper's figures of a frame, and what they were read from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PaperSummary {
    /// The figures.
    #[serde(flatten)]
    pub figures: PaperEstimate,
    /// Brighter pixels are lit, grey levels.
    pub threshold_grey: f64,
    /// Name of what was subtracted, if anything.
    pub reference: Option<String>,
}

/// A shot with its truth, its press and what was read from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RunSummary {
    /// The shot.
    #[serde(flatten)]
    pub shot: ShotSummary,
    /// The paper's figures.
    pub paper: PaperSummary,
    /// What they say of the inclusion.
    pub estimates: Estimates,
    /// The press.
    pub mechanics: Figure<PressSummary>,
    /// What the phantom holds.
    pub truth: Truth,
    /// Frames of the loads before the last.
    pub earlier_frames: Vec<EarlierFrame>,
}

/// A frame of a load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EarlierFrame {
    /// Depth of the load, mm.
    pub depth_mm: f64,
    /// How far it had slid along x and y, mm.
    pub slide_mm: [f64; 2],
    /// How long it was held, s.
    pub hold_s: f64,
    /// Its file.
    pub file: String,
    /// The frame.
    pub camera: CameraSummary,
}

impl EarlierFrame {
    /// Of a shot of that load, written as `file`.
    pub fn of(shot: &Shot, step: &PressStep, file: String) -> Self {
        let &PressStep { depth_mm, slide_mm, hold_s, .. } = step;
        Self { depth_mm, slide_mm, hold_s, file, camera: shot.camera_summary() }
    }

    /// Name of the file of a press's load, from 0: by its depth, or by its number on a path.
    pub fn file_of(pressed: &Pressed, load: usize, step: &PressStep) -> String {
        match pressed.setup.load {
            Load::Path(_) => format!("camera_{}.png", load + 1),
            _ => {
                let digits = Digits::of(pressed.steps.iter().map(|step| step.depth_mm));
                format!("camera_{}mm.png", digits.written(step.depth_mm))
            }
        }
    }
}

impl Shot<'_> {
    /// What is said of the shot.
    pub fn summary(&self) -> ShotSummary {
        let outcome = &self.outcome;
        let texel_mm = self.prepared.scene().render.map_texel_mm;
        let map = outcome.smoothing.map(|smoothing| MapSummary {
            texel_mm,
            smoothing_mm: smoothing.widths.map(|width| width as f64 * texel_mm),
            relative_bias: smoothing.bias,
            mirror_images: self.prepared.model.symmetry.order(),
        });
        let dark = "the image is dark; absolute_error and mean_radiance_below say how dark";
        let block =
            |(edge_pixels, error)| BlockError { edge_pixels, relative_error: Figure::of(error, "the image is dark") };
        ShotSummary {
            scene: self.prepared.scene().name.clone(),
            inputs: self.prepared.loaded.inputs(),
            backend: outcome.backend,
            adapter: outcome.adapter.clone(),
            notice: outcome.notice.clone(),
            integrator: outcome.plan.integrator.name(),
            why: outcome.plan.why,
            seed: self.prepared.streams.seed,
            stream: self.prepared.settings.seed,
            random_numbers: self.prepared.streams.sharing.name(),
            spp: outcome.spp,
            replicates: outcome.film.replicates,
            paths: outcome.paths,
            photons: outcome.photons,
            ledger_photons: outcome.ledger_photons,
            map: Figure::of(map, "no map"),
            segments: outcome.segments,
            setup_seconds: outcome.setup_seconds,
            seconds: outcome.seconds,
            stages_seconds: self.stages_seconds(),
            segments_per_second: segments_per_second(outcome),
            mean_radiance: outcome.mean_radiance,
            relative_error: Figure::of(outcome.relative_error, dark),
            block_errors: outcome.block_errors().into_iter().map(block).collect(),
            absolute_error: outcome.unseen.absolute_error(&outcome.film),
            mean_radiance_below: Figure::of(outcome.unseen.mean_below, "the image is not dark"),
            known_dark: outcome.unseen.known_dark,
            ledger: outcome.ledger,
            camera: self.camera_summary(),
        }
    }

    /// What is said of the camera's frame.
    pub fn camera_summary(&self) -> CameraSummary {
        CameraSummary::of(&self.frame, self.mm_per_pixel, &self.suited)
    }

    /// What is said of the shot and of what was read from it, less a reference of that name.
    pub fn run_summary(&self, reading: &Reading, reference: Option<String>, truth: Truth) -> RunSummary {
        let mut shot = self.summary();
        let lit = self.frame.grey.iter().filter(|&&grey| f64::from(grey) > reading.threshold_grey).count();
        shot.camera.lit_pixels = Some(lit);
        let mechanics = self.prepared.pressed().map(|(pressed, _)| PressSummary::of(pressed));
        RunSummary {
            shot,
            paper: PaperSummary { figures: reading.paper.clone(), threshold_grey: reading.threshold_grey, reference },
            estimates: reading.estimates.clone(),
            mechanics: Figure::of(mechanics, NO_MECHANICS),
            truth,
            earlier_frames: Vec::new(),
        }
    }

    fn stages_seconds(&self) -> StageSeconds {
        let outcome = &self.outcome;
        let Times { photons, map, camera, ledger } = outcome.times;
        StageSeconds {
            mechanics: self.prepared.pressed().map_or(0.0, |(pressed, _)| pressed.seconds + pressed.error_seconds),
            surface: self.prepared.surface_seconds,
            setup: outcome.setup_seconds,
            photons,
            map,
            camera,
            ledger,
            sums: outcome.seconds - photons - map - camera,
            files: 0.0,
        }
    }
}

impl CameraSummary {
    /// Of a frame at a scale.
    pub fn of(frame: &Frame, mm_per_pixel: f64, suited: &Suited) -> Self {
        Self {
            pixels: [frame.width, frame.height],
            mm_per_pixel,
            max_grey: frame.max_grey(),
            top_grey: frame.top_grey(),
            saturated_pixels: frame.saturated_pixels(),
            sum_grey: frame.grey.iter().map(|&grey| u64::from(grey)).sum(),
            lit_pixels: None,
            suggested_exposure_ms: match *suited {
                Suited::Filled { suggested_ms, .. } => Figure::known(suggested_ms),
                Suited::Undefined(reason) => Figure::undefined(reason),
            },
        }
    }
}

impl PressSummary {
    /// Of a press.
    pub fn of(pressed: &Pressed) -> Self {
        let quality = pressed.assembly.problem.mesh.quality();
        let steps: Vec<_> = pressed.steps.iter().map(|step| StepSummary::of(pressed, step)).collect();
        Self {
            last: steps.last().cloned(),
            setting: setting(&pressed.setup),
            iterations: pressed.iterations,
            dofs: pressed.unknowns,
            elements: quality.elements,
            least_scaled_jacobian: quality.least_scaled_jacobian,
            seconds: pressed.seconds,
            error_seconds: pressed.error_seconds,
            method: method_name(pressed.method),
            factor_mib: pressed.factor_mib,
            steps,
        }
    }
}

impl StepSummary {
    /// Of one of its loads.
    pub(crate) fn of(pressed: &Pressed, step: &PressStep) -> Self {
        let without: Cow<'static, str> = match (&pressed.unestimated, pressed.error_seconds > 0.0, step.force_n) {
            (_, false, _) => "press.estimate_error is off".into(),
            (Some(why), ..) => format!("the coarser mesh that estimates it cannot be made: {why}").into(),
            (_, _, 0.0) => "nothing is borne, of which an error were a share".into(),
            _ => "the coarser mesh that estimates it does not reach this load".into(),
        };
        let sharp = "no flat rigid sensor with a rounded edge slides, or its arc takes half of the face";
        let rounding = step.error.and_then(|error| error.rounding);
        let bends = "the pressure is singular where the indenter's profile bends: its peak has no limit";
        let unresolved = "the elements do not resolve the contact: a higher press.resolution does";
        let share = |share: Option<f64>, without: &Cow<'static, str>| match share {
            Some(share) => Figure::of(PressureError::resolved(share), unresolved),
            None => Figure::undefined(without.clone()),
        };
        let otherwise = |known: &'static str| if step.error.is_some() { known.into() } else { without.clone() };
        let (without_peak, without_rounding) = (otherwise(bends), otherwise(sharp));
        Self {
            depth_mm: step.depth_mm,
            slide_mm: step.slide_mm,
            hold_s: step.hold_s,
            force_n: step.force_n,
            peak_pressure_kpa: step.peak_pressure_kpa,
            peak_at_mm: step.peak_at_mm,
            pressure_error: share(step.error.map(|error| error.rms), &without),
            peak_error: share(step.error.and_then(|error| error.peak), &without_peak),
            force_error: share(step.error.map(|error| error.force), &without),
            pressure_rounding: Figure::of(rounding.map(|rounding| rounding.rms), without_rounding.clone()),
            force_rounding: Figure::of(rounding.map(|rounding| rounding.force), without_rounding),
        }
    }
}

/// How linear systems are solved, in words.
pub(crate) fn method_name(method: LinearSolver) -> &'static str {
    match method {
        LinearSolver::Direct => "factorisation",
        LinearSolver::Multigrid => "multigrid",
    }
}

/// Name of the setting.
pub(crate) fn setting(setup: &Setup) -> &'static str {
    match setup.kinematics {
        Kinematics::Axisymmetric => "axisymmetric",
        Kinematics::PlaneStrain => "plane strain",
        Kinematics::ThreeDimensional => "three dimensions",
    }
}

/// Segments of camera paths and photons for each second of tracing.
pub(crate) fn segments_per_second(outcome: &Outcome) -> f64 {
    outcome.segments as f64 / outcome.seconds.max(1e-9)
}
