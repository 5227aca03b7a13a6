//! The file of a calibration: the sweeps that it is learnt from, and the way from it to what is learnt.

use super::{CalibrateError, FrameModel, Odd, Training};
use crate::progress::Observer;
use crate::scene::{Invalid, SceneError, parse_file, read_text};
use crate::sweep::{self, SweepFolderError};
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

/// Folders of a calibration's sweeps, computed or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folders {
    /// Phantoms with an inclusion.
    pub design: PathBuf,
    /// One LED at a time.
    pub leds: Option<PathBuf>,
    /// Phantoms without an inclusion.
    pub empty: Option<PathBuf>,
    /// Whether all points of all of them have ended.
    pub is_whole: bool,
}

/// What a calibration is learnt from.
pub struct Trainings {
    /// Phantoms with an inclusion.
    pub design: Training,
    leds: Option<Training>,
    empty: Option<Training>,
}

impl Parts {
    /// Has the sweeps computed that are no folders yet.
    ///
    /// # Errors
    /// As [`sweep::Parts::part`].
    pub fn folders<E: From<SweepFolderError>>(&self, work: &mut sweep::Parts<'_, E>) -> Result<Folders, E> {
        let design = work.part(&self.design, "design")?;
        let leds = self.leds.as_deref().map(|leds| work.part(leds, "leds")).transpose()?;
        let empty = self.empty.as_deref().map(|empty| work.part(empty, "empty")).transpose()?;
        Ok(Folders { design, leds, empty, is_whole: work.is_whole })
    }
}

impl Folders {
    /// Reads the images of all of them.
    ///
    /// # Errors
    /// As [`Training::read`].
    pub fn read(&self) -> Result<Trainings, CalibrateError> {
        let read = |folder: &Option<PathBuf>| folder.as_deref().map(Training::read).transpose();
        Ok(Trainings { design: Training::read(&self.design)?, leds: read(&self.leds)?, empty: read(&self.empty)? })
    }
}

impl Trainings {
    /// Learns from them; none where `observe` says no.
    ///
    /// # Errors
    /// As [`FrameModel::learn`].
    pub fn learn(&self, observe: &mut Observer) -> Result<Option<FrameModel>, CalibrateError> {
        FrameModel::learn(&self.design, self.leds.as_ref(), self.empty.as_ref(), observe)
    }

    /// Phantoms that do not go with the others of what it was learnt from.
    ///
    /// # Errors
    /// As [`FrameModel::odd`].
    pub fn odd(&self, model: &FrameModel) -> Result<Vec<Odd>, CalibrateError> {
        model.odd(&self.design)
    }
}

impl CalibrationFile {
    /// Reads a calibration file; its parts are then relative to the working folder.
    ///
    /// # Errors
    /// A file that cannot be read or is none.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::parse(&read_text(path)?, path)
    }

    /// The same of the text of a calibration file.
    ///
    /// # Errors
    /// A text that is none.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneError> {
        let schema = schemars::schema_for!(CalibrationFile).to_value();
        let rules = |_: &Self| -> Result<(), Invalid> { Ok(()) };
        let Self { calibrate } = parse_file::<Self>(text, path, &schema, rules)?.scene;
        let folder = path.parent().unwrap_or(Path::new(""));
        let beside = |part: PathBuf| folder.join(part);
        let (leds, empty) = (calibrate.leds.map(beside), calibrate.empty.map(beside));
        Ok(Self { calibrate: Parts { design: folder.join(calibrate.design), leds, empty, ..calibrate } })
    }
}
