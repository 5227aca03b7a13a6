//! `compare`: do two radiance images show the same light?

use super::flags::probability;
use super::{Failure, Outcome, Talk, note, print};
use crate::film::Film;
use crate::film::compare::{Comparison, LevelTest, compare};
use crate::image_io::{Provenance, read_radiance};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
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
    talk: Talk,
}

impl Compare {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (a, provenance_a) = self.read(&self.a)?;
        let (b, provenance_b) = self.read(&self.b)?;
        if let (Some(first), Some(second)) = (&provenance_a, &provenance_b) {
            check_units(&self.b, first, second)?;
            if !self.talk.quiet && shares_random_numbers(first, second) {
                note(
                    "both images have the same random numbers (scene, seed and integrator): equal noise hides differences",
                );
            }
        }
        let comparison = self.compare(&a, &b)?;
        match self.talk.json {
            true => print(&self.json(&comparison).to_string())?,
            false => print(&table(&comparison))?,
        }
        Ok(if comparison.passed { Outcome::Done } else { Outcome::CheckFailed })
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

    fn compare(&self, a: &Film, b: &Film) -> Result<Comparison, Failure> {
        compare(a, b, self.level).map_err(|error| {
            let files = format!("{} and {}", self.a.display(), self.b.display());
            Failure::input(format!("{files}: {error}")).in_file(&self.b)
        })
    }

    fn json(&self, comparison: &Comparison) -> Value {
        let ratio = match &comparison.ratio {
            Some(ratio) => json!(ratio),
            None => json!({"undefined": "the first image is dark"}),
        };
        json!({
            "a": self.a.display().to_string(),
            "b": self.b.display().to_string(),
            "passed": comparison.passed,
            "level": comparison.level,
            "tests": comparison.tests,
            "mean_a": comparison.mean_a,
            "mean_b": comparison.mean_b,
            "ratio": ratio,
        })
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

fn shares_random_numbers(first: &Provenance, second: &Provenance) -> bool {
    // Images that do not name their stream have those of their seed and scene.
    let origin = |image: &Provenance| match image.stream {
        Some(stream) => (stream, String::new(), image.integrator.clone()),
        None => (image.seed, image.scene_sha256.clone(), image.integrator.clone()),
    };
    origin(first) == origin(second)
}

fn table(comparison: &Comparison) -> String {
    let verdict = if comparison.passed { "same" } else { "DIFFERENT" };
    let mut text = format!("{verdict} (chance of a false alarm {})\n", comparison.level);
    let _ = writeln!(text, "{:<14}{:>9}{:>11}{:>11}{:>11}", "level", "cells", "largest z", "chi2/dof", "p");
    for test in &comparison.tests {
        let _ = writeln!(text, "{}", row(test));
    }
    let _ = writeln!(text, "mean A {:.6e}, mean B {:.6e}", comparison.mean_a, comparison.mean_b);
    match &comparison.ratio {
        Some(ratio) => {
            let _ = writeln!(text, "B/A {:.6} (95 %: {:.6} to {:.6})", ratio.value, ratio.low, ratio.high);
        }
        None => text.push_str("B/A undefined: A is dark\n"),
    }
    text
}

fn row(test: &LevelTest) -> String {
    let name = match test.edge {
        0 => "whole image".to_owned(),
        1 => "pixels".to_owned(),
        edge => format!("blocks of {edge}"),
    };
    if test.cells == 0 {
        return format!("{name:<14}{:>9}  too little light to test", 0);
    }
    let mark = if test.passed { "" } else { "  <- differs" };
    let share = test.chi2 / test.dof;
    format!("{name:<14}{:>9}{:>11.2}{share:>11.3}{:>11.2e}{mark}", test.cells, test.max_z, test.p_value)
}
