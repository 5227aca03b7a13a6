//! Flags that commands share.

use super::{Failure, Outcome, note, print};
use crate::output::OutputFolder;
use crate::scene::{IntegratorChoice, LoadedScene, open};
use crate::trace::{BackendChoice, Devices, Precision, Settings};
use crate::vary::{self, Set};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use std::fmt::Display;
use std::path::PathBuf;
use std::str::FromStr;

/// What a command says while it runs and when it is done.
#[derive(Debug, Clone, Default, Args)]
pub struct Talk {
    /// Say nothing but results and errors.
    #[arg(long)]
    pub quiet: bool,
    /// One JSON object on standard output, nothing else there.
    #[arg(long)]
    pub json: bool,
}

impl Talk {
    /// Says what a command has done, as JSON or in words.
    pub(super) fn tell(&self, json: impl Display, words: impl Display) -> Result<Outcome, Failure> {
        print(&if self.json { json.to_string() } else { words.to_string() })?;
        Ok(Outcome::Done)
    }

    /// Notes something on the way, unless `quiet`.
    pub(super) fn note(&self, line: &str) {
        if !self.quiet {
            note(line);
        }
    }
}

/// The folder that a command writes.
#[derive(Debug, Clone, Default, Args)]
pub struct Place {
    /// Folder to write [default: in out/, by the name of what it is of].
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    pub force: bool,
}

impl Place {
    /// The folder: `out/NAME` unless one is given.
    #[must_use]
    pub fn named(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name))
    }

    /// Takes it.
    ///
    /// # Errors
    /// When something is there that is not to be replaced, or it cannot be written.
    pub fn take(&self, name: &str) -> Result<OutputFolder, Failure> {
        Ok(OutputFolder::create(&self.named(name), self.force)?)
    }
}

/// What traces.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct Backend {
    /// The GPU where there is one, else the CPU (auto), the GPU or fail (gpu), the CPU twin (cpu).
    #[arg(long, value_parser = one_of::<BackendChoice, 3>(["auto", "gpu", "cpu"]), default_value = "auto")]
    pub backend: BackendChoice,
}

impl Backend {
    /// Opens it, and says what was taken in its place unless `quiet`.
    pub(super) fn open(self, quiet: bool) -> Result<Devices, Failure> {
        let devices = Devices::open(self.backend, Precision::F32)?;
        if let (Some(notice), false) = (devices.notice(), quiet) {
            note(notice);
        }
        Ok(devices)
    }
}

/// A scene, with keys set by hand.
#[derive(Debug, Clone, Args)]
pub struct SceneFile {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    pub scene: PathBuf,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Set>,
}

impl SceneFile {
    /// Reads it; with the name it goes by in messages.
    ///
    /// # Errors
    /// A scene that is none.
    pub fn open(&self) -> Result<(LoadedScene, PathBuf), Failure> {
        let (loaded, file) = open(&self.scene)?;
        Ok((vary::with(loaded, &file, &self.set)?, file))
    }
}

/// Flags of the commands that compute and write a folder.
#[derive(Debug, Clone, Default, Args)]
pub struct Common {
    #[command(flatten)]
    #[allow(missing_docs)] // a doc comment here would replace the command's help
    pub place: Place,
    /// Seed of all random numbers [default: the scene's].
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Draw the same random numbers for every image of this seed: loads, baseline, other scenes.
    #[arg(long)]
    pub common_random_numbers: bool,
    #[command(flatten)]
    #[allow(missing_docs)] // as above
    pub backend: Backend,
    /// Arithmetic; f64 on the cpu only.
    #[arg(long, value_parser = one_of::<Precision, 2>(["f32", "f64"]), default_value = "f32")]
    pub precision: Precision,
    /// Light-transport method [default: the scene's].
    #[arg(long, value_name = "auto|path|splat|map")]
    pub integrator: Option<IntegratorChoice>,
    /// Camera paths per pixel [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Photons sent from the LEDs [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub photons: Option<u64>,
    /// Compute for so many seconds, counted from after compilation.
    #[arg(long, value_name = "S", value_parser = positive, conflicts_with_all = ["spp", "photons", "target_error"])]
    pub seconds: Option<f64>,
    /// Compute until the relative error is at most this.
    #[arg(long, value_name = "E", value_parser = positive, conflicts_with_all = ["spp", "photons"])]
    pub target_error: Option<f64>,
    /// Press the phantom without its inclusions, on the same mesh: makes a reference frame.
    #[arg(long)]
    pub without_inclusions: bool,
    #[command(flatten)]
    #[allow(missing_docs)] // as above
    pub talk: Talk,
}

impl Common {
    /// Opens what these flags ask for together.
    ///
    /// # Errors
    /// When they ask for f64 on the GPU, or for a GPU that is not there.
    pub fn devices(&self) -> Result<Devices, Failure> {
        let choice = self.backend.backend;
        match (choice, self.precision) {
            (BackendChoice::Gpu, Precision::F64) => {
                Err(Failure::usage("the gpu computes in f32 only; f64 needs `--backend cpu`"))
            }
            (_, precision) => Ok(Devices::open(choice, precision)?),
        }
    }

    /// How to render a scene: its own settings where no flag says otherwise.
    #[must_use]
    pub fn settings(&self, scene: &crate::scene::Render) -> Settings {
        Settings {
            integrator: self.integrator.unwrap_or(scene.integrator),
            spp: self.spp.unwrap_or(scene.spp),
            photons: self.photons.or(scene.photons),
            seconds: self.seconds,
            target_error: self.target_error,
            seed: self.seed.unwrap_or(scene.seed),
        }
    }
}

/// A choice by its name, which shells complete.
pub(super) fn one_of<T, const N: usize>(names: [&'static str; N]) -> impl TypedValueParser<Value = T>
where
    T: FromStr<Err = &'static str> + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(names).try_map(|name| name.parse::<T>())
}

/// A number that holds to something, in words too.
fn number(text: &str, what: &str, holds: impl Fn(f64) -> bool) -> Result<f64, String> {
    text.parse().ok().filter(|&number| holds(number)).ok_or_else(|| format!("it must be a {what}"))
}

/// A finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    number(text, "finite number", f64::is_finite)
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, "finite number above 0", |x| x.is_finite() && x > 0.0)
}

/// A finite number of 0 or more.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    number(text, "finite number of 0 or more", |x| x.is_finite() && x >= 0.0)
}

/// A probability strictly between 0 and 1.
pub(super) fn probability(text: &str) -> Result<f64, String> {
    number(text, "number between 0 and 1", |x| x > 0.0 && x < 1.0)
}
