//! The rules that a scene keeps beyond its structure: ranges, and parts that fit together.
//!
//! Every rule names one key, what it must be and a value that would do. The order is that of the file; the first broken
//! rule is the error, and the others go with it. Rules that lean on a part with a mistake wait until that is right:
//! what a disc on a wall of negative height may be is no help.

mod bounds;
mod camera;
mod contact;
mod elastic;
mod led;
mod phantom;
mod press;
mod scan;
mod shape;
mod stack;

use super::{IntegratorChoice, PressedSensor, ScanScene, Scene, Shape};
use bounds::{POSITIVE, number, whole};

/// A rule that a scene breaks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {message}")]
pub struct Invalid {
    /// Path of the key, as in `stack.layer[1].thickness_mm`.
    pub key: String,
    /// What the value must be, what it is, and one that would do.
    pub message: String,
    /// The other rules that the scene breaks, in the order of the file, each without others.
    pub others: Vec<Invalid>,
}

impl Invalid {
    pub(crate) fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), others: Vec::new() }
    }
}

/// All rules of a list: the first that is broken, and with it the others. A key is named once.
fn all(rules: impl IntoIterator<Item = Result<(), Invalid>>) -> Result<(), Invalid> {
    let mut found: Vec<Invalid> = Vec::new();
    for mut broken in rules.into_iter().filter_map(Result::err) {
        let others = std::mem::take(&mut broken.others);
        for one in std::iter::once(broken).chain(others) {
            if !found.iter().any(|known| known.key == one.key) {
                found.push(one);
            }
        }
    }
    let mut found = found.into_iter();
    found.next().map_or(Ok(()), |first| Err(Invalid { others: found.collect(), ..first }))
}

/// Checks every rule; for scenes made in memory as well as for those read from a file.
///
/// # Errors
/// The rules that the scene breaks.
pub fn validate(scene: &Scene) -> Result<(), Invalid> {
    let light = number("light.wavelength_nm", scene.light.wavelength_nm, 200.0..=2000.0, 532.0);
    // Materials are known over wavelengths, and what touches the stack is measured by it.
    let stack = if light.is_ok() { stack::check(scene) } else { Ok(()) };
    let touching = match light.is_ok() && stack.is_ok() {
        true => all([shape::check(scene), contact::check(scene), press::check(scene)]),
        false => Ok(()),
    };
    let own = all([name(&scene.name), light, stack, led::check(scene), camera::check(&scene.camera)]);
    all([own, touching, render(scene)])
}

/// Checks every rule of a scan scene.
///
/// # Errors
/// The rules that the scene breaks.
pub fn validate_scan(scene: &ScanScene) -> Result<(), Invalid> {
    all([name(&scene.name), phantom::check(&scene.phantom), scan::check(scene)])
}

/// The name becomes a folder of the output.
fn name(name: &str) -> Result<(), Invalid> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if name.is_empty() || name.starts_with('.') || !name.chars().all(plain) || name.len() > 100 {
        return Err(Invalid::new(
            "name",
            "must be a plain folder name of at most 100 letters, digits, '-', '_' and '.', not starting with '.'; \
             for example \"tsis-dent\"",
        ));
    }
    Ok(())
}

fn render(scene: &Scene) -> Result<(), Invalid> {
    let render = &scene.render;
    let photons = render.photons.map_or(Ok(()), |photons| whole("render.photons", photons, 1..=1 << 40, 1 << 20));
    all([
        splat(scene),
        whole("render.spp", render.spp.into(), 1..=1 << 24, 64),
        photons,
        texel(scene),
        whole("render.height_field_points", render.height_field_points.into(), 16..=2048, 256),
    ])
}

/// The method `splat` needs what the scene must not have.
fn splat(scene: &Scene) -> Result<(), Invalid> {
    let render = &scene.render;
    if render.integrator == IntegratorChoice::Splat && scene.touch.shape != Shape::Flat {
        return Err(Invalid::new(
            "render.integrator",
            "splat needs a flat stack and touch.shape deforms it; use \"auto\", \"path\" or \"map\"",
        ));
    }
    if render.integrator == IntegratorChoice::Splat
        && scene.press.as_ref().is_some_and(|press| press.sensor == PressedSensor::Deformable)
    {
        return Err(Invalid::new(
            "render.integrator",
            "splat needs a flat stack and the press deforms it; use \"auto\", \"path\" or \"map\"",
        ));
    }
    Ok(())
}

fn texel(scene: &Scene) -> Result<(), Invalid> {
    /// Texels along the longer side of the irradiance map: 4096^2 counters of 8 bytes are 128 MiB.
    const MAX_TEXELS: f64 = 4096.0;
    let render = &scene.render;
    number("render.map_texel_mm", render.map_texel_mm, POSITIVE, 0.25)?;
    let longest = scene.stack.footprint_mm[0].max(scene.stack.footprint_mm[1]);
    if longest / render.map_texel_mm > MAX_TEXELS {
        let message = format!(
            "must be at least {} (a map of at most {MAX_TEXELS} texels across), is {}; for example 0.25",
            longest / MAX_TEXELS,
            render.map_texel_mm
        );
        return Err(Invalid::new("render.map_texel_mm", message));
    }
    Ok(())
}

#[cfg(test)]
mod press_tests;
#[cfg(test)]
mod tests;
