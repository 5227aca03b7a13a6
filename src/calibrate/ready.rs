//! The calibration that comes with the program.

use super::FrameModel;
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
