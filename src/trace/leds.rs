//! LEDs as the tracers see them.
//!
//! Where the stack is flat and smooth and its walls are black, paths run straight when seen from above. Photons of a
//! map or a splat then start only between the directions that may meet the tissue (seen from above, the sine of the
//! angle of Lambertian light is uniform), and end where they can meet it no more. The ledger gets photons of its own
//! (docs/decisions/launch.md).

use super::constants::TABLE_EDGE;
use super::disc::Disc;
use super::real::Real;
use crate::scene::{self, IesTable, LoadedScene, Mount, Pattern, Wall, read_ies};
use crate::surface::SurfaceError;
use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

/// Radiances of the brightest LED, W/(m^2 sr), whose images have variances within the range of f32, dim pixels
/// included.
const RADIANCES: RangeInclusive<f64> = 1e-9..=1e12;

/// One LED.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Led<T> {
    /// The wall that it is on, or before.
    pub wall: Wall,
    /// In the surround before a clear wall.
    pub air: bool,
    /// Centre along the wall, mm.
    pub along: T,
    /// Height of the centre, mm.
    pub height: T,
    /// Radius of the disc, mm.
    pub radius: T,
    /// Distance to the wall, mm.
    pub gap: T,
    /// Radiance on the axis, or the largest of a table, in film units.
    pub radiance: T,
    /// Intensity goes as this power of the cosine.
    pub exponent: T,
    /// Cosine of the cut-off angle.
    pub cos_cutoff: T,
    /// Share of the power of this and all earlier LEDs.
    pub cumulative: T,
    /// First entry of its intensity table.
    pub table: Option<usize>,
    /// 1 - cos_cutoff^(exponent + 1).
    pub launch: T,
    /// Aimed photons leave it between these sines of the angle to its normal, seen from above, towards `along`.
    pub aim: [T; 2],
    /// As `cumulative`, of the power that aimed photons stand for.
    pub cumulative_aimed: T,
}

impl Led<f64> {
    pub(super) fn cast<T: Real>(&self) -> Led<T> {
        Led {
            wall: self.wall,
            air: self.air,
            along: T::of(self.along),
            height: T::of(self.height),
            radius: T::of(self.radius),
            gap: T::of(self.gap),
            radiance: T::of(self.radiance),
            exponent: T::of(self.exponent),
            cos_cutoff: T::of(self.cos_cutoff),
            cumulative: T::of(self.cumulative),
            table: self.table,
            launch: T::of(self.launch),
            aim: self.aim.map(T::of),
            cumulative_aimed: T::of(self.cumulative_aimed),
        }
    }
}

pub(super) struct Lit {
    pub leds: Vec<Led<f64>>,
    pub tables: Vec<[f64; 2]>,
    pub unit_radiance: f64,
    pub power: f64,
}

/// LEDs of a scene with their radiances relative to the brightest and their powers in that unit.
pub(super) fn leds(loaded: &LoadedScene) -> Result<Lit, SurfaceError> {
    let mut leds = Vec::new();
    let mut tables = Vec::new();
    let mut powers = Vec::new();
    for (k, led) in loaded.scene.led.iter().enumerate() {
        let (l, power) = one(loaded, led, k, &mut tables)?;
        leds.push(l);
        powers.push(power);
    }
    let unit = leds.iter().map(|l: &Led<f64>| l.radiance).fold(0.0, f64::max);
    if unit.is_finite() && !RADIANCES.contains(&unit) {
        let (least, most) = (RADIANCES.start(), RADIANCES.end());
        let message =
            format!("the brightest has {unit:e} W/(m^2 sr): images hold what LEDs of {least:e} to {most:e} give");
        return Err(SurfaceError::Shape { key: "led", message });
    }
    let total: f64 = powers.iter().sum();
    let mut sum = 0.0;
    for (led, power) in leds.iter_mut().zip(&powers) {
        sum += power;
        led.radiance /= unit;
        led.cumulative = sum / total;
    }
    Ok(Lit { leds, tables, unit_radiance: unit, power: total / unit })
}

