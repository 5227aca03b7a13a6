//! Another frame of light that is traced already.

use super::facts::{columns, figure};
use crate::camera::exposure::ExposureError;
use crate::camera::{Frame, Suited, expose};
use crate::film::Film;
use crate::image_io::Provenance;
use crate::pipeline::{CameraSummary, view_of};
use crate::report::{ColorScale, PictureError, Raster, false_color};
use crate::scene::{Invalid, LoadedScene, sha256, validate};
use crate::vary::KeyPath;
use serde_json::{Value, json};

/// A frame and what it was made of.
pub struct Exposure {
    /// The scene whose camera it is of.
    pub loaded: LoadedScene,
    /// Grey levels.
    pub frame: Frame,
    /// Whether the exposure time suits the light.
    pub suited: Suited,
    /// Scale at the touched face, mm.
    pub mm_per_pixel: f64,
    /// Seed of the sensor's noise.
    pub seed: u32,
}

/// A scene with another exposure time, ms, or other bits of a grey value, where they are given; in its text too.
///
/// # Errors
/// Numbers that no camera has.
pub fn changed(
    mut loaded: LoadedScene,
    exposure_ms: Option<f64>,
    bit_depth: Option<u32>,
) -> Result<LoadedScene, Invalid> {
    let sensor = &mut loaded.scene.camera.sensor;
    sensor.exposure_ms = exposure_ms.unwrap_or(sensor.exposure_ms);
    sensor.bit_depth = bit_depth.unwrap_or(sensor.bit_depth);
    validate(&loaded.scene)?;
    let keys = [
        ("camera.sensor.exposure_ms", exposure_ms.map(toml::Value::from)),
        ("camera.sensor.bit_depth", bit_depth.map(toml::Value::from)),
    ];
    for (key, value) in keys {
        if let Some(value) = value {
            let path = key.parse::<KeyPath>();
            let text = path.and_then(|path| path.set_in(&loaded.text, &value));
            loaded.text = text.map_err(|why| Invalid::new(key, why))?;
        }
    }
    loaded.sha256 = sha256(loaded.text.as_bytes());
    Ok(loaded)
}

impl Exposure {
    /// Exposes a film with a scene's camera; `seed` is that of the sensor's noise. Without one it is that of the frame
    /// made when the film was traced, or the scene's where that is not known.
    ///
    /// # Errors
    /// When the film is not one that the camera sees.
    pub fn of(
        loaded: LoadedScene,
        film: &Film,
        origin: Option<&Provenance>,
        seed: Option<u32>,
    ) -> Result<Self, ExposureError> {
        let seed = seed.or(origin.and_then(|origin| origin.sensor_seed)).unwrap_or(loaded.scene.render.seed);
        let (camera, wavelength_nm) = (&loaded.scene.camera, loaded.scene.light.wavelength_nm);
        let frame = expose(film, camera, wavelength_nm, seed)?;
        let suited = Suited::of(film, camera, wavelength_nm)?;
        let mm_per_pixel = view_of(&loaded.scene)?.mm_per_pixel();
        Ok(Self { frame, suited, mm_per_pixel, seed, loaded })
    }

    /// The camera image in false colour.
    ///
    /// # Errors
    /// A frame that cannot be drawn.
    pub fn picture(&self) -> Result<String, PictureError> {
        let values: Vec<f64> = self.frame.grey.iter().map(|&grey| f64::from(grey)).collect();
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        let mm_per_pixel = Some(self.mm_per_pixel);
        let raster = Raster { width, height, values: &values, quantity: "grey level", unit: "", mm_per_pixel };
        false_color(&format!("{}: camera", self.loaded.scene.name), &raster, ColorScale::Linear)
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let sensor = &self.loaded.scene.camera.sensor;
        json!({
            "scene": self.loaded.scene.name,
            "seed": self.seed,
            "exposure_ms": sensor.exposure_ms,
            "bit_depth": sensor.bit_depth,
            "camera": CameraSummary::of(&self.frame, self.mm_per_pixel, &self.suited),
        })
    }

    /// For people.
    pub fn text(&self, out: &str) -> String {
        let sensor = &self.loaded.scene.camera.sensor;
        let row = |name: &str, value: String| (name.to_owned(), value);
        let suits = match &self.suited {
            Suited::Filled { suggested_ms, .. } => format!("{} ms", figure(*suggested_ms)),
            Suited::Undefined(reason) => format!("undefined: {reason}"),
        };
        let rows = [
            row(
                "exposure",
                format!("{} ms, {} bits, seed {}", figure(sensor.exposure_ms), sensor.bit_depth, self.seed),
            ),
            row("would suit", suits),
            row("brightest", format!("grey level {} of {}", self.frame.max_grey(), self.frame.top_grey())),
            row("saturated", format!("{} pixels", self.frame.saturated_pixels())),
            row("folder", format!("{out}: camera.png camera_false_color.svg")),
        ];
        format!("{}\n{}", self.loaded.scene.name, columns(&rows))
    }
}

/// What is said of an exposure time that does not suit its image.
pub fn unsuited(suited: &Suited, exposure_ms: f64) -> Option<String> {
    let wrong = match suited {
        _ if suited.is_dim() => "too dark",
        _ if suited.is_saturated() => "saturated",
        _ => return None,
    };
    let (now, suits) = (figure(exposure_ms), figure(suited.suggested_ms()?));
    Some(format!("the image is {wrong} at an exposure of {now} ms; {suits} ms would suit it (`expose` takes it anew)"))
}
