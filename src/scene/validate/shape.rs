//! Rules of the touched face's shape: the dent fits in the soft layers and in the footprint.

use super::bounds::{ANY, POSITIVE, number};
use super::{Invalid, all};
use crate::scene::{Inner, Scene, Shape, Stack};
use std::path::Path;

/// What a Gaussian may still be at the wall, mm: a height that no pixel shows.
const FLAT_AT_WALL_MM: f64 = 1e-3;
/// Standard deviations from the centre to the wall after which a Gaussian counts as flat.
const FLAT_AT_SIGMAS: f64 = 3.5;

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let stack = &scene.stack;
    match &scene.touch.shape {
        Shape::Flat => Ok(()),
        Shape::SphericalDent { depth_mm, radius_mm, center_mm } => {
            let radius = number("touch.shape.radius_mm", *radius_mm, POSITIVE, 4.0);
            let fits = match &radius {
                Ok(()) => all([
                    overhang(*depth_mm, *radius_mm),
                    disc_in_footprint("touch.shape", *radius_mm, *center_mm, stack),
                ]),
                Err(_) => Ok(()),
            };
            all([depth(*depth_mm, scene), radius, fits])
        }
        Shape::GaussianDent { depth_mm, sigma_mm, center_mm } => {
            let own = all([
                depth(*depth_mm, scene),
                number("touch.shape.sigma_mm", *sigma_mm, POSITIVE, 3.0),
                center_in_footprint("touch.shape", *center_mm, stack),
            ]);
            own.and_then(|()| gaussian_flat_at_walls(*depth_mm, *sigma_mm, *center_mm, stack))
        }
        Shape::HeightMap { file, scale_mm } => {
            let known = extension("touch.shape.file", file, &["exr", "png", "csv"]);
            all([known, number("touch.shape.scale_mm", *scale_mm, ANY, -1.0)])
        }
        Shape::Mesh { file, .. } => extension("touch.shape.file", file, &["obj", "stl", "ply"]),
    }
}

fn overhang(depth_mm: f64, radius_mm: f64) -> Result<(), Invalid> {
    if depth_mm > radius_mm {
        let message = format!(
            "must be at most radius_mm ({radius_mm}), or the dent would overhang, is {depth_mm}; use a mesh for overhangs"
        );
        return Err(Invalid::new("touch.shape.depth_mm", message));
    }
    Ok(())
}

/// The dent stays above the rigid lowest layer where the inner interfaces follow, in the top layer where they do not.
fn depth(depth_mm: f64, scene: &Scene) -> Result<(), Invalid> {
    let layers = &scene.stack.layer;
    number("touch.shape.depth_mm", depth_mm, POSITIVE, 1.0)?;
    let (room, what) = match (scene.touch.inner, layers.as_slice()) {
        (_, [only]) => (only.thickness_mm, "the only layer's thickness"),
        (Inner::Follow, [soft @ .., _]) => {
            (soft.iter().map(|layer| layer.thickness_mm).sum(), "what lies above the rigid lowest layer")
        }
        (Inner::Flat, [top, ..]) => (top.thickness_mm, "the top layer's thickness, as inner is flat"),
        (_, []) => return Ok(()),
    };
    if depth_mm >= room {
        let message = format!("must be below {room} ({what}), is {depth_mm}; for example {:?}", room / 2.0);
        return Err(Invalid::new("touch.shape.depth_mm", message));
    }
    Ok(())
}

/// A disc wholly within the footprint; the key is the radius where no place would do, the centre otherwise.
pub(super) fn disc_in_footprint(key: &str, radius_mm: f64, center_mm: [f64; 2], stack: &Stack) -> Result<(), Invalid> {
    let axes = center_mm.into_iter().zip(stack.footprint_mm).enumerate();
    all(axes.map(|(axis, (center, extent))| {
        let room = extent / 2.0 - radius_mm;
        if room < 0.0 {
            let message = format!("must be at most {} to lie within the footprint, is {radius_mm}", extent / 2.0);
            return Err(Invalid::new(format!("{key}.radius_mm"), message));
        }
        number(&format!("{key}.center_mm[{axis}]"), center, -room..=room, 0.0)
    }))
}

/// A centre within the footprint.
pub(super) fn center_in_footprint(key: &str, center_mm: [f64; 2], stack: &Stack) -> Result<(), Invalid> {
    let axes = center_mm.into_iter().zip(stack.footprint_mm).enumerate();
    all(axes.map(|(axis, (center, extent))| {
        number(&format!("{key}.center_mm[{axis}]"), center, -extent / 2.0..=extent / 2.0, 0.0)
    }))
}

fn gaussian_flat_at_walls(depth_mm: f64, sigma_mm: f64, center_mm: [f64; 2], stack: &Stack) -> Result<(), Invalid> {
    let to_wall = center_mm
        .into_iter()
        .zip(stack.footprint_mm)
        .map(|(center, extent)| extent / 2.0 - center.abs())
        .fold(f64::INFINITY, f64::min);
    let sigmas = to_wall / sigma_mm;
    if sigmas >= FLAT_AT_SIGMAS || depth_mm * (-0.5 * sigmas * sigmas).exp() < FLAT_AT_WALL_MM {
        return Ok(());
    }
    let most = to_wall / FLAT_AT_SIGMAS;
    let message = format!(
        "must be at most {most} for the dent to be flat at the wall, {to_wall} mm from its centre, is {sigma_mm}"
    );
    Err(Invalid::new("touch.shape.sigma_mm", message))
}

/// A file of a kind that can be read, by its extension.
pub(super) fn extension(key: &str, file: &Path, known: &[&str]) -> Result<(), Invalid> {
    let given = file.extension().and_then(|e| e.to_str()).unwrap_or("");
    if known.iter().any(|one| given.eq_ignore_ascii_case(one)) {
        return Ok(());
    }
    let message = format!("must end in .{}, is {:?}", known.join(" or ."), file);
    Err(Invalid::new(key, message))
}
