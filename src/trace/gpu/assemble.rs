//! A kernel's WGSL text and override constants, chosen from what the scene needs.
//!
//! | piece | taken where |
//! |---|---|
//! | `surface_plane`, `_cap`, `_field`, `_mesh` | one of them, by the shape of the deformed interfaces |
//! | `field_grid` or `field_profile` | height fields over the plane or about an axis |
//! | `smooth` or `rough` | some interface is rough |
//! | `touch_none`, or `touch` with `touch_camera` or `touch_photons` | tissue touches |
//! | `tissue_lambertian` or `tissue_half_space` | how tissue that touches is given |
//! | `record_none` or `record` | event histories are wanted (tests) |
//!
//! Everything smaller is an override constant, folded when the pipeline is built. The numbers of the scene are read
//! from a buffer, so that scenes of one make share their kernels (docs/decisions/kernels.md). `inspect` lists what is
//! in and what is left out; `inspect --gains` (`gains.rs`) measures what that is worth, by kernels that carry pieces to
//! spare.

use super::layout::{self, Numbers, Wgsl as _};
use crate::trace::constants;
use crate::trace::cpu::Limits;
use crate::trace::kernel::{Kernel, ShapePiece};
use crate::trace::launch;
use crate::trace::leds::Led;
use crate::trace::model::{Deformation, Face, Heights, Layer, Model};
use crate::trace::modes::{CameraMode, PhotonMode};
use crate::trace::scatter::Scatter;

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
    /// Rays that start where they are told: a look into the tracer.
    Probe,
}

/// The WGSL text of a kernel, and the numbers of the scene that it reads.
pub fn source(model: &Model<f32>, entry: Entry, recording: bool) -> (String, Numbers) {
    let kernel = Kernel::of(model);
    let (accessors, numbers) = accessors(model);
    let (shared, launches) = (constants::wgsl(), launch::wgsl());
    let mut pieces = vec![
        shared.as_str(),
        piece!("lib/scene"),
        accessors.as_str(),
        launches.as_str(),
        piece!("lib/random"),
        piece!("lib/fresnel"),
        piece!("lib/fixed_point"),
        match kernel.shape {
            ShapePiece::Plane => piece!("lib/surface_plane"),
            ShapePiece::Cap => piece!("lib/surface_cap"),
            ShapePiece::Field | ShapePiece::Profile => piece!("lib/surface_field"),
            ShapePiece::Mesh => piece!("lib/surface_mesh"),
        },
        match kernel.shape {
            ShapePiece::Field => piece!("lib/field_grid"),
            ShapePiece::Profile => piece!("lib/field_profile"),
            _ => "",
        },
        if kernel.rough { piece!("lib/rough") } else { piece!("lib/smooth") },
        piece!("lib/led"),
        piece!("lib/walk"),
        if recording { piece!("lib/record") } else { piece!("lib/record_none") },
    ];
    if kernel.touched {
        pieces.push(piece!("lib/touch"));
        pieces.push(match kernel.half_space {
            true => piece!("lib/tissue_half_space"),
            false => piece!("lib/tissue_lambertian"),
        });
        pieces.push(match entry {
            Entry::Camera(_) => piece!("lib/touch_camera"),
            Entry::Photons(_) | Entry::Probe => piece!("lib/touch_photons"),
        });
    } else {
        pieces.push(piece!("lib/touch_none"));
    }
    pieces.push(match entry {
        Entry::Camera(_) => piece!("entry/camera"),
        Entry::Photons(_) => piece!("entry/photons"),
        Entry::Probe => piece!("entry/probe"),
    });
    (pieces.concat(), numbers)
}