impl Led<f64> {
    /// Between which sines all light leaves it that may meet a disc, seen from above. Those of a Lambertian disc on the
    /// wall are uniform; of others everything is let through.
    fn aimed_at(&self, half_size: [f64; 2], center: [f64; 2], radius: f64) -> [f64; 2] {
        let lambertian = self.exponent == 1.0 && self.table.is_none() && self.cos_cutoff == 0.0 && !self.air;
        if !lambertian {
            return [-1.0, 1.0];
        }
        let (across, along) = (self.wall.axis(), 1 - self.wall.axis());
        let outward = if self.wall.is_low() { -1.0 } else { 1.0 };
        let depth = half_size[across] - outward * center[across];
        // The tangents turn one way only as a point moves along the wall: those of its ends bound all.
        let ends = [-1.0, 1.0].map(|end| {
            let aside = center[along] - (self.along + end * self.radius);
            let (middle, half) = (aside.atan2(depth), (radius / depth.hypot(aside)).min(1.0).asin());
            let sine = |angle: f64| angle.clamp(-0.5 * PI, 0.5 * PI).sin();
            [sine(middle - half), sine(middle + half)]
        });
        // A thousandth more, for rounding.
        [(ends[0][0].min(ends[1][0]) - 1e-3).max(-1.0), (ends[0][1].max(ends[1][1]) + 1e-3).min(1.0)]
    }
}

/// Aims LEDs at a disc; returns the share of their power that is left.
pub(super) fn aim(leds: &mut [Led<f64>], half_size: [f64; 2], disc: Disc<f64>) -> f64 {
    let (mut before, mut sum) = (0.0, 0.0);
    for led in leds.iter_mut() {
        led.aim = led.aimed_at(half_size, disc.center, disc.radius_sq.sqrt());
        sum += (led.cumulative - before) * 0.5 * (led.aim[1] - led.aim[0]);
        before = led.cumulative;
        led.cumulative_aimed = sum;
    }
    if sum > 0.0 {
        leds.iter_mut().for_each(|led| led.cumulative_aimed /= sum);
    }
    sum
}

/// One LED and its power in W/m^2 times mm^2, that is uW.
fn one(
    loaded: &LoadedScene,
    led: &scene::Led,
    k: usize,
    tables: &mut Vec<[f64; 2]>,
) -> Result<(Led<f64>, f64), SurfaceError> {
    let radius = 0.5 * led.diameter_mm;
    let area = PI * radius * radius;
    let cos_cutoff = led.cutoff_half_angle_deg.map_or(0.0, |a| a.to_radians().cos());
    let mut table = None;
    // Largest radiance over that on the axis.
    let mut peak = Some(1.0);
    // Power per unit of the largest radiance and of area.
    let (exponent, launch, projected) = match &led.pattern {
        Pattern::Lambertian => cosine_power(1.0, cos_cutoff),
        Pattern::CosinePower { half_power_deg } => {
            cosine_power(-(2f64.ln()) / half_power_deg.to_radians().cos().ln(), cos_cutoff)
        }
        Pattern::Ies { file } => {
            let path = loaded.files.resolve(file);
            let wrong = |key: &str, message: String| SurfaceError::File {
                key: format!("led[{k}].{key}"),
                file: path.clone(),
                message,
            };
            let read = loaded.files.open(file).and_then(|input| read_ies(&input));
            let read = read.map_err(|error| wrong("pattern.file", error.to_string()))?;
            table = Some(tables.len());
            let lamp = tabulate(&read, cos_cutoff)
                .ok_or_else(|| wrong("pattern.file", "emits nothing inside the cut-off cone".into()))?;
            if led.radiance_w_per_m2_sr.is_some() && lamp.peak.is_none() {
                let message = "is dark along its normal, so its radiance there says nothing: give power_mw";
                return Err(wrong("radiance_w_per_m2_sr", message.into()));
            }
            peak = lamp.peak;
            tables.extend(lamp.entries);
            (1.0, 1.0, lamp.projected)
        }
    };
    let per_radiance = projected * area;
    // 1 mW = 1e-3 W, 1 m^2 = 1e6 mm^2: radiance in W/(m^2 sr) times mm^2 is 1e-6 W.
    let radiance = match (led.radiance_w_per_m2_sr, led.power_mw) {
        (Some(l), _) => l * peak.unwrap_or(1.0),
        (None, Some(p)) => p * 1e3 / per_radiance,
        (None, None) => 0.0,
    };
    let (air, gap) = match led.mount {
        Mount::Bonded => (false, 0.0),
        Mount::Air { gap_mm } => (true, gap_mm),
    };
    let led = Led {
        wall: led.wall,
        air,
        along: led.along_mm,
        height: led.height_mm,
        radius,
        gap,
        radiance,
        exponent,
        cos_cutoff,
        cumulative: 0.0,
        table,
        launch,
        aim: [-1.0, 1.0],
        cumulative_aimed: 0.0,
    };
    Ok((led, radiance * per_radiance))
}

