//! Rules of the stack: footprint, walls, layers, roughness.

use super::bounds::{NOT_NEGATIVE, POSITIVE, above, number};
use super::{Invalid, all, elastic};
use crate::scene::{Layer, Roughness, Scene, Stack, Walls};

/// Layers that the tracer's fixed-size interface table holds.
const MAX_LAYERS: usize = 32;
/// Largest extent of the stack, mm: f32 then still resolves 0.1 um.
pub(super) const MAX_EXTENT_MM: f64 = 1000.0;
/// Thinnest layer, mm (10 nm): below it a layer is no layer to geometrical optics.
const MIN_THICKNESS_MM: f64 = 1e-5;

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let stack = &scene.stack;
    let wavelength_nm = scene.light.wavelength_nm;
    let extent = |axis: usize| {
        let key = format!("stack.footprint_mm[{axis}]");
        number(&key, stack.footprint_mm[axis], above(0.0, MAX_EXTENT_MM, true), 30.0)
    };
    let walls = match stack.walls {
        Walls::Mirror { reflectance } => number("stack.walls.reflectance", reflectance, 0.0..=1.0, 0.95),
        Walls::Clear | Walls::Black => Ok(()),
    };
    all([
        extent(0),
        extent(1),
        walls,
        number("stack.surround_n", stack.surround_n, 1.0..=4.0, 1.0),
        layers(stack, wavelength_nm),
        roughness("stack.lower_roughness", stack.lower_roughness, wavelength_nm),
    ])
}

fn layers(stack: &Stack, wavelength_nm: f64) -> Result<(), Invalid> {
    if stack.layer.is_empty() || stack.layer.len() > MAX_LAYERS {
        let message = format!(
            "must have from 1 to {MAX_LAYERS} layers, has {}; give each a [[stack.layer]], touch side first",
            stack.layer.len()
        );
        return Err(Invalid::new("stack.layer", message));
    }
    let each = stack.layer.iter().enumerate();
    let each = all(each.map(|(index, one)| layer(&format!("stack.layer[{index}]"), one, wavelength_nm)));
    all([each, elastic::check_stack(&stack.layer)])?;
    if stack.height_mm() > MAX_EXTENT_MM {
        let message =
            format!("the layers must be at most {MAX_EXTENT_MM} mm thick together, are {}", stack.height_mm());
        return Err(Invalid::new("stack.layer", message));
    }
    Ok(())
}

fn layer(key: &str, layer: &Layer, wavelength_nm: f64) -> Result<(), Invalid> {
    if layer.name.is_empty() || layer.name.len() > 100 || layer.name.chars().any(char::is_control) {
        let message = "must be 1 to 100 printable characters; for example \"PDMS 1.41\"";
        return Err(Invalid::new(format!("{key}.name"), message));
    }
    let thickness_key = format!("{key}.thickness_mm");
    all([
        number(&thickness_key, layer.thickness_mm, POSITIVE, 2.0),
        number(&thickness_key, layer.thickness_mm, MIN_THICKNESS_MM..=MAX_EXTENT_MM, 2.0),
        index(key, layer, wavelength_nm),
        number(&format!("{key}.absorption_per_mm"), layer.absorption_per_mm, NOT_NEGATIVE, 0.003),
        roughness(&format!("{key}.upper_roughness"), layer.upper_roughness, wavelength_nm),
    ])
}

/// One index, given or of a known material.
fn index(key: &str, layer: &Layer, wavelength_nm: f64) -> Result<(), Invalid> {
    let index_key = format!("{key}.n");
    match (layer.n, layer.material) {
        (Some(n), None) => number(&index_key, n, 1.0..=4.0, 1.41),
        (None, Some(material)) => {
            let (least, most) = material.fitted_range_nm();
            if material.n(wavelength_nm).is_none() {
                let message = format!(
                    "{} is known from {least} to {most} nm, light.wavelength_nm is {wavelength_nm}; give n instead",
                    material.name()
                );
                return Err(Invalid::new(format!("{key}.material"), message));
            }
            Ok(())
        }
        (Some(_), Some(_)) => Err(Invalid::new(index_key, "give n or material, not both; for example n = 1.41")),
        (None, None) => Err(Invalid::new(index_key, "give n or material; for example n = 1.41")),
    }
}

fn roughness(key: &str, roughness: Roughness, wavelength_nm: f64) -> Result<(), Invalid> {
    match roughness {
        Roughness::None => Ok(()),
        Roughness::Small { rms_nm, lobe_slope } => {
            let rms_key = format!("{key}.rms_nm");
            number(&rms_key, rms_nm, NOT_NEGATIVE, 50.0)?;
            let most = wavelength_nm / 4.0;
            if rms_nm >= most {
                let message = format!(
                    "must be below {most} (a quarter of the wavelength) for kind small, is {rms_nm}; use kind = \"microfacet\""
                );
                return Err(Invalid::new(rms_key, message));
            }
            number(&format!("{key}.lobe_slope"), lobe_slope, above(0.0, 2.0, true), 0.1)
        }
        // Below 0.001 the facets' tilt is under the f32 resolution of a grazing half vector.
        Roughness::Microfacet { alpha } => number(&format!("{key}.alpha"), alpha, 0.001..=1.0, 0.2),
    }
}
