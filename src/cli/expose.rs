//! `expose`: another frame of light that is traced already.

use super::command;
use super::exposure::note_exposure;
use super::flags::positive;
use super::job::load_scene;
use super::{Failure, Outcome, Talk, note, print};
use crate::camera::{Frame, Suited, expose};
use crate::film::Film;
use crate::image_io::{Provenance, read_radiance};
use crate::output::OutputFolder;
use crate::pages::facts::{columns, figure};
use crate::pipeline::{CameraSummary, view_of};
use crate::report::{ColorScale, Raster, false_color};
use crate::scene::{LoadedScene, load_alone, validate};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Make a camera frame of a rendered folder's radiance.exr, with another exposure or bit depth, without tracing again.
#[derive(Debug, Args)]
pub(super) struct Expose {
    /// Folder that `render` or `run` wrote, or a radiance.exr.
    folder: PathBuf,
    /// The scene whose camera it is (file or preset:NAME) [default: FOLDER/scene.toml].
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Exposure time, ms [default: the scene's].
    #[arg(long, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    exposure_ms: Option<f64>,
    /// Bits of a grey value, 8 to 16 [default: the scene's].
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    bit_depth: Option<u32>,
    /// Seed of the camera's noise [default: that of the frame made when it was rendered].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    seed: Option<u32>,
    /// Folder to write, in whole or not at all [default: out/NAME-exposed].
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder if it exists.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    talk: Talk,
}

/// A frame and what it was made of.
struct Exposure {
    loaded: LoadedScene,
    frame: Frame,
    suited: Suited,
    mm_per_pixel: f64,
    seed: u32,
}

impl Expose {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let loaded = self.scene()?;
        let name = format!("{}-exposed", loaded.scene.name);
        let place = self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
        let folder = OutputFolder::create(&place, self.force)?;
        let image = match self.folder.is_dir() {
            true => self.folder.join("radiance.exr"),
            false => self.folder.clone(),
        };
        let (film, provenance) = read_radiance(&image)?;
        let exposure = self.expose(loaded, &film, provenance.as_ref(), &image)?;
        note_exposure(&exposure.suited, exposure.loaded.scene.camera.sensor.exposure_ms, self.talk.quiet);
        exposure.frame.write_png(&folder.path("camera.png"))?;
        folder.write("camera_false_color.svg", &exposure.picture()?)?;
        let done = command::commit(folder, Some(&exposure.loaded.text), exposure.json())?;
        match self.talk.json {
            true => print(&done.json)?,
            false => print(&exposure.text(&done.out))?,
        }
        Ok(Outcome::Done)
    }

    /// The scene with the flags in place of what it says of exposure and bits.
    fn scene(&self) -> Result<LoadedScene, Failure> {
        let beside = self.folder.join("scene.toml");
        let mut loaded = match &self.scene {
            Some(scene) => load_scene(scene)?.0,
            None if beside.is_file() => load_alone(&beside)?,
            None => {
                let message =
                    format!("{}: holds no scene.toml; `--scene SCENE` names the one it is of", self.folder.display());
                return Err(Failure::usage(message).in_file(&self.folder));
            }
        };
        let sensor = &mut loaded.scene.camera.sensor;
        sensor.exposure_ms = self.exposure_ms.unwrap_or(sensor.exposure_ms);
        sensor.bit_depth = self.bit_depth.unwrap_or(sensor.bit_depth);
        validate(&loaded.scene).map_err(|broken| Failure::usage(broken.to_string()).at_key(broken.key))?;
        Ok(loaded)
    }

    fn expose(
        &self,
        loaded: LoadedScene,
        film: &Film,
        provenance: Option<&Provenance>,
        image: &Path,
    ) -> Result<Exposure, Failure> {
        let other = provenance.is_some_and(|origin| origin.scene_sha256 != loaded.sha256);
        if other && !self.talk.quiet {
            note(&format!("{}: was rendered of another scene file; the camera is that of this one", image.display()));
        }
        let scene = &loaded.scene;
        let seed = self.seed.or(provenance.and_then(|origin| origin.sensor_seed)).unwrap_or(scene.render.seed);
        let placed = |error| Failure::input(format!("{}: {error}", image.display())).in_file(image);
        let frame = expose(film, &scene.camera, scene.light.wavelength_nm, seed).map_err(placed)?;
        let suited = Suited::of(film, &scene.camera, scene.light.wavelength_nm).map_err(placed)?;
        let mm_per_pixel = view_of(scene)?.mm_per_pixel();
        Ok(Exposure { frame, suited, mm_per_pixel, seed, loaded })
    }
}

impl Exposure {
    fn picture(&self) -> Result<String, Failure> {
        let values: Vec<f64> = self.frame.grey.iter().map(|&grey| f64::from(grey)).collect();
        let (width, height) = (self.frame.width as usize, self.frame.height as usize);
        let mm_per_pixel = Some(self.mm_per_pixel);
        let raster = Raster { width, height, values: &values, quantity: "grey level", unit: "", mm_per_pixel };
        Ok(false_color(&format!("{}: camera", self.loaded.scene.name), &raster, ColorScale::Linear)?)
    }

    fn json(&self) -> Value {
        let sensor = &self.loaded.scene.camera.sensor;
        json!({
            "scene": self.loaded.scene.name,
            "seed": self.seed,
            "exposure_ms": sensor.exposure_ms,
            "bit_depth": sensor.bit_depth,
            "camera": CameraSummary::of(&self.frame, self.mm_per_pixel, &self.suited),
        })
    }

    fn text(&self, out: &str) -> String {
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
