//! The file of a study: a calibration, and sweeps of phantoms to try it on.

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
    /// The calibration (JSON). Absent: the one that comes with the program.
    pub calibration: Option<PathBuf>,
    /// Phantoms with an inclusion.
    pub phantoms: PathBuf,
    /// Phantoms without one. Absent: how often an inclusion is found where there is none is not told.
    pub empty: Option<PathBuf>,
    /// Exposure of the frames, ms. Absent: the scene's.
    pub exposure_ms: Option<f64>,
    /// How often each phantom's frames are exposed, every time with noise of their own: what two or more tell of
    /// repeats.
    #[serde(default = "two")]
    pub exposures: u32,
}

fn two() -> u32 {
    2
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
            if !(1..=MOST).contains(&file.study.exposures) {
                return Err(Invalid::new("study.exposures", format!("must be 1 to {MOST}")));
            }
            match file.study.exposure_ms.is_none_or(|time| time > 0.0 && time.is_finite()) {
                true => Ok(()),
                false => Err(Invalid::new("study.exposure_ms", "must be above 0")),
            }
        };
        let Self { study } = parse_file::<Self>(&text, path, &schema, rules)?.scene;
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = |part: PathBuf| folder.join(part);
        let (calibration, empty) = (study.calibration.map(beside), study.empty.map(beside));
        Ok(Self { study: Parts { phantoms: folder.join(study.phantoms), calibration, empty, ..study } })
    }
}
