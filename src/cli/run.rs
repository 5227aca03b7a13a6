//! `run`: from a scene to estimates and a report.

use super::facts::{columns, facts, interval, ledger};
use super::job::Job;
use super::measure::{Figures, Reading};
use super::page::report;
use super::shot::Shot;
use super::{Common, Failure, Outcome, OutputFolder, print};
use crate::estimate::Value as Estimate;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Why there are no mechanics.
pub(super) const NO_MECHANICS: &str = "the scene prescribes shape and contact; this version presses nothing itself";

/// Trace, expose and estimate: what render writes, the camera image in false colour, and report.html.
#[derive(Debug, Args)]
pub(super) struct Run {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    common: Common,
}

impl Run {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let job = Job::load(&self.scene, &self.common)?;
        let folder = OutputFolder::create(&self.common.destination(&job.scene().name), self.common.force)?;
        whole_job(&job, &self.reading, &self.common, folder).map(|_| Outcome::Done)
    }
}

/// Does the whole job, writes its folder and prints its figures; gives the folder's place.
pub(super) fn whole_job(
    job: &Job,
    reading: &Reading,
    common: &Common,
    folder: OutputFolder,
) -> Result<PathBuf, Failure> {
    let reference = reading.reference(job.scene().camera.pixels)?;
    let calibration = reading.calibration()?;
    let shot = Shot::take(job, common.talk.quiet)?;
    let figures = reading.of_shot(&shot, reference.as_ref(), calibration.as_ref())?;
    let pictures = shot.write(&folder)?;
    let seen = shot.camera_pictures()?;
    folder.write("camera_false_color.svg", &seen.false_color)?;
    folder.write("camera_relief.svg", &seen.relief)?;
    folder.write("report.html", &report(&shot, &figures, reading, &pictures, &seen).to_html())?;
    let out = folder.commit()?;
    if common.talk.json {
        print(&json(&shot, &figures, reading, &out.display().to_string()).to_string())?;
    } else {
        print(&text(&shot, &figures, reading, &out.display().to_string()))?;
    }
    Ok(out)
}

fn json(shot: &Shot, figures: &Figures, reading: &Reading, out: &str) -> Value {
    let mut object = shot.json();
    if let Some(Value::Object(camera)) = object.get_mut("camera") {
        let lit = shot.frame.grey.iter().filter(|&&grey| f64::from(grey) > reading.threshold).count();
        camera.insert("lit_pixels".into(), json!(lit));
    }
    let mut paper = json!(figures.paper);
    paper["threshold_grey"] = json!(reading.threshold);
    paper["reference"] = json!(reading.reference.as_ref().map(|path| path.display().to_string()));
    object.insert("paper".into(), paper);
    object.insert("estimates".into(), json!(figures.estimates));
    object.insert("mechanics".into(), json!({"undefined": NO_MECHANICS}));
    object.insert("out".into(), json!(out));
    Value::Object(object)
}

fn text(shot: &Shot, figures: &Figures, reading: &Reading, out: &str) -> String {
    let (paper, estimates) = (&figures.paper, &figures.estimates);
    let row = |name: &str, value: String| (name.to_owned(), value);
    let mut rows = facts(shot);
    rows.extend([
        row("light", ledger(shot)),
        row("mechanics", format!("none: {NO_MECHANICS}")),
        row(
            "lit area",
            format!("{} (threshold {} grey levels)", said(&paper.diameter_px, "pixels across"), reading.threshold),
        ),
        row("size", said(&estimates.size_mm, "mm")),
        row("depth", said(&estimates.depth_mm, "mm")),
        row("modulus", said(&estimates.youngs_kpa, "kPa")),
        row("indicator h", said(&paper.h_grey, "grey levels")),
        row("sum M", said(&paper.sum_grey, "grey levels")),
    ]);
    rows.extend(paper.warnings.iter().map(|warning| row("note", warning.clone())));
    rows.push(row("folder", out.to_owned()));
    rows.push(row("report", format!("{out}/report.html")));
    format!("{}\n{}", shot.job.scene().name, columns(&rows))
}

/// A value with its interval, or why there is none.
pub(super) fn said(value: &Estimate, unit: &str) -> String {
    match value {
        Estimate::Known { value, low, high } => {
            let (value, range) = interval(*value, *low, *high);
            format!("{value} {unit} (95 %: {range})")
        }
        Estimate::Undefined { reason } => format!("undefined: {reason}"),
    }
}
