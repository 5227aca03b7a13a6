//! `study`: true against estimated, for hundreds of phantoms.

use super::command::{command_line, described};
use super::sweep::How;
use super::{Failure, Outcome, Progress, cancel, note};
use crate::calibrate::{FrameModel, ready};
use crate::estimate::Calibration;
use crate::output::{RESULT, Records};
use crate::pages::paper_study::{self, PaperPage};
use crate::pages::study;
use crate::report::Report;
use crate::study::{How as Tried, Paper, PaperFigure, Parts, StudyFile, Summary, Trial, readings, trials};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Try a calibration on phantoms that it was not learnt from: how far off estimates are, how often intervals hold, how
/// often an inclusion is found where there is none. Or read the figures of the TSIS paper from several images each.
#[derive(Debug, Args)]
pub(super) struct Study {
    /// Study file: a calibration, and the sweeps to try it on.
    study: PathBuf,
    #[command(flatten)]
    how: How,
}

impl Study {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let parts = StudyFile::load(&self.study)?.study;
        let name = self.study.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let out = self.how.place_or(|| PathBuf::from("out").join(&name));
        let reader = Reader::of(&parts)?;
        let kind = if parts.paper.is_some() { "study of the paper" } else { "study" };
        // Others may compute parts of the same study.
        let records = Records::join(&out, &json!({"kind": kind}), false, out.is_dir())?;
        let said = match &reader {
            Reader::Paper(paper, calibration) => self.of_paper(&name, &parts, (*paper, calibration.as_ref()), &out)?,
            Reader::Model(model) => self.of_estimates(&name, &parts, model, &out)?,
        };
        records.write(said.table.0, &said.table.1)?;
        records.write("report.html", &said.report.to_html())?;
        let result = described(said.summary, Some(&out));
        records.write(RESULT, &format!("{result:#}\n"))?;
        self.how.talk.tell(&result, &said.text)
    }

    /// True against estimated.
    fn of_estimates(&self, name: &str, parts: &Parts, model: &FrameModel, out: &Path) -> Result<Said, Failure> {
        let (phantoms, empty) = self.folders(parts, out)?;
        let (exposures, exposure_ms, force_error) =
            (parts.exposures.unwrap_or(2), parts.exposure_ms, parts.force_error);
        let tried = |empty| Tried { empty, exposures, exposure_ms, force_error };
        let of = |folder: &Path, empty| self.trials(model, folder, tried(empty));
        let phantoms = of(&phantoms, false)?;
        let empty = empty.as_deref().map_or(Ok(Vec::new()), |folder| of(folder, true))?;
        let summary = Summary::of(&phantoms, &empty)?;
        let page = study::Page { name, description: &parts.description, summary: &summary, model };
        Ok(Said {
            table: ("estimates.csv", study::csv(&phantoms, &empty)?),
            report: page.report(&phantoms, &command_line())?,
            text: page.text(&out.display().to_string()),
            summary: json!(summary),
        })
    }

    /// The TSIS paper's figures of several images.
    fn of_paper(
        &self,
        name: &str,
        parts: &Parts,
        (paper, calibration): (&Paper, Option<&Calibration>),
        out: &Path,
    ) -> Result<Said, Failure> {
        let (phantoms, _) = self.folders(parts, out)?;
        let found = readings(&phantoms, paper, calibration, parts.exposure_ms, &self.observer())?;
        let found = found.ok_or_else(Failure::cancelled)?;
        let summary = paper.summary(&found);
        let page = PaperPage { name, description: &parts.description, summary: &summary };
        Ok(Said {
            table: ("readings.csv", paper_study::csv(&found)?),
            report: page.report(&found, &command_line())?,
            text: page.text(&out.display().to_string()),
            summary: json!(summary),
        })
    }

    /// Folders of the phantoms with inclusions and, where they are asked for, without.
    fn folders(&self, parts: &Parts, out: &Path) -> Result<(PathBuf, Option<PathBuf>), Failure> {
        let (phantoms, empty, is_whole) = self.how.parts(out, |work| {
            let phantoms = work.part(&parts.phantoms, "phantoms")?;
            let empty = parts.empty.as_deref().map(|empty| work.part(empty, "empty")).transpose()?;
            Ok((phantoms, empty, work.is_whole))
        })?;
        if !is_whole && !self.how.talk.quiet {
            note("not all points are there yet: the study is of those that are");
        }
        Ok((phantoms, empty))
    }

    fn observer(&self) -> impl Fn(usize, usize) -> bool + Sync + use<> {
        let progress = Progress::new(self.how.talk.quiet);
        move |done: usize, all: usize| {
            progress.observe(done as f64 / all.max(1) as f64, &format!("phantom {done} of {all}"));
            !cancel::requested()
        }
    }

    fn trials(&self, model: &FrameModel, folder: &Path, tried: Tried) -> Result<Vec<Trial>, Failure> {
        trials(model, folder, tried, &self.observer())?.ok_or_else(Failure::cancelled)
    }
}

/// What images are read by.
enum Reader<'a> {
    /// A figure of the paper, and a calibration of the sensor.
    Paper(&'a Paper, Option<Calibration>),
    /// What was learnt of frames.
    Model(Box<FrameModel>),
}

impl<'a> Reader<'a> {
    fn of(parts: &'a Parts) -> Result<Self, Failure> {
        let file = parts.calibration.as_deref();
        if let Some(paper) = &parts.paper {
            let calibration = file.map(Calibration::load).transpose()?;
            let is_whole =
                |known: &Calibration| known.bottom_area_mm2.and(known.force_n_from_sum_grey.as_ref()).is_some();
            return match (file, paper.figure == PaperFigure::Stiffness && !calibration.as_ref().is_some_and(is_whole)) {
                (Some(file), true) => {
                    let needed = "needs bottom_area_mm2 and force_n_from_sum_grey for a stiffness";
                    Err(Failure::input(format!("{}: {needed}", file.display())).in_file(file))
                }
                _ => Ok(Self::Paper(paper, calibration)),
            };
        }
        match file {
            Some(file) => Ok(Self::Model(Box::new(FrameModel::load(file)?))),
            None => ready()
                .map(|model| Self::Model(Box::new(model.clone())))
                .ok_or_else(|| Failure::failed("the calibration that comes with the program is damaged")),
        }
    }
}

/// What is said of a study.
struct Said {
    /// Name of the table, and it.
    table: (&'static str, String),
    report: Report,
    text: String,
    summary: serde_json::Value,
}
