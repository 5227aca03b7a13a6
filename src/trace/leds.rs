//! LEDs as the tracers see them.

use super::model::Real;
use crate::scene::{self, IesTable, LoadedScene, Mount, Pattern, Wall, read_ies};
use crate::surface::SurfaceError;
use std::f64::consts::{PI, TAU};

/// Cells of an intensity table along sin^2(theta) and along the azimuth.
pub const TABLE_EDGE: usize = 64;

/// One LED.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Led<T> {
    /// 0 +x, 1 -x, 2 +y, 3 -y.
    pub wall: u32,
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
    /// Radiance on the axis (or the mean of a table), in film units.
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
    let total: f64 = powers.iter().sum();
    let mut sum = 0.0;
    for (led, power) in leds.iter_mut().zip(&powers) {
        sum += power;
        led.radiance /= unit;
        led.cumulative = sum / total;
    }
    Ok(Lit { leds, tables, unit_radiance: unit, power: total / unit })
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
    // Power per unit of radiance on the axis and of area.
    let (exponent, launch, projected) = match &led.pattern {
        Pattern::Lambertian => cosine_power(1.0, cos_cutoff),
        Pattern::CosinePower { half_power_deg } => {
            cosine_power(-(2f64.ln()) / half_power_deg.to_radians().cos().ln(), cos_cutoff)
        }
        Pattern::Ies { file } => {
            let path = loaded.resolve(file);
            let wrong = |message: String| SurfaceError::File {
                key: format!("led[{k}].pattern.file"),
                file: path.clone(),
                message,
            };
            let read = read_ies(&path).map_err(|e| wrong(e.to_string()))?;
            table = Some(tables.len());
            let (entries, projected) = tabulate(&read, cos_cutoff);
            if projected <= 0.0 {
                return Err(wrong("emits nothing inside the cut-off cone".into()));
            }
            tables.extend(entries);
            (1.0, 1.0, projected)
        }
    };
    let per_radiance = projected * area;
    // 1 mW = 1e-3 W, 1 m^2 = 1e6 mm^2: radiance in W/(m^2 sr) times mm^2 is 1e-6 W.
    let radiance = match (led.radiance_w_per_m2_sr, led.power_mw) {
        (Some(l), _) => l,
        (None, Some(p)) => p * 1e3 / per_radiance,
        (None, None) => 0.0,
    };
    let (air, gap) = match led.mount {
        Mount::Bonded => (false, 0.0),
        Mount::Air { gap_mm } => (true, gap_mm),
    };
    let led = Led {
        wall: match led.wall {
            Wall::PlusX => 0,
            Wall::MinusX => 1,
            Wall::PlusY => 2,
            Wall::MinusY => 3,
        },
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
    };
    Ok((led, radiance * per_radiance))
}

/// For intensity cos^m inside the cut-off: m, the launch constant, and the integral of cos^m over the cone (sr).
fn cosine_power(m: f64, cos_cutoff: f64) -> (f64, f64, f64) {
    let launch = 1.0 - cos_cutoff.powf(m + 1.0);
    (m, launch, TAU * launch / (m + 1.0))
}

/// Radiance relative to that on the axis, and cumulative power, over cells of equal projected solid angle.
fn tabulate(ies: &IesTable, cos_cutoff: f64) -> (Vec<[f64; 2]>, f64) {
    let edge = TABLE_EDGE as f64;
    let cell = |k: usize| {
        let sin_sq = ((k / TABLE_EDGE) as f64 + 0.5) / edge;
        let phi = ((k % TABLE_EDGE) as f64 + 0.5) / edge * 360.0;
        let cos = (1.0 - sin_sq).sqrt();
        if cos <= cos_cutoff { 0.0 } else { ies.intensity(sin_sq.sqrt().asin().to_degrees(), phi) / cos }
    };
    let values: Vec<f64> = (0..TABLE_EDGE * TABLE_EDGE).map(cell).collect();
    let axis = ies.intensity(0.0, 0.0).max(f64::MIN_POSITIVE);
    let total: f64 = values.iter().sum();
    let mut sum = 0.0;
    let entries = values
        .iter()
        .map(|v| {
            sum += v;
            [v / axis, if total > 0.0 { sum / total } else { 1.0 }]
        })
        .collect();
    // The projected solid angle of the hemisphere is pi.
    (entries, PI * total / axis / (edge * edge))
}
