//! What is said and shown of a shot, and its files.

use super::facts::figure;
use super::measure::marks;
use super::output::command_of_light;
use super::side::side_picture;
use super::{Failure, OutputFolder, note};
use crate::camera::{Frame, Suited};
use crate::film::RADIANCE_UNIT;
use crate::image_io::{Provenance, write_png_grey, write_radiance_as};
use crate::pipeline::{Reading, Shot};
use crate::report::{ColorScale, Raster, false_color, false_color_with, relief};
use crate::trace::Outcome;
use crate::trace::batch::Times;
use crate::trace::exitance::Smoothing;
use serde_json::{Map, Value, json};
use std::time::Instant;

/// Pictures of the camera's frame, as SVG.
pub(super) struct CameraPictures {
    pub false_color: String,
    pub relief: String,
}

/// The pictures of a shot, as SVG.
pub(super) struct Pictures {
    pub radiance: String,
    pub relief: String,
    pub side: String,
    /// Time to draw and write all files of the shot, seconds.
    pub files_seconds: f64,
}

impl Shot<'_> {
    /// Writes radiance, camera image and pictures.
    pub(super) fn write(&self, folder: &OutputFolder) -> Result<Pictures, Failure> {
        let start = Instant::now();
        let film = &self.outcome.film;
        let variances = self.outcome.unseen.variances(film);
        write_radiance_as(&folder.path("radiance.exr"), film, &variances, &self.provenance())?;
        self.write_frame(folder, "camera.png")?;
        let mut pictures = self.pictures()?;
        folder.write("radiance.svg", &pictures.radiance)?;
        folder.write("relief.svg", &pictures.relief)?;
        folder.write("side.svg", &pictures.side)?;
        pictures.files_seconds = start.elapsed().as_secs_f64();
        Ok(pictures)
    }

    /// Writes the camera's frame.
    pub(super) fn write_frame(&self, folder: &OutputFolder, name: &str) -> Result<(), Failure> {
        write_frame(&self.frame, folder, name)
    }

    fn pictures(&self) -> Result<Pictures, Failure> {
        let values: Vec<f64> = self.outcome.film.mean.iter().map(|&v| f64::from(v)).collect();
        let raster = self.raster(&values, "radiance", RADIANCE_UNIT);
        let title = format!("{}: radiance", self.prepared.scene().name);
        let scale = scale_of(&values);
        Ok(Pictures {
            radiance: false_color(&title, &raster, scale)?,
            relief: relief(&title, &raster, scale)?,
            side: side_picture(self.prepared, self.prepared.streams.seed)?,
            files_seconds: 0.0,
        })
    }

    /// The frame that was measured, in false colour with what was measured, and as a relief. `less` is what was
    /// subtracted.
    pub(super) fn camera_pictures(&self, figures: &Reading, less: Option<&str>) -> Result<CameraPictures, Failure> {
        let raster = self.raster(figures.image.grey(), "grey level", "");
        let less = less.map_or_else(String::new, |name| format!(" less {name}"));
        let title = format!("{}: camera{less}", self.prepared.scene().name);
        Ok(CameraPictures {
            false_color: false_color_with(&title, &raster, ColorScale::Linear, &marks(figures))?,
            relief: relief(&title, &raster, ColorScale::Linear)?,
        })
    }

    fn raster<'v>(&self, values: &'v [f64], quantity: &'v str, unit: &'v str) -> Raster<'v> {
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        Raster { width, height, values, quantity, unit, mm_per_pixel: Some(self.mm_per_pixel) }
    }

    /// What the header of radiance.exr says.
    fn provenance(&self) -> Provenance {
        let outcome = &self.outcome;
        Provenance {
            unit: RADIANCE_UNIT.into(),
            scene_name: self.prepared.scene().name.clone(),
            scene_sha256: self.prepared.loaded.sha256.clone(),
            seed: self.prepared.streams.seed,
            stream: Some(self.prepared.settings.seed),
            sensor_seed: Some(self.prepared.streams.sensor()),
            spp: u32::try_from(outcome.spp).unwrap_or(u32::MAX),
            photons: outcome.photons,
            integrator: outcome.plan.method.name().into(),
            backend: outcome.backend.into(),
            adapter: outcome.adapter.clone(),
            version: env!("CARGO_PKG_VERSION").into(),
            command: command_of_light(),
            ..Provenance::default()
        }
    }

    /// What `--json` says of a render whose files took so long.
    pub(super) fn json(&self, files_seconds: f64) -> Map<String, Value> {
        let outcome = &self.outcome;
        let relative = match outcome.relative_error {
            Some(error) => json!(error),
            None => json!({"undefined": "the image is dark; absolute_error and mean_radiance_below say how dark"}),
        };
        let unseen = &outcome.unseen;
        let below = match unseen.mean_below {
            Some(bound) => json!(bound),
            None => json!({"undefined": "the image is not dark"}),
        };
        let block = |(edge, error): (u32, Option<f64>)| {
            let relative = error.map_or_else(|| json!({"undefined": "the image is dark"}), |error| json!(error));
            json!({"edge_pixels": edge, "relative_error": relative})
        };
        let object = json!({
            "scene": self.prepared.scene().name,
            "backend": outcome.backend,
            "adapter": outcome.adapter,
            "notice": outcome.notice,
            "integrator": outcome.plan.method.name(),
            "why": outcome.plan.why,
            "seed": self.prepared.streams.seed,
            "stream": self.prepared.settings.seed,
            "random_numbers": self.prepared.streams.sharing.name(),
            "spp": outcome.spp,
            "replicates": outcome.film.replicates,
            "paths": outcome.paths,
            "photons": outcome.photons,
            "ledger_photons": outcome.ledger_photons,
            "map": outcome.smoothing.map_or_else(|| json!({"undefined": "no map"}), |smoothing| self.map_json(smoothing)),
            "segments": outcome.segments,
            "setup_seconds": outcome.setup_seconds,
            "seconds": outcome.seconds,
            "stages_seconds": self.stages(files_seconds),
            "segments_per_second": segments_per_second(outcome),
            "mean_radiance": outcome.mean_radiance,
            "relative_error": relative,
            "block_errors": outcome.block_errors().into_iter().map(block).collect::<Vec<_>>(),
            "absolute_error": unseen.absolute_error(&outcome.film),
            "mean_radiance_below": below,
            "known_dark": unseen.known_dark,
            "ledger": outcome.ledger,
            "camera": self.camera_json(),
        });
        match object {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }

    /// Where the time went, seconds.
    fn stages(&self, files_seconds: f64) -> Value {
        let outcome = &self.outcome;
        let press = self.prepared.pressed().map_or(0.0, |(pressed, _)| pressed.seconds + pressed.error_seconds);
        let Times { photons, map, camera, ledger } = outcome.times;
        json!({
            "mechanics": press,
            "surface": self.prepared.surface_seconds,
            "setup": outcome.setup_seconds,
            "photons": photons,
            "map": map,
            "camera": camera,
            "ledger": ledger,
            "sums": outcome.seconds - photons - map - camera,
            "files": files_seconds,
        })
    }

    fn map_json(&self, smoothing: Smoothing) -> Value {
        let texel_mm = self.prepared.scene().render.map_texel_mm;
        json!({
            "texel_mm": texel_mm,
            "smoothing_mm": smoothing.widths.map(|width| width as f64 * texel_mm),
            "relative_bias": smoothing.bias,
        })
    }

    pub(super) fn camera_json(&self) -> Value {
        camera_json(&self.frame, self.mm_per_pixel, &self.suited)
    }

    /// Notes an exposure that does not suit the image, unless `quiet`.
    pub(super) fn note_exposure(&self, quiet: bool) {
        note_exposure(&self.suited, self.prepared.scene().camera.sensor.exposure_ms, quiet);
    }

    /// Highest grey level of the camera's frame.
    pub(super) fn max_grey(&self) -> u16 {
        self.frame.max_grey()
    }

    /// Pixels of the camera's frame at its top grey level.
    pub(super) fn saturated_pixels(&self) -> usize {
        self.frame.saturated_pixels()
    }
}

