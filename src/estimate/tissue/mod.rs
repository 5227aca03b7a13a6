//! The inverse of Galea and Howe ("Tissue stiffness from tactile imaging"): tissue thickness t and modulus E_t, radius
//! r and modulus E_l of a round inclusion, from the pressure frames of a scanned indenter.
//!
//! Each frame is reduced to peak, base, width and eccentricity ([`crate::mechanics::frames`]), of measured frames and
//! of simulated ones alike, and the unknowns are sought by least squares over the features of all frames:
//!
//! ```text
//! (y - f(x))' C^-1 (y - f(x)) -> least,   x = ln t, ln r, c = (k - 1)/(k + 1), ln E_t;   k = E_l / E_t
//! ```
//!
//! c is how strongly a round bar of an incompressible plane answers to a strain far away; frames follow it almost
//! linearly, while beyond k = 10 they hardly change with k. Moduli that are all scaled scale the pressures, so E_t
//! costs no simulation where the depth of the press is known. The depth of the inclusion is not among the paper's four:
//! it is known, or a fifth.
//!
//! - `unknowns.rs`: from unknowns to tissue, from tissue to features;
//! - `noise.rs`: C, of the noise that frames show themselves and of the mesh;
//! - `fit.rs`: Gauss-Newton steps with finite differences on a coarse mesh, which the difference of one scan on a fine
//!   mesh puts right;
//! - `told.rs`: draws of what is left open.
//!
//! Intervals are quantiles of draws from the linearised posterior, widened where the fit is worse than its noise. What
//! the frames leave open (as uncertain as before, draws that gather at an end of the range, a fit that fails) is
//! undefined, with the reason.

mod fit;
mod noise;
mod told;
mod unknowns;

use super::Value;
use crate::mechanics::frames::scan::ScanError;
use crate::mechanics::frames::{Frames, FramesError};
use crate::progress::Stage;
use crate::scene::{Elastic, InclusionBody, Interface, LoadedScan, PhantomBody};
use serde::Serialize;

pub use noise::{Noise, noisy};

/// What is known beside the frames, and what is sought.
#[derive(Debug, Clone)]
pub struct Question<'a> {
    /// Indenter, depth of the press, interface, Poisson's ratios, and a guess of the tissue: ranges are about it.
    pub scene: &'a LoadedScan,
    /// Whether the depth of the press is not known; each frame's own force is held instead.
    pub by_force: bool,
    /// Whether the inclusion's depth is sought too.
    pub free_depth: bool,
    /// Half width of the window of the parabola, mm; absent: the whole contact.
    pub window_mm: Option<f64>,
    /// Pressure up to which a place counts as not in contact, kPa.
    pub noise_kpa: f64,
    /// Seed of the draws.
    pub seed: u32,
}

/// What frames say of the tissue.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tissue {
    /// What is the same at each position, and known: `depth` or `force`.
    pub held: &'static str,
    /// Thickness of the tissue, mm.
    pub thickness_mm: Value,
    /// Young's modulus of the tissue, kPa.
    pub tissue_youngs_kpa: Value,
    /// Radius of the inclusion, mm.
    pub radius_mm: Value,
    /// Young's modulus of the inclusion, kPa.
    pub inclusion_youngs_kpa: Value,
    /// Modulus of the inclusion over that of the tissue.
    pub contrast: Value,
    /// Depth of the inclusion, to the point that the scene counts to, mm; only where it is sought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<Value>,
    /// Correlation of the estimates as far as the frames' noise goes: names, and a row for each.
    pub correlation: Correlation,
    /// Noise of the frames, as they show it themselves.
    pub noise: Noise,
    /// Features that were fitted.
    pub features: usize,
    /// Sum of squares of what the fit leaves, in units of its noise, over the degrees of freedom: about 1.
    pub reduced_chi_square: f64,
    /// What the eccentricities that were fitted compare with.
    pub reference: &'static str,
    /// Scans that were simulated.
    pub scans: usize,
    /// The fitted features, frame by frame.
    pub fitted: Vec<Fitted>,
}

/// Features of a frame of the tissue that fits best, those that were fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fitted {
    /// Position of the frame, mm.
    pub position_mm: f64,
    /// Peak of the parabola, kPa.
    pub peak_kpa: Option<f64>,
    /// Pressure at the ends of the window, kPa.
    pub base_kpa: Option<f64>,
    /// Width of the parabola, mm.
    pub fwhm_mm: Option<f64>,
    /// Asymmetry, against the frame farthest from position 0.
    pub eccentricity: Option<f64>,
}

/// Correlations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Correlation {
    /// Names of the estimates.
    pub names: Vec<&'static str>,
    /// A row for each.
    pub rows: Vec<Vec<f64>>,
}