/// `read_scene`, and functions `layer_FIELD(k)`, `face_FIELD(i)` and `led_FIELD(k)` with the scene's numbers: chains
/// of selects over them.
fn accessors(model: &Model<f32>) -> (String, Numbers) {
    let field_vectors = match &model.shape {
        Deformation::Field(f) => match &f.heights {
            Heights::Grid { size, .. } => (size[0] - 1) * (size[1] + 2),
            Heights::Profile { cells, .. } => cells.first().map_or(0, Vec::len),
        },
        _ => 0,
    };
    let mut numbers = Numbers::default();
    // As a uniform it made llvmpipe compile the kernel anew for each replicate: it puts the values of uniforms that
    // decide branches into the kernel.
    let scene = layout::scene(model).wgsl(&mut numbers);
    let mut text = format!("var<private> scene: Scene;\nfn read_scene() {{ read_numbers(); scene = {scene}; }}\n");
    let mut float = |name: &str, values: Vec<f32>| {
        accessor(&mut text, name, "f32", values.into_iter().map(|value| numbers.hold(value)));
    };
    let layer = |get: fn(&Layer<f32>) -> f32| model.layers.iter().map(get).collect();
    float("layer_n", layer(|l| l.n));
    float("layer_n_sq", layer(|l| l.n_sq));
    float("layer_absorption", layer(|l| l.absorption));
    float("layer_side_dn_sq", layer(|l| l.side_dn_sq));
    let face = |get: fn(&Face<f32>) -> f32| model.faces.iter().map(get).collect();
    float("face_z", face(|f| f.z));
    float("face_share", face(|f| f.share));
    float("face_dn_sq", face(|f| f.dn_sq));
    float("face_curvature", face(|f| f.curvature));
    float("face_slope", face(|f| f.slope));
    float("face_low", face(|f| f.low));
    float("face_high", face(|f| f.high));
    float("face_rough", face(|f| f.rough));
    float("face_alpha", face(|f| f.alpha));
    let led = |get: fn(&Led<f32>) -> f32| model.leds.iter().map(get).collect();
    float("led_along", led(|l| l.along));
    float("led_height", led(|l| l.height));
    float("led_radius", led(|l| l.radius));
    float("led_gap", led(|l| l.gap));
    float("led_radiance", led(|l| l.radiance));
    float("led_exponent", led(|l| l.exponent));
    float("led_cos_cutoff", led(|l| l.cos_cutoff));
    float("led_launch", led(|l| l.launch));
    float("led_aim_low", led(|l| l.aim[0]));
    float("led_aim_high", led(|l| l.aim[1]));
    let word = |v: usize| format!("{v}u");
    accessor(&mut text, "led_wall", "u32", model.leds.iter().map(|l| word(l.wall as usize)));
    accessor(&mut text, "led_air", "u32", model.leds.iter().map(|l| word(usize::from(l.air))));
    accessor(
        &mut text,
        "led_table",
        "u32",
        model.leds.iter().map(|l| word(l.table.unwrap_or(constants::NO_TABLE as usize))),
    );
    let mut picked = |name: &str, cumulative: fn(&Led<f32>) -> f32| {
        let past = model.leds.iter().rev().skip(1);
        let past = past.map(|l| format!(" + select(0u, 1u, u >= {})", numbers.hold(cumulative(l))));
        text.push_str(&format!("fn {name}(u: f32) -> u32 {{ return 0u{}; }}\n", past.collect::<String>()));
    };
    picked("led_picked", |l| l.cumulative);
    picked("led_picked_aimed", |l| l.cumulative_aimed);
    if let Some(Scatter::HalfSpace(tissue)) = model.tissue.as_ref().map(|t| t.scatter) {
        let term = |[place, weight]: [f32; 2]| format!("{} / ({} + mu)", numbers.hold(weight), numbers.hold(place));
        text.push_str(&format!("fn h_terms(mu: f32) -> f32 {{ return {}; }}\n", tissue.terms.map(term).join(" + ")));
    }
    accessor(&mut text, "face_kind", "u32", model.faces.iter().map(|f| word(f.finish as usize)));
    accessor(&mut text, "face_field", "u32", model.faces.iter().map(|f| word(f.field * field_vectors)));
    (numbers.wgsl() + &text, numbers)
}

fn accessor(text: &mut String, name: &str, kind: &str, values: impl Iterator<Item = String>) {
    text.push_str(&format!("fn {name}(i: u32) -> {kind} {{ var v = {kind}(0);"));
    let mut last = None;
    for (k, value) in values.enumerate() {
        if last.as_ref() != Some(&value) {
            text.push_str(&format!(" v = select(v, {value}, i >= {k}u);"));
        }
        last = Some(value);
    }
    text.push_str(" return v; }\n");
}