/// Writes a camera's frame.
pub(super) fn write_frame(frame: &Frame, folder: &OutputFolder, name: &str) -> Result<(), Failure> {
    let Frame { width, height, bit_depth, grey } = frame;
    // A PNG has 8 or 16 bits; levels of a depth between are written as they are.
    let png_depth = if *bit_depth > 8 { 16 } else { 8 };
    Ok(write_png_grey(&folder.path(name), *width, *height, grey, png_depth)?)
}

/// What `--json` says of a camera's frame.
pub(super) fn camera_json(frame: &Frame, mm_per_pixel: f64, suited: &Suited) -> Value {
    json!({
        "pixels": [frame.width, frame.height],
        "mm_per_pixel": mm_per_pixel,
        "max_grey": frame.max_grey(),
        "top_grey": frame.top_grey(),
        "saturated_pixels": frame.saturated_pixels(),
        "sum_grey": frame.grey.iter().map(|&grey| u64::from(grey)).sum::<u64>(),
        "suggested_exposure_ms": match suited {
            Suited::Filled { suggested_ms, .. } => json!(suggested_ms),
            Suited::Undefined(reason) => json!({"undefined": reason}),
        },
    })
}

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

/// Logarithmic where a few pixels (glints) are far brighter than the hundredth brightest and dimmer ones lie more than
/// a decade below: on a linear scale the glints alone would show.
fn scale_of(values: &[f64]) -> ColorScale {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let percentile = sorted.get(sorted.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
    let dimmest = sorted.iter().copied().find(|&value| value > 0.0).unwrap_or(0.0);
    match sorted.last() {
        Some(&most) if most > 10.0 * percentile.max(dimmest) => ColorScale::Log,
        _ => ColorScale::Linear,
    }
}

/// Segments of camera paths and photons for each second of tracing.
pub(super) fn segments_per_second(outcome: &Outcome) -> f64 {
    outcome.segments as f64 / outcome.seconds.max(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glints_beside_something_dimmer_ask_for_a_logarithmic_scale() {
        let image = |dim: f64, glint: f64| {
            let mut values = vec![0.0; 1000];
            values[..100].fill(dim);
            values[999] = glint;
            scale_of(&values)
        };
        assert_eq!(image(1.0, 20.0), ColorScale::Log);
        assert_eq!(image(1.0, 5.0), ColorScale::Linear);
        // Glints alone, or darkness.
        assert_eq!(image(0.0, 5.0), ColorScale::Linear);
        assert_eq!(image(0.0, 0.0), ColorScale::Linear);
    }
}
