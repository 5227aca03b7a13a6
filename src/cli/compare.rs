//! `compare`: do two radiance images show the same light?

use super::command;
use super::flags::{not_negative, probability};
use super::{Failure, Outcome, Talk, print};
use crate::film::Film;
use crate::film::compare::{CompareError, Tolerance, deviations};
use crate::image_io::Pair;
use crate::output::OutputFolder;
use crate::pages::{comparison, difference};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

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
    #[arg(long, value_name = "P", default_value = "0.001", value_parser = probability)]
    level: f64,
    /// Independent replicates behind the variances of an image that does not say.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(2..))]
    replicates: u32,
    #[command(flatten)]
    strict: Strict,
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
        let pair = Pair::read(&self.a, &self.b, self.replicates)?;
        let folder = self.out.as_deref().map(|out| OutputFolder::create(out, self.force)).transpose()?;
        let refused = |error: CompareError| {
            let files = format!("{} and {}", self.a.display(), self.b.display());
            Failure::input(format!("{files}: {error}")).in_file(&self.b)
        };
        let (passed, mut found, text) = match self.strict.asked() {
            true => self.strict.judge(&pair.a, &pair.b).map_err(refused)?,
            false => {
                let comparison = pair.compare(self.level).map_err(refused)?;
                if comparison.paired.is_none() && pair.may_share_random_numbers() {
                    self.talk.note(
                        "both have the same random numbers (scene, seed, integrator): equal noise hides differences",
                    );
                }
                (comparison.passed, json!(comparison), comparison::table(&comparison))
            }
        };
        found["a"] = json!(self.a.display().to_string());
        found["b"] = json!(self.b.display().to_string());
        let mut printed = found.to_string();
        if let Some(folder) = folder.filter(|_| !passed) {
            folder.write("difference.svg", &difference::picture(&pair.a, &pair.b, self.strict.asked())?)?;
            printed = command::commit(folder, None, found)?.json;
        }
        print(if self.talk.json { &printed } else { &text })?;
        Ok(if passed { Outcome::Done } else { Outcome::CheckFailed })
    }
}

/// How far pixels may be apart, if that is asked for in place of the statistics.
#[derive(Debug, Args)]
struct Strict {
    /// Not a bit may differ, in means and variances; no statistics.
    #[arg(long, conflicts_with_all = ["tolerance", "absolute"])]
    exact: bool,
    /// Largest deviation of a pixel's mean, as a share of the larger of both; no statistics.
    #[arg(long, value_name = "E", value_parser = not_negative)]
    tolerance: Option<f64>,
    /// Largest deviation of a pixel's mean, W/(m^2 sr); with --tolerance one of both is enough.
    #[arg(long, value_name = "E", value_parser = not_negative)]
    absolute: Option<f64>,
}

impl Strict {
    /// Whether it is asked for.
    fn asked(&self) -> bool {
        self.exact || self.tolerance.is_some() || self.absolute.is_some()
    }

    /// The verdict, as JSON and as text.
    fn judge(&self, a: &Film, b: &Film) -> Result<(bool, Value, String), CompareError> {
        let either = Tolerance { relative: self.tolerance.unwrap_or(0.0), absolute: self.absolute.unwrap_or(0.0) };
        let found = deviations(a, b, (!self.exact).then_some(either))?;
        Ok((found.passed, comparison::strict_json(&found), comparison::strict_text(&found)))
    }
}
