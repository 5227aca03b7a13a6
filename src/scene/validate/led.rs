//! Rules of the LEDs: each wholly on its wall, none over another, with one measure of its light.

use super::bounds::{ANY, NOT_NEGATIVE, POSITIVE, above, number};
use super::{Invalid, all};
use crate::scene::{Led, Mount, Pattern, Scene, Stack, Wall, Walls};

/// LEDs that the tracer's table holds.
const MAX_LEDS: usize = 64;
/// Room for rounding where a disc touches an edge or another disc, mm.
const TOUCHING_MM: f64 = 1e-9;

pub(super) fn check(scene: &Scene) -> Result<(), Invalid> {
    let leds = &scene.led;
    if leds.is_empty() || leds.len() > MAX_LEDS {
        let message = format!("must have from 1 to {MAX_LEDS} LEDs, has {}; give each an [[led]]", leds.len());
        return Err(Invalid::new("led", message));
    }
    let one = |(index, led): (usize, &Led)| {
        let key = format!("led[{index}]");
        // Where the wall is wrong, no place on it is right.
        let stands = match wall_is_sound(&scene.stack) {
            true => all([on_its_wall(&key, led, &scene.stack), apart(&key, index, leds)]),
            false => Ok(()),
        };
        all([stands, mount(&key, led, &scene.stack), light(&key, led)])
    };
    all(leds.iter().enumerate().map(one))
}

fn wall_is_sound(stack: &Stack) -> bool {
    let heights = stack.layer.iter().map(|layer| layer.thickness_mm);
    !stack.layer.is_empty() && heights.chain(stack.footprint_mm).all(|extent| extent > 0.0 && extent.is_finite())
}

/// An LED and those before it on its wall.
fn apart(key: &str, index: usize, leds: &[Led]) -> Result<(), Invalid> {
    let Some(led) = leds.get(index) else { return Ok(()) };
    for (other_index, other) in leds.iter().enumerate().take(index) {
        let distance = (led.along_mm - other.along_mm).hypot(led.height_mm - other.height_mm);
        let least = (led.diameter_mm + other.diameter_mm) / 2.0;
        if led.wall == other.wall && distance < least - TOUCHING_MM {
            let message = format!(
                "overlaps led[{other_index}] on the same wall: centres must be at least {least} mm apart, are {distance}"
            );
            return Err(Invalid::new(format!("{key}.along_mm"), message));
        }
    }
    Ok(())
}

fn on_its_wall(key: &str, led: &Led, stack: &Stack) -> Result<(), Invalid> {
    let width = match led.wall {
        Wall::PlusX | Wall::MinusX => stack.footprint_mm[1],
        Wall::PlusY | Wall::MinusY => stack.footprint_mm[0],
    };
    let height = stack.height_mm();
    let diameter_key = format!("{key}.diameter_mm");
    number(&diameter_key, led.diameter_mm, POSITIVE, 3.0)?;
    let largest = width.min(height);
    if led.diameter_mm > largest + TOUCHING_MM {
        let message =
            format!("must be at most {largest} to fit on its wall of {width} by {height} mm, is {}", led.diameter_mm);
        return Err(Invalid::new(diameter_key, message));
    }
    let radius = led.diameter_mm / 2.0;
    for (name, value, low, high) in [
        ("along_mm", led.along_mm, radius - width / 2.0, width / 2.0 - radius),
        ("height_mm", led.height_mm, radius, height - radius),
    ] {
        let key = format!("{key}.{name}");
        let middle = (low + high) / 2.0;
        number(&key, value, ANY, middle)?;
        if value < low - TOUCHING_MM || value > high + TOUCHING_MM {
            let message =
                format!("the disc reaches over the edge of its wall: must be from {low} to {high}, is {value}");
            return Err(Invalid::new(key, message));
        }
    }
    Ok(())
}

fn mount(key: &str, led: &Led, stack: &Stack) -> Result<(), Invalid> {
    let Mount::Air { gap_mm } = led.mount else {
        return Ok(());
    };
    if stack.walls != Walls::Clear {
        let message = "an LED in air shines through clear walls only; use mount = { kind = \"bonded\" } or \
                       stack.walls = { kind = \"clear\" }";
        return Err(Invalid::new(format!("{key}.mount"), message));
    }
    number(&format!("{key}.mount.gap_mm"), gap_mm, NOT_NEGATIVE, 0.5)
}

fn light(key: &str, led: &Led) -> Result<(), Invalid> {
    let cutoff = led
        .cutoff_half_angle_deg
        .map_or(Ok(()), |cutoff| number(&format!("{key}.cutoff_half_angle_deg"), cutoff, above(0.0, 90.0, true), 72.0));
    let pattern = match led.pattern {
        Pattern::CosinePower { half_power_deg } => {
            number(&format!("{key}.pattern.half_power_deg"), half_power_deg, above(0.0, 90.0, false), 60.0)
        }
        _ => Ok(()),
    };
    all([amount(key, led), cutoff, pattern])
}

/// One measure of its light.
fn amount(key: &str, led: &Led) -> Result<(), Invalid> {
    let power_key = format!("{key}.power_mw");
    match (led.power_mw, led.radiance_w_per_m2_sr) {
        (Some(power), None) => number(&power_key, power, POSITIVE, 5.0),
        (None, Some(radiance)) => number(&format!("{key}.radiance_w_per_m2_sr"), radiance, POSITIVE, 1.0),
        (Some(_), Some(_)) => {
            let message = "give power_mw or radiance_w_per_m2_sr, not both; for example power_mw = 5.0";
            Err(Invalid::new(power_key, message))
        }
        (None, None) => {
            let message = "give power_mw or radiance_w_per_m2_sr; for example power_mw = 5.0";
            Err(Invalid::new(power_key, message))
        }
    }
}
