//! The file of a study: a calibration, and sweeps of phantoms to try it on.

use super::{Paper, PaperFigure};
use crate::scene::{Invalid, SceneError, parse_file, read_text};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A study file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// What is studied.
    pub study: Parts,
}

/// A calibration and what it is tried on: sweep files, or folders of sweeps, relative to this file. All keep the
/// radiance of every load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// What the study is of.
    #[serde(default)]
    pub description: String,
    /// The calibration (JSON). Absent: the one that comes with the program. Of a study of the paper: that of the sensor
    /// (TOML), as `estimate` reads it; only the stiffness needs one.
    pub calibration: Option<PathBuf>,
    /// Phantoms with an inclusion.
    pub phantoms: PathBuf,
    /// Phantoms without one. Absent: how often an inclusion is found where there is none is not told.
    pub empty: Option<PathBuf>,
    /// Exposure of the frames, ms. Absent: the scene's.
    pub exposure_ms: Option<f64>,
    /// How often each phantom's frames are exposed, every time with noise of their own: what two or more tell of
    /// repeats. Default: 2. A study of the paper exposes each once: what repeats there are points of its sweep.
    pub exposures: Option<u32>,
    /// Relative standard deviation of the force of each load, which is told beside its frame, with an error drawn anew
    /// for each exposure. Absent: forces are not told.
    pub force_error: Option<f64>,
    /// Depths of the presses whose frames are told, mm, of those that the calibration knows. Absent: all.
    pub depths_mm: Option<Vec<f64>>,
    /// The images are read by a figure of the TSIS paper, and by no model of the frames.
    pub paper: Option<Paper>,
}

/// Most exposures.
const MOST: u32 = 100;

impl StudyFile {
    /// Reads a study file; its parts are then relative to the working folder.
    ///
    /// # Errors
    /// A file that cannot be read or is none.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = read_text(path)?;
        let schema = schemars::schema_for!(StudyFile).to_value();
        let rules = |file: &Self| -> Result<(), Invalid> {
            if file.study.exposures.is_some_and(|exposures| !(1..=MOST).contains(&exposures)) {
                return Err(Invalid::new("study.exposures", format!("must be 1 to {MOST}")));
            }
            if !file.study.exposure_ms.is_none_or(|time| time > 0.0 && time.is_finite()) {
                return Err(Invalid::new("study.exposure_ms", "must be above 0"));
            }
            if !file.study.force_error.is_none_or(|error| error > 0.0 && error < 1.0) {
                return Err(Invalid::new("study.force_error", "must be above 0 and below 1"));
            }
            if file.study.depths_mm.as_ref().is_some_and(Vec::is_empty) {
                return Err(Invalid::new("study.depths_mm", "must name a depth"));
            }
            let Some(paper) = &file.study.paper else { return Ok(()) };
            if file.study.depths_mm.is_some() {
                return Err(Invalid::new(
                    "study.depths_mm",
                    "has no meaning with study.paper: it reads the last loads",
                ));
            }
            if file.study.force_error.is_some() {
                return Err(Invalid::new(
                    "study.force_error",
                    "has no meaning with study.paper: it reads images alone",
                ));
            }
            if !(paper.threshold_grey >= 0.0 && paper.threshold_grey.is_finite()) {
                return Err(Invalid::new("study.paper.threshold_grey", "must be 0 or more"));
            }
            if paper.published.iter().flatten().flatten().any(|number| !(*number > 0.0 && number.is_finite())) {
                return Err(Invalid::new("study.paper.published", "must be pairs of numbers above 0"));
            }
            if paper.figure == PaperFigure::Stiffness && file.study.exposure_ms.is_some() {
                let what = "must be that of the scenes for a stiffness: the calibration's force is for one exposure";
                return Err(Invalid::new("study.exposure_ms", what));
            }
            if file.study.exposures.is_some_and(|exposures| exposures > 1) {
                let what = "must be 1 with study.paper: exposures of one press are no repeats of it";
                return Err(Invalid::new("study.exposures", what));
            }
            if file.study.empty.is_some() {
                return Err(Invalid::new("study.empty", "has no meaning with study.paper: its figures find nothing"));
            }
            match paper.figure == PaperFigure::Stiffness && file.study.calibration.is_none() {
                true => Err(Invalid::new("study.calibration", "is missing: the stiffness takes force from M by it")),
                false => Ok(()),
            }
        };
        let Self { study } = parse_file::<Self>(&text, path, &schema, rules)?.scene;
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = |part: PathBuf| folder.join(part);
        let (calibration, empty) = (study.calibration.map(beside), study.empty.map(beside));
        Ok(Self { study: Parts { phantoms: folder.join(study.phantoms), calibration, empty, ..study } })
    }
}
