//! What the images of a study are read by.

use super::{How, Paper, PaperFigure, Parts, StudyError};
use crate::calibrate::{FrameModel, ready};
use crate::estimate::Calibration;

/// What images are read by.
pub enum Reader<'a> {
    /// A figure of the paper, and a calibration of the sensor.
    Paper(&'a Paper, Option<Calibration>),
    /// What was learnt of frames.
    Model(Box<FrameModel>),
}

impl<'a> Reader<'a> {
    /// That of a study.
    ///
    /// # Errors
    /// A calibration that cannot be read, or lacks what a figure needs.
    pub fn of(parts: &'a Parts) -> Result<Self, StudyError> {
        let file = parts.calibration.as_deref();
        if let Some(paper) = &parts.paper {
            let calibration = file.map(Calibration::load).transpose()?;
            let is_whole =
                |known: &Calibration| known.bottom_area_mm2.and(known.force_n_from_sum_grey.as_ref()).is_some();
            let lacks = paper.figure == PaperFigure::Stiffness && !calibration.as_ref().is_some_and(is_whole);
            return match file.filter(|_| lacks) {
                Some(file) => Err(StudyError::Lacking { file: file.into() }),
                None => Ok(Self::Paper(paper, calibration)),
            };
        }
        let model = match file {
            Some(file) => FrameModel::load(file)?,
            None => ready().ok_or(StudyError::Damaged)?.clone(),
        };
        Ok(Self::Model(Box::new(model)))
    }
}

impl Parts {
    /// How each phantom is tried: `empty`, of phantoms without an inclusion; exposed twice where nothing is said.
    pub fn how(&self, empty: bool) -> How<'_> {
        let Self { exposures, exposure_ms, force_error, .. } = *self;
        let depths_mm = self.depths_mm.as_deref();
        How { empty, exposures: exposures.unwrap_or(2), exposure_ms, force_error, depths_mm }
    }
}
