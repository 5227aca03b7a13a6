//! A kernel's WGSL text and override constants, chosen from what the scene needs.
//!
//! | piece | taken where |
//! |---|---|
//! | `surface_plane`, `_cap`, `_field`, `_mesh` | one of them, by the shape of the deformed interfaces |
//! | `smooth` or `rough` | some interface is rough |
//! | `touch_none`, or `touch` with `touch_camera` or `touch_photons` | tissue touches |
//! | `record_none` or `record` | event histories are wanted (tests) |
//!
//! Everything smaller is an override constant, folded when the pipeline is built.

use crate::trace::backend::{CameraMode, PhotonMode};
use crate::trace::kernel::{Kernel, ShapePiece};

macro_rules! piece {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name, ".wgsl"))
    };
}

/// Which entry point, and what it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Entry {
    /// Camera paths.
    Camera(CameraMode),
    /// Photons.
    Photons(PhotonMode),
}

/// The WGSL text of a kernel.
pub fn source(kernel: &Kernel, entry: Entry, recording: bool) -> String {
    let mut pieces = vec![
        piece!("lib/scene"),
        piece!("lib/random"),
        piece!("lib/fresnel"),
        piece!("lib/fixed_point"),
        match kernel.shape {
            ShapePiece::Plane => piece!("lib/surface_plane"),
            ShapePiece::Cap => piece!("lib/surface_cap"),
            ShapePiece::Field => piece!("lib/surface_field"),
            ShapePiece::Mesh => piece!("lib/surface_mesh"),
        },
        if kernel.rough { piece!("lib/rough") } else { piece!("lib/smooth") },
        piece!("lib/led"),
        piece!("lib/walk"),
        if recording { piece!("lib/record") } else { piece!("lib/record_none") },
    ];
    if kernel.touched {
        pieces.push(piece!("lib/touch"));
        pieces.push(match entry {
            Entry::Camera(_) => piece!("lib/touch_camera"),
            Entry::Photons(_) => piece!("lib/touch_photons"),
        });
    } else {
        pieces.push(piece!("lib/touch_none"));
    }
    pieces.push(match entry {
        Entry::Camera(_) => piece!("entry/camera"),
        Entry::Photons(_) => piece!("entry/photons"),
    });
    pieces.concat()
}

/// Override constants of a kernel.
pub fn constants(kernel: &Kernel, entry: Entry) -> Vec<(&'static str, f64)> {
    let mut constants = vec![
        ("DEFORMED", kernel.deformed()),
        ("ABSORBING", kernel.absorbing),
        ("CLEAR_WALLS", kernel.clear_walls),
        ("MIRROR_WALLS", kernel.mirror_walls),
        ("ROUGH", kernel.rough),
        ("TOUCHED", kernel.touched),
        ("SPREADING", kernel.spreading),
        ("LED_TABLES", kernel.led_tables),
        ("LENS", kernel.lens),
    ];
    if kernel.touched {
        constants.push(("SHARE_GRID", kernel.share_grid));
    }
    match entry {
        Entry::Camera(mode) => {
            constants.extend([("MAPPED", mode == CameraMode::Mapped), ("COMPLEMENT", mode == CameraMode::Complement)])
        }
        Entry::Photons(mode) => {
            constants.extend([("MAPPED", mode == PhotonMode::Map), ("SPLATTED", mode == PhotonMode::Splat)])
        }
    }
    constants.into_iter().map(|(name, on)| (name, f64::from(u8::from(on)))).collect()
}
