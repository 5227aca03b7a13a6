//! The file of a calibration: the sweeps that it is learnt from.

use crate::scene::{Invalid, SceneError, parse_file, read_text};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A calibration file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// What it is learnt from.
    pub calibrate: Parts,
}

/// The sweeps that a calibration is learnt from: sweep files, or folders of sweeps, relative to this file. All keep the
/// radiance of every load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// What the calibration is of.
    #[serde(default)]
    pub description: String,
    /// Phantoms with an inclusion, drawn at random.
    pub design: PathBuf,
    /// One LED at a time. Absent: the LEDs' powers are taken as the scene gives them.
    pub leds: Option<PathBuf>,
    /// Phantoms without an inclusion. Absent: whether there is an inclusion is not told.
    pub empty: Option<PathBuf>,
}

impl CalibrationFile {
    /// Reads a calibration file; its parts are then relative to the working folder.
    ///
    /// # Errors
    /// A file that cannot be read or is none.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let text = read_text(path)?;
        let schema = schemars::schema_for!(CalibrationFile).to_value();
        let rules = |_: &Self| -> Result<(), Invalid> { Ok(()) };
        let Self { calibrate } = parse_file::<Self>(&text, path, &schema, rules)?.scene;
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = |part: PathBuf| folder.join(part);
        let (leds, empty) = (calibrate.leds.map(beside), calibrate.empty.map(beside));
        Ok(Self { calibrate: Parts { design: folder.join(calibrate.design), leds, empty, ..calibrate } })
    }
}
