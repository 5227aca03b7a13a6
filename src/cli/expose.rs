//! `expose`: another frame of light that is traced already.

use super::command;
use super::flags::{Place, positive};
use super::job::note_exposure;
use super::{Failure, Outcome, Talk};
use crate::image_io::read_radiance;
use crate::pages::exposure::{Exposure, changed};
use crate::scene::{LoadedScene, load_alone, open};
use clap::Args;
use std::path::PathBuf;

/// Make a camera frame of a rendered folder's radiance.exr, with another exposure or bit depth, without tracing again.
#[derive(Debug, Args)]
pub(super) struct Expose {
    /// Folder that `render` or `run` wrote, or a radiance.exr.
    folder: PathBuf,
    /// The scene whose camera it is (file or preset:NAME) [default: FOLDER/scene.toml].
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Exposure time, ms [default: the scene's].
    #[arg(long, value_name = "T", value_parser = positive)]
    exposure_ms: Option<f64>,
    /// Bits of a grey value, 8 to 16 [default: the scene's].
    #[arg(long, value_name = "B")]
    bit_depth: Option<u32>,
    /// Seed of the camera's noise [default: that of the frame made when it was rendered].
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    talk: Talk,
}

impl Expose {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let loaded = self.scene()?;
        let sha256 = loaded.sha256.clone();
        let loaded = changed(loaded, self.exposure_ms, self.bit_depth)
            .map_err(|broken| Failure::usage(broken.to_string()).at_key(broken.key))?;
        let folder = self.place.take(&format!("{}-exposed", loaded.scene.name))?;
        let image = match self.folder.is_dir() {
            true => self.folder.join("radiance.exr"),
            false => self.folder.clone(),
        };
        let (film, provenance) = read_radiance(&image)?;
        let other = provenance.as_ref().is_some_and(|origin| origin.scene_sha256 != sha256);
        if other {
            let what = "was rendered of another scene file; the camera is that of this one";
            self.talk.note(&format!("{}: {what}", image.display()));
        }
        let exposure = Exposure::of(loaded, &film, provenance.as_ref(), self.seed)
            .map_err(|error| Failure::input(format!("{}: {error}", image.display())).in_file(&image))?;
        note_exposure(&exposure.suited, exposure.loaded.scene.camera.sensor.exposure_ms, self.talk.quiet);
        folder.write_image("camera.png", |path| exposure.frame.write_png(path))?;
        folder.write("camera_false_color.svg", &exposure.picture()?)?;
        let done = command::commit(folder, Some(&exposure.loaded.text), exposure.json())?;
        self.talk.tell(&done.json, exposure.text(&done.out))
    }

    /// The scene whose camera exposes.
    fn scene(&self) -> Result<LoadedScene, Failure> {
        let beside = self.folder.join("scene.toml");
        match &self.scene {
            Some(scene) => Ok(open(scene)?.0),
            None if beside.is_file() => Ok(load_alone(&beside)?),
            None => {
                let message =
                    format!("{}: holds no scene.toml; `--scene SCENE` names the one it is of", self.folder.display());
                Err(Failure::usage(message).in_file(&self.folder))
            }
        }
    }
}
