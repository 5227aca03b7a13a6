//! `compare`: do two radiance images show the same light?

mod strict;

use super::command;
use super::flags::probability;
use super::{Failure, Outcome, Talk, note, print};
use crate::film::Film;
use crate::film::compare::{CompareError, Comparison, compare, compare_paired};
use crate::image_io::{Provenance, read_radiance};
use crate::output::OutputFolder;
use crate::pages::{comparison, difference};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Compare two radiance images by their variances; exit code 1 when they differ.
///
/// Each is a radiance.exr, or a folder with one, or a folder with mean.exr and variance.exr (variance of the mean).
#[derive(Debug, Args)]
pub(super) struct Compare {
    /// The first image.
    a: PathBuf,
    /// The second image.
    b: PathBuf,
    /// Chance of calling equal images different, all tests together.
    #[arg(long, value_name = "P", default_value = "0.001", value_parser = probability, allow_negative_numbers = true)]
    level: f64,
    /// Independent replicates behind the variances of an image that does not say.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..), allow_negative_numbers = true)]
    replicates: u32,
    #[command(flatten)]
    strict: strict::Strict,
    /// Folder to write with difference.svg where the images differ.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the folder if it exists.
    #[arg(long, requires = "out")]
    force: bool,
    #[command(flatten)]
    talk: Talk,
}

impl Compare {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (a, provenance_a) = self.read(&self.a)?;
        let (b, provenance_b) = self.read(&self.b)?;
        if let (Some(first), Some(second)) = (&provenance_a, &provenance_b) {
            check_units(&self.b, first, second)?;
        }
        let folder = self.out.as_deref().map(|out| OutputFolder::create(out, self.force)).transpose()?;
        let (passed, mut found, text) = match self.strict.asked() {
            true => self.strict.judge(&a, &b).map_err(|error| self.refused(&error))?,
            false => {
                let origins = provenance_a.as_ref().zip(provenance_b.as_ref());
                let paired = origins.is_some_and(|(first, second)| first.shares_random_numbers(second));
                let comparison = self.compare(&a, &b, paired)?;
                let unseen = comparison.paired.is_none()
                    && origins.is_some_and(|(first, second)| first.may_share_random_numbers(second));
                if unseen && !self.talk.quiet {
                    note(
                        "both images have the same random numbers (scene, seed and integrator): equal noise hides differences",
                    );
                }
                (comparison.passed, json!(comparison), comparison::table(&comparison))
            }
        };
        found["a"] = json!(self.a.display().to_string());
        found["b"] = json!(self.b.display().to_string());
        let mut printed = found.to_string();
        if let Some(folder) = folder.filter(|_| !passed) {
            folder.write("difference.svg", &difference::picture(&a, &b, self.strict.asked())?)?;
            printed = command::commit(folder, None, found)?.json;
        }
        print(if self.talk.json { &printed } else { &text })?;
        Ok(if passed { Outcome::Done } else { Outcome::CheckFailed })
    }

    fn read(&self, path: &Path) -> Result<(Film, Option<Provenance>), Failure> {
        // A folder that render wrote holds one beside its pictures.
        let inside = path.join("radiance.exr");
        if path.is_dir() && !inside.is_file() && !path.join("mean.exr").is_file() {
            let message = format!("{}: holds neither radiance.exr nor mean.exr and variance.exr", path.display());
            return Err(Failure::input(message).in_file(path));
        }
        let (mut film, provenance) = read_radiance(if inside.is_file() { &inside } else { path })?;
        if film.replicates == 0 {
            film.replicates = self.replicates;
        }
        Ok((film, provenance))
    }

    fn compare(&self, a: &Film, b: &Film, paired: bool) -> Result<Comparison, Failure> {
        let found = if paired { compare_paired(a, b, self.level) } else { compare(a, b, self.level) };
        found.map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &CompareError) -> Failure {
        let files = format!("{} and {}", self.a.display(), self.b.display());
        Failure::input(format!("{files}: {error}")).in_file(&self.b)
    }
}

fn check_units(file: &Path, first: &Provenance, second: &Provenance) -> Result<(), Failure> {
    match first.unit == second.unit {
        true => Ok(()),
        false => {
            let message = format!("{}: its unit is {}, the first image's {}", file.display(), second.unit, first.unit);
            Err(Failure::input(message).in_file(file))
        }
    }
}