/// For intensity cos^m inside the cut-off: m, the launch constant, and the integral of cos^m over the cone (sr).
fn cosine_power(m: f64, cos_cutoff: f64) -> (f64, f64, f64) {
    let launch = 1.0 - cos_cutoff.powf(m + 1.0);
    (m, launch, TAU * launch / (m + 1.0))
}

/// A lamp's table as the tracers hold it.
struct Tabulated {
    /// Radiance relative to the largest, and cumulative power, over cells of equal projected solid angle.
    entries: Vec<[f64; 2]>,
    /// Power per unit of the largest radiance and of area, sr.
    projected: f64,
    /// Largest radiance over that on the axis; `None` where the axis is dark.
    peak: Option<f64>,
}

/// Tabulates a lamp; `None` where it emits nothing inside the cut-off.
///
/// Radiances are relative to the largest, not to that on the axis: the film's sums hold so many of the brightest, and a
/// lamp that is dim or dark on its axis is as good as any.
fn tabulate(ies: &IesTable, cos_cutoff: f64) -> Option<Tabulated> {
    let edge = TABLE_EDGE as f64;
    let cell = |k: usize| {
        let sin_sq = ((k / TABLE_EDGE) as f64 + 0.5) / edge;
        let phi = ((k % TABLE_EDGE) as f64 + 0.5) / edge * 360.0;
        let cos = (1.0 - sin_sq).sqrt();
        if cos <= cos_cutoff { 0.0 } else { ies.intensity(sin_sq.sqrt().asin().to_degrees(), phi) / cos }
    };
    let values: Vec<f64> = (0..TABLE_EDGE * TABLE_EDGE).map(cell).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let shares = || values.iter().map(|v| v / largest);
    let total: f64 = shares().sum();
    if !(largest > 0.0 && total > 0.0) {
        return None;
    }
    let axis = ies.intensity(0.0, 0.0) / largest;
    let mut sum = 0.0;
    let entries = shares().map(|share| {
        sum += share;
        [share, sum / total]
    });
    // The projected solid angle of the hemisphere is pi.
    Some(Tabulated {
        entries: entries.collect(),
        projected: PI * total / (edge * edge),
        peak: (axis > 0.0).then(|| axis.recip()),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::LoadedScene;
    use crate::trace::Model;
    use crate::trace::cpu::{End, Limits, Path};

    const LAUNCHES: u32 = 1 << 16;

    /// Three LEDs of different places and powers about a disc of contact that is not in the middle.
    fn scene() -> LoadedScene {
        let mut loaded = crate::scene::preset("contact-disc").unwrap();
        loaded.scene.led.truncate(3);
        for (k, led) in loaded.scene.led.iter_mut().enumerate() {
            led.along_mm = 4.0 * k as f64 - 5.0;
            led.radiance_w_per_m2_sr = Some(1.0 + k as f64);
        }
        loaded
    }

    fn model(loaded: &LoadedScene, center: [f64; 2]) -> Model<f64> {
        let contact = crate::surface::contact_map(loaded).unwrap().map(|mut map| {
            map.disc.as_mut().unwrap().center_mm = center;
            map
        });
        Model::new(loaded, &crate::surface::Surface::Flat, contact).unwrap()
    }

    /// Share of launches that are not astray.
    fn towards(model: &Model<f64>, aimed: bool) -> f64 {
        let mut path = Path::new(model, Limits::default());
        path.aimed = aimed;
        let hits = (0..LAUNCHES).filter(|&k| {
            path.start_random(3, k, 0);
            path.launch() == End::GoesOn && !path.astray()
        });
        hits.count() as f64 / f64::from(LAUNCHES)
    }

    /// All light that may meet the disc is aimed: the share of all launches is that of the aimed ones times what they
    /// stand for.
    fn miss(model: &Model<f64>) -> f64 {
        towards(model, true) * model.aimed_share / towards(model, false) - 1.0
    }

    #[test]
    fn aimed_photons_stand_for_all_light_that_may_meet_tissue_and_for_no_other() {
        let mut loaded = scene();
        for center in [[0.0; 2], [3.0, -6.0], [-9.0, 2.0]] {
            let model = model(&loaded, center);
            assert!(
                model.aimed_share < 0.6 && towards(&model, true) > 0.6,
                "{} {}",
                model.aimed_share,
                towards(&model, true)
            );
            // 1/6 of 65,536 even launches: random ones would leave 1.2 %.
            assert!(miss(&model).abs() < 5e-3, "{center:?}: {}", miss(&model));
            // Light between narrower sines misses some of the disc.
            let mut narrow = model.clone();
            narrow.leds.iter_mut().for_each(|led| led.aim[1] -= 0.2 * (led.aim[1] - led.aim[0]));
            narrow.aimed_share *= 0.8;
            assert!(miss(&narrow).abs() > 5e-3, "{center:?}: {}", miss(&narrow));
        }
        for led in &mut loaded.scene.led {
            led.pattern = Pattern::CosinePower { half_power_deg: 40.0 };
            led.cutoff_half_angle_deg = Some(50.0);
        }
        let model = model(&loaded, [3.0, -6.0]);
        assert_eq!(model.aimed_share, 1.0);
        assert!(miss(&model).abs() < 5e-3, "{}", miss(&model));
    }

    /// The square of 1e-20 is not in f32: errors were said to be 0.
    #[test]
    fn radiances_whose_variances_no_image_holds_are_refused() {
        let mut loaded = crate::scene::preset("flat-bonded").unwrap();
        for (radiance, fits) in [(1e-20, false), (1e-9, true), (1.0, true), (1e12, true), (1e22, false)] {
            loaded.scene.led.iter_mut().for_each(|led| led.radiance_w_per_m2_sr = Some(radiance));
            let found = leds(&loaded);
            assert_eq!(found.is_ok(), fits, "{radiance}");
            assert!(found.err().is_none_or(|error| error.to_string().contains("W/(m^2 sr)")));
        }
    }

    #[test]
    fn aimed_light_is_lambertian_between_its_sines() {
        // The square of the upward cosine of Lambertian light from a wall has a mean of 1/4, whatever part of the
        // azimuth is seen.
        let model = model(&scene(), [0.0; 2]);
        let mut path = Path::new(&model, Limits::default());
        path.aimed = true;
        let (mut up_sq, mut count) = (0.0, 0.0);
        for k in 0..LAUNCHES {
            path.start_random(5, k, 0);
            path.launch();
            let n = model.layers[path.layer].n;
            up_sq += (path.p.z / n).powi(2);
            count += 1.0;
            assert!((path.p.dot(path.p).sqrt() / n - 1.0).abs() < 1e-12);
        }
        assert!((up_sq / count - 0.25).abs() < 1e-3, "{}", up_sq / count);
    }
}
