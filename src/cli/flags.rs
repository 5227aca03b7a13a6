//! Flags that commands share.

use super::{Failure, Outcome, print};
use crate::scene::IntegratorChoice;
use crate::trace::{self, BackendChoice, Devices, Settings};
use crate::vary::Set;
use clap::{Args, ValueEnum};
use std::fmt::Display;
use std::path::PathBuf;

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
}

/// Flags of the commands that compute and write a folder.
#[derive(Debug, Clone, Default, Args)]
pub struct Common {
    /// Folder to write, in whole or not at all [default: out/NAME].
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the folder, if this program wrote all that it holds.
    #[arg(long)]
    pub force: bool,
    /// Seed of all random numbers [default: the scene's].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u32>,
    /// Draw the same random numbers for every image of this seed: loads, baseline, other scenes.
    #[arg(long)]
    pub common_random_numbers: bool,
    /// Where to compute.
    #[arg(long, value_enum, default_value_t)]
    pub backend: Backend,
    /// Arithmetic; f64 on the cpu only.
    #[arg(long, value_enum, default_value_t)]
    pub precision: Precision,
    /// Light-transport method [default: the scene's].
    #[arg(long, value_name = "auto|path|splat|map")]
    pub integrator: Option<IntegratorChoice>,
    /// Camera paths per pixel [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), allow_negative_numbers = true)]
    pub spp: Option<u32>,
    /// Photons sent from the LEDs [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..), allow_negative_numbers = true)]
    pub photons: Option<u64>,
    /// Compute for so many seconds, counted from after compilation.
    #[arg(long, value_name = "S", value_parser = positive, allow_negative_numbers = true, conflicts_with_all = ["spp", "photons", "target_error"])]
    pub seconds: Option<f64>,
    /// Compute until the relative error is at most this.
    #[arg(long, value_name = "E", value_parser = positive, allow_negative_numbers = true, conflicts_with_all = ["spp", "photons"])]
    pub target_error: Option<f64>,
    /// Press the phantom without its inclusions, on the same mesh: makes a reference frame.
    #[arg(long)]
    pub without_inclusions: bool,
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<Set>,
    #[command(flatten)]
    #[allow(missing_docs)] // a doc comment here would replace the command's help
    pub talk: Talk,
}

/// Where to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Backend {
    /// The GPU where there is one, else the CPU.
    #[default]
    Auto,
    /// The GPU, or fail.
    Gpu,
    /// The CPU twin.
    Cpu,
}

/// Floating-point arithmetic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Precision {
    /// 32 bits.
    #[default]
    F32,
    /// 64 bits, on the CPU.
    F64,
}

impl Backend {
    /// The tracer's word for it.
    #[must_use]
    pub fn choice(self) -> BackendChoice {
        match self {
            Self::Auto => BackendChoice::Auto,
            Self::Gpu => BackendChoice::Gpu,
            Self::Cpu => BackendChoice::Cpu,
        }
    }
}

impl Common {
    /// Opens what these flags ask for together.
    ///
    /// # Errors
    /// When they ask for f64 on the GPU, or for a GPU that is not there.
    pub fn devices(&self) -> Result<Devices, Failure> {
        let precision = match (self.backend, self.precision) {
            (Backend::Gpu, Precision::F64) => {
                return Err(Failure::usage("the gpu computes in f32 only; f64 needs `--backend cpu`"));
            }
            (_, Precision::F32) => trace::Precision::F32,
            (_, Precision::F64) => trace::Precision::F64,
        };
        Ok(Devices::open(self.backend.choice(), precision)?)
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

    /// The folder to write, `out/NAME` unless one is given.
    #[must_use]
    pub fn destination(&self, name: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(name))
    }
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = finite(text).ok().filter(|number| *number > 0.0);
    number.ok_or_else(|| "it must be a finite number above 0".into())
}

/// A finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "it must be a finite number".into())
}

/// A finite number of 0 or more.
pub(super) fn not_negative(text: &str) -> Result<f64, String> {
    let number = finite(text).ok().filter(|number| *number >= 0.0);
    number.ok_or_else(|| "it must be a finite number of 0 or more".into())
}

/// A probability strictly between 0 and 1.
pub(super) fn probability(text: &str) -> Result<f64, String> {
    positive(text).ok().filter(|number| *number < 1.0).ok_or_else(|| "it must be a number between 0 and 1".into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Line {
        #[command(flatten)]
        common: Common,
    }

    fn parse(flags: &[&str]) -> Result<Common, String> {
        let line = std::iter::once(&"tirtouch").chain(flags);
        Line::try_parse_from(line).map(|line| line.common).map_err(|error| error.to_string())
    }

    #[test]
    fn flags_arrive() {
        let common = parse(&["-o", "x", "--force", "--seed", "7", "--integrator", "map", "--seconds", "1e2"]).unwrap();
        assert_eq!(common.destination("scene"), PathBuf::from("x"));
        assert_eq!(common.seed, Some(7));
        assert_eq!(common.integrator, Some(IntegratorChoice::Map));
        assert_eq!(common.seconds, Some(100.0));
        assert!(common.force && !common.talk.json);
        assert_eq!(parse(&[]).unwrap().destination("scene"), PathBuf::from("out/scene"));
    }

    #[test]
    fn numbers_that_make_no_sense_are_refused() {
        for flags in [
            ["--seconds", "0"],
            ["--seconds", "-1"],
            ["--seconds", "inf"],
            ["--target-error", "nan"],
            ["--target-error", "-0.1"],
            ["--spp", "0"],
            ["--spp", "-4"],
            ["--photons", "0"],
            ["--seed", "-1"],
            ["--seed", "4294967296"],
            ["--integrator", "bdpt"],
            ["--backend", "tpu"],
        ] {
            let refusal = parse(&flags).unwrap_err();
            assert!(refusal.contains(flags[0]), "{flags:?}: {refusal}");
        }
        assert!(probability("1").is_err() && probability("0").is_err() && probability("1e-9").is_ok());
    }

    #[test]
    fn budgets_exclude_each_other_and_fixed_samples() {
        for flags in [
            ["--seconds", "1", "--spp", "4"],
            ["--seconds", "1", "--photons", "4"],
            ["--seconds", "1", "--target-error", "0.1"],
            ["--target-error", "0.1", "--spp", "4"],
            ["--photons", "9", "--target-error", "0.1"],
        ] {
            assert!(parse(&flags).unwrap_err().contains("cannot be used with"), "{flags:?}");
        }
    }

    #[test]
    fn flags_win_over_the_scene() {
        let scene = crate::scene::Render { spp: 9, photons: Some(7), seed: 5, ..Default::default() };
        let settings = parse(&["--spp", "3"]).unwrap().settings(&scene);
        assert_eq!((settings.spp, settings.photons, settings.seed), (3, Some(7), 5));
    }

    #[test]
    fn f64_goes_to_the_cpu_and_never_to_the_gpu() {
        assert!(!parse(&["--precision", "f64"]).unwrap().devices().unwrap().is_gpu());
        let refused = parse(&["--precision", "f64", "--backend", "gpu"]).unwrap().devices().err().unwrap();
        assert_eq!(refused.code(), 2);
    }
}