/// Override constants of a kernel.
pub fn constants(kernel: &Kernel, entry: Entry, limits: Limits) -> Vec<(&'static str, f64)> {
    let mut constants = vec![
        ("DEFORMED", kernel.deformed()),
        ("DEFORMED_PAIRS", kernel.deformed_pairs),
        ("ABSORBING", kernel.absorbing),
        ("CLEAR_WALLS", kernel.clear_walls),
        ("MIRROR_WALLS", kernel.mirror_walls),
        ("ROUGH", kernel.rough),
        ("TOUCHED", kernel.touched),
        ("SPREADING", kernel.spreading),
        ("LED_TABLES", kernel.led_tables),
        ("LENS", kernel.lens),
        ("COSINE_POWER", kernel.cosine_power),
    ];
    if kernel.touched {
        constants.extend([("SHARE_GRID", kernel.share_grid), ("TISSUE_DISC", kernel.tissue_disc)]);
        if matches!(entry, Entry::Photons(_)) {
            constants.push(("SPLIT", limits.split));
        }
    }
    match entry {
        Entry::Camera(mode) => {
            let (mapped, complement) = (mode == CameraMode::Mapped, mode == CameraMode::Complement);
            let eye = mapped || !kernel.touched;
            constants.extend([("EYE", eye), ("MAPPED", mapped), ("COMPLEMENT", complement)]);
        }
        Entry::Photons(mode) => constants.extend([
            ("MAPPED", mode == PhotonMode::Map),
            ("SPLATTED", mode == PhotonMode::Splat),
            ("AIMED", kernel.aimed && mode != PhotonMode::Ledger),
        ]),
        Entry::Probe => constants.extend([("MAPPED", false), ("SPLATTED", false)]),
    }
    let mut constants: Vec<_> = constants.into_iter().map(|(name, on)| (name, f64::from(u8::from(on)))).collect();
    let limits = [
        ("ROULETTE_START", limits.roulette_start),
        ("EVENT_CAP", limits.event_cap),
        ("SEARCH_STEPS", limits.search_steps),
    ];
    constants.extend(limits.map(|(name, limit)| (name, f64::from(limit))));
    if kernel.touched && entry == Entry::Photons(PhotonMode::Map) {
        constants.push(("UNFOLDED", f64::from(kernel.unfolded)));
    }
    constants
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{LoadedScene, Shape as Dent};

    fn built(name: &str, change: impl Fn(&mut LoadedScene)) -> (String, Numbers) {
        let mut loaded = crate::scene::preset(name).unwrap();
        change(&mut loaded);
        let surface = crate::surface::surface(&loaded).unwrap();
        let contact = crate::surface::contact_map(&loaded).unwrap();
        let model = Model::new(&loaded, &surface, contact).unwrap().cast();
        source(&model, Entry::Camera(CameraMode::Path), false)
    }

    /// Sweeps change numbers: of these no kernel is compiled.
    #[test]
    fn scenes_that_differ_in_numbers_alone_share_their_text() {
        type Change = fn(&mut LoadedScene, f64);
        let changes: [(&str, Change); 6] = [
            ("contact-disc", |l, by| l.scene.stack.layer[0].thickness_mm *= by),
            ("contact-disc", |l, by| l.scene.stack.layer[1].n = Some(1.4 * by)),
            ("contact-disc", |l, by| l.scene.led.iter_mut().for_each(|led| led.diameter_mm *= by)),
            ("contact-disc", |l, by| l.scene.camera.distance_mm *= by),
            ("tsis-dent", |l, by| {
                l.scene.touch.shape = Dent::SphericalDent { depth_mm: 3.0 * by, radius_mm: 9.0, center_mm: [0.0; 2] };
            }),
            ("tsis-dent", |l, by| {
                l.scene.touch.shape = Dent::GaussianDent { depth_mm: by, sigma_mm: 3.0 * by, center_mm: [0.0; 2] };
            }),
        ];
        for (k, (name, change)) in changes.into_iter().enumerate() {
            let [(before, old), (after, new)] = [1.003, 1.007].map(|by| built(name, |loaded| change(loaded, by)));
            assert!(before == after, "{k}");
            assert_ne!(old.values(), new.values(), "{k}: the change is in the numbers");
        }
    }

    #[test]
    fn what_a_scene_gains_or_lacks_is_another_text() {
        let changes: [fn(&mut LoadedScene); 3] = [
            |l| l.scene.stack.layer.truncate(2),
            |l| l.scene.stack.layer[1].absorption_per_mm = 0.01,
            |l| l.scene.led.truncate(1),
        ];
        for (k, change) in changes.into_iter().enumerate() {
            assert!(built("flat-bonded", |_| ()).0 != built("flat-bonded", change).0, "{k}");
        }
    }
}
