//! Rules of the optical contact: pressure, law and tissue.

use super::bounds::{NOT_NEGATIVE, POSITIVE, number};
use super::shape::{center_in_footprint, disc_in_footprint, extension};
use super::{Invalid, all};
use crate::scene::{ContactLaw, Pressure, Scene, Stack, Tissue};

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let Some(contact) = &scene.touch.contact else {
        return Ok(());
    };
    all([pressure(&contact.pressure, &scene.stack), law(contact.law), tissue(&contact.tissue)])
}

fn pressure(pressure: &Pressure, stack: &Stack) -> Result<(), Invalid> {
    let key = "touch.contact.pressure";
    let kpa = |name: &str, value: f64| number(&format!("{key}.{name}"), value, NOT_NEGATIVE, 1.0);
    match pressure {
        Pressure::Disc { radius_mm, center_mm, pressure_kpa } => {
            let radius = number(&format!("{key}.radius_mm"), *radius_mm, POSITIVE, 4.0);
            let place = radius.and_then(|()| disc_in_footprint(key, *radius_mm, *center_mm, stack));
            all([place, kpa("pressure_kpa", *pressure_kpa)])
        }
        Pressure::Hertz { peak_kpa, radius_mm, center_mm, base_kpa } => all([
            kpa("peak_kpa", *peak_kpa),
            number(&format!("{key}.radius_mm"), *radius_mm, POSITIVE, 4.0),
            center_in_footprint(key, *center_mm, stack),
            kpa("base_kpa", *base_kpa),
        ]),
        Pressure::Gaussian { peak_kpa, sigma_mm, center_mm, base_kpa } => all([
            kpa("peak_kpa", *peak_kpa),
            number(&format!("{key}.sigma_mm"), *sigma_mm, POSITIVE, 3.0),
            center_in_footprint(key, *center_mm, stack),
            kpa("base_kpa", *base_kpa),
        ]),
        Pressure::Table { file, center_mm } => {
            let known = extension(&format!("{key}.file"), file, &["csv"]);
            all([known, center_in_footprint(key, *center_mm, stack)])
        }
        Pressure::Map { file, scale_kpa } => {
            let known = extension(&format!("{key}.file"), file, &["exr", "png", "csv"]);
            all([known, number(&format!("{key}.scale_kpa"), *scale_kpa, POSITIVE, 1.0)])
        }
        // Its rules are those of the press.
        Pressure::Press => Ok(()),
    }
}

fn law(law: ContactLaw) -> Result<(), Invalid> {
    let positive =
        |name: &str, value: f64, example: f64| number(&format!("touch.contact.law.{name}"), value, POSITIVE, example);
    match law {
        ContactLaw::Full => Ok(()),
        ContactLaw::Persson { reduced_modulus_kpa, rms_slope } => {
            all([positive("reduced_modulus_kpa", reduced_modulus_kpa, 100.0), positive("rms_slope", rms_slope, 0.1)])
        }
        ContactLaw::GreenwoodWilliamson { pressure_scale_kpa } => {
            positive("pressure_scale_kpa", pressure_scale_kpa, 10.0)
        }
        ContactLaw::PerssonUnloading { reduced_modulus_kpa, rms_slope, peak_ratio, hold_kpa } => all([
            positive("reduced_modulus_kpa", reduced_modulus_kpa, 100.0),
            positive("rms_slope", rms_slope, 0.1),
            number("touch.contact.law.peak_ratio", peak_ratio, 1.0.., 2.0),
            number("touch.contact.law.hold_kpa", hold_kpa, NOT_NEGATIVE, 0.1),
        ]),
    }
}

fn tissue(tissue: &Tissue) -> Result<(), Invalid> {
    let key = |name: &str| format!("touch.contact.tissue.{name}");
    all([
        number(&key("n"), tissue.n, 1.0..=4.0, 1.4),
        whiteness(tissue),
        number(&key("spread_mm"), tissue.spread_mm, NOT_NEGATIVE, 1.0),
    ])
}

/// One measure of how much light it returns.
fn whiteness(tissue: &Tissue) -> Result<(), Invalid> {
    let key = |name: &str| format!("touch.contact.tissue.{name}");
    match (tissue.diffuse_reflectance, tissue.reduced_scattering_per_mm, tissue.absorption_per_mm) {
        (Some(reflectance), None, None) => number(&key("diffuse_reflectance"), reflectance, 0.0..=1.0, 0.5),
        (None, Some(scattering), Some(absorption)) => all([
            number(&key("reduced_scattering_per_mm"), scattering, POSITIVE, 1.0),
            number(&key("absorption_per_mm"), absorption, NOT_NEGATIVE, 0.01),
        ]),
        (None, Some(_), None) => {
            let message = "give it beside reduced_scattering_per_mm; for example 0.01";
            Err(Invalid::new(key("absorption_per_mm"), message))
        }
        (None, None, Some(_)) => {
            let message = "give it beside absorption_per_mm; for example 1.0";
            Err(Invalid::new(key("reduced_scattering_per_mm"), message))
        }
        (given, _, _) => {
            let message = match given {
                Some(_) => "give it or the two coefficients, not both; for example 0.5",
                None => "give it, or reduced_scattering_per_mm and absorption_per_mm; for example 0.5",
            };
            Err(Invalid::new(key("diffuse_reflectance"), message))
        }
    }
}