/// Why there are no estimates at all.
#[derive(Debug, thiserror::Error)]
pub enum TissueError {
    /// The scene is not one tissue with one round inclusion.
    #[error("{key}: {rule}")]
    Scene {
        /// Key in the scene.
        key: &'static str,
        /// What it must be.
        rule: &'static str,
    },
    /// The frames.
    #[error(transparent)]
    Frames(#[from] FramesError),
    /// Too little to fit.
    #[error("{features} features of the frames can be fitted, {needed} at least must be")]
    TooFew {
        /// Those there are.
        features: usize,
        /// Those that are needed.
        needed: usize,
    },
    /// Too much to fit at once.
    #[error("{features} features of the frames are too many to be fitted together, {most} can be: leave frames out")]
    TooMany {
        /// Those there are.
        features: usize,
        /// Those that can be.
        most: usize,
    },
    /// A frame that is cut off tells no force.
    #[error("the frame at {position_mm} mm ends within the contact: its force is not known")]
    Cut {
        /// Its position, mm.
        position_mm: f64,
    },
    /// Overflow.
    #[error("the frames' features are too large or too small to be fitted")]
    NotFinite,
    /// The noise is not known.
    #[error("too few places of the frames are in contact to tell their noise: some ten a frame are needed")]
    NoNoise,
    /// A window that frames do not hold.
    #[error("a window of {window} mm on each side is more than the frames have: {half} mm")]
    Window {
        /// The window asked for, mm.
        window: f64,
        /// Half the frames' width, mm.
        half: f64,
    },
    /// Where noise decides where the contact ends, features of the whole contact jump.
    #[error("with pressures that count as noise the inverse needs a window within the contact")]
    NoWindow,
    /// A tissue that was found cannot be scanned.
    #[error("the fit stopped at a tissue that cannot be scanned: {0}")]
    Unpressed(String),
    /// A frame without contact has no force.
    #[error("the frame at {position_mm} mm has no force: nothing touches there")]
    NoForce {
        /// Its position, mm.
        position_mm: f64,
    },
    /// No tissue within the ranges could be scanned.
    #[error("no tissue within the ranges can be scanned as the frames were: {0}")]
    NoStart(String),
    /// A scan failed.
    #[error(transparent)]
    Scan(#[from] ScanError),
}

/// Estimates from measured frames. `observe` hears how far it is and may stop it.
///
/// # Errors
/// [`TissueError`]; an estimate that cannot be known is undefined instead.
pub fn invert(
    measured: &Frames,
    question: &Question,
    observe: &(dyn Fn(Stage) -> bool + Sync),
) -> Result<Tissue, TissueError> {
    check(question.scene, question.by_force)?;
    let half =
        measured.as_slice().first().map_or(0.0, |frame| frame.x_mm.iter().fold(0.0, |far: f64, x| far.max(x.abs())));
    match question.window_mm {
        Some(window) if window > half => return Err(TissueError::Window { window, half }),
        None if question.noise_kpa > 0.0 => return Err(TissueError::NoWindow),
        _ => {}
    }
    fit::fit(measured, question, observe)
}

/// Largest Poisson's ratio of tissue on which a force is held, by its compliance.
const MOST_POISSON: f64 = 0.49995;

/// One tissue, one round inclusion, moduli that are numbers; linear tissue that slides where a force is held.
///
/// # Errors
/// Names the key that is otherwise.
pub fn check(loaded: &LoadedScan, by_force: bool) -> Result<(), TissueError> {
    let wrong = |key, rule| Err(TissueError::Scene { key, rule });
    let phantom = &loaded.scene.phantom;
    let simple = |material: &Elastic| matches!(material, Elastic::Linear { .. } | Elastic::NeoHookean { .. });
    if !matches!(phantom.shape, PhantomBody::Block { .. }) {
        return wrong("phantom.shape", "the inverse is that of a block");
    }
    if !phantom.layer.is_empty() {
        return wrong("phantom.layer", "the inverse knows one tissue, without layers");
    }
    let [inclusion] = phantom.inclusion.as_slice() else {
        return wrong("phantom.inclusion", "the inverse knows one inclusion; give one, as a guess");
    };
    if !matches!(inclusion.shape, InclusionBody::Sphere { .. }) || inclusion.center_mm != [0.0; 2] {
        return wrong("phantom.inclusion[0]", "the inverse knows a round inclusion at x = 0");
    }
    let youngs = "the inverse knows Young's moduli: law = \"linear\" or \"neo_hookean\"";
    if !simple(&phantom.material) {
        return wrong("phantom.material", youngs);
    }
    if !simple(&inclusion.material) {
        return wrong("phantom.inclusion[0].material", youngs);
    }
    let can_hold = |material: &Elastic| matches!(material, Elastic::Linear { poisson, .. } if *poisson <= MOST_POISSON);
    if by_force && !(can_hold(&phantom.material) && can_hold(&inclusion.material)) {
        return wrong("phantom.material", "a force is held on tissues that are linear, with poisson at most 0.49995");
    }
    if by_force && loaded.scene.scan.interface != Interface::Frictionless {
        return wrong("scan.interface", "a force is held on tissue that slides freely: kind = \"frictionless\"");
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
