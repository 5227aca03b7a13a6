//! What is said of an exposure that does not suit its image.

use super::note;
use crate::camera::Suited;
use crate::pages::facts::figure;

/// Notes an exposure time that does not suit the image, unless `quiet`.
pub(super) fn note_exposure(suited: &Suited, exposure_ms: f64, quiet: bool) {
    let wrong = match suited {
        _ if suited.is_dim() => "too dark",
        _ if suited.is_saturated() => "saturated",
        _ => return,
    };
    if let (Some(suggested_ms), false) = (suited.suggested_ms(), quiet) {
        let (now, suits) = (figure(exposure_ms), figure(suggested_ms));
        note(&format!(
            "the image is {wrong} at an exposure of {now} ms; {suits} ms would suit it (`expose` takes it anew)"
        ));
    }
}
