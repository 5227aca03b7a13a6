//! The calibration that comes with the program, and frames of a scene read by it.

use super::{FORCE_ERROR, FrameModel, Frames, PressFrame};
use crate::estimate::{Estimates, GreyImage};
use crate::scene::LoadedScene;
use std::path::Path;
use std::sync::LazyLock;

/// Of the paper's sensor and phantoms: `scenes/calibrations/`.
static READY: LazyLock<Option<FrameModel>> = LazyLock::new(|| {
    let text = include_str!("../../scenes/calibrations/phantoms.json");
    FrameModel::parse(text, Path::new("phantoms.json")).ok()
});

/// The calibration of the paper's sensor and phantoms.
pub fn ready() -> Option<&'static FrameModel> {
    READY.as_ref()
}

/// What frames of a scene's press, by their depths in mm, say of its inclusion: by a calibration that is given, or by
/// the one that comes with the program. Undefined, with the reason, where it does not suit the scene.
pub fn estimates_of(given: Option<&FrameModel>, loaded: &LoadedScene, frames: &[(f64, GreyImage)]) -> Estimates {
    let (model, which) = match given {
        Some(model) => (Some(model), "the calibration does not suit"),
        None => (ready(), "the one that comes with the program does not suit"),
    };
    let Some(model) = model else { return Estimates::without_model() };
    if frames.is_empty() {
        return Estimates::undefined("no calibrated model: nothing is pressed");
    }
    match model.suits(loaded) {
        Err(why) => Estimates::undefined(&format!("no calibrated model: {which}: {why}")),
        Ok(()) => {
            let scene = &loaded.scene;
            let (camera, wavelength_nm) = (&scene.camera, scene.light.wavelength_nm);
            let frames =
                frames.iter().map(|(depth_mm, image)| PressFrame { depth_mm: *depth_mm, image, force_n: None });
            // A scene may press to other depths too.
            let frames = frames.filter(|frame| model.depths_mm.iter().any(|depth_mm| frame.is_of(*depth_mm))).collect();
            model.estimates(&Frames { camera, wavelength_nm, frames, force_error: FORCE_ERROR })
        }
    }
}
