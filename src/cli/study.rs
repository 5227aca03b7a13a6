//! `study`: true against estimated, for hundreds of phantoms.

use super::command::{command_line, described};
use super::sweep::How;
use super::{Failure, Outcome, Progress, cancel, note, print};
use crate::calibrate::{FrameModel, ready};
use crate::output::{RESULT, Records};
use crate::pages::study;
use crate::study::{How as Tried, StudyError, StudyFile, Summary, Trial, trials};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Try a calibration on phantoms that it was not learnt from: how far off estimates are, how often intervals hold, how
/// often an inclusion is found where there is none.
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
        // Others may compute parts of the same study.
        let records = Records::join(&out, &json!({"kind": "study"}), false, out.is_dir())?;
        let own = parts.calibration.as_deref().map(FrameModel::load).transpose()?;
        let model = match &own {
            Some(own) => own,
            None => ready().ok_or_else(|| Failure::failed("the calibration that comes with the program is damaged"))?,
        };
        let mut work = self.how.parts(&out);
        let phantoms = work.part(&parts.phantoms, "phantoms")?;
        let empty = parts.empty.as_deref().map(|empty| work.part(empty, "empty")).transpose()?;
        if !work.is_whole && !self.how.is_quiet() {
            note("not all points are there yet: the study is of those that are");
        }
        let (exposures, exposure_ms) = (parts.exposures, parts.exposure_ms);
        let of = |folder: &Path, empty| self.trials(model, folder, Tried { empty, exposures, exposure_ms });
        let phantoms = of(&phantoms, false)?;
        let empty = empty.as_deref().map_or(Ok(Vec::new()), |folder| of(folder, true))?;
        let summary = Summary::of(&phantoms, &empty)?;
        let page = study::Page { name: &name, description: &parts.description, summary: &summary, model };
        records.write("estimates.csv", &study::csv(&phantoms, &empty)?)?;
        records.write("report.html", &page.report(&phantoms, &command_line())?.to_html())?;
        let result = described(json!(summary), Some(&out));
        records.write(RESULT, &format!("{result:#}\n"))?;
        match self.how.is_json() {
            true => print(&result.to_string())?,
            false => print(&page.text(&out.display().to_string()))?,
        }
        Ok(Outcome::Done)
    }

    fn trials(&self, model: &FrameModel, folder: &Path, tried: Tried) -> Result<Vec<Trial>, Failure> {
        let progress = Progress::new(self.how.is_quiet());
        let observe = |done: usize, all: usize| {
            progress.observe(done as f64 / all.max(1) as f64, &format!("phantom {done} of {all}"));
            !cancel::requested()
        };
        trials(model, folder, tried, &observe)?.ok_or_else(Failure::cancelled)
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Sweep(error) => error.into(),
            StudyError::Exposure(error) => error.into(),
            StudyError::Frame(error) => error.into(),
            StudyError::Phantom(error) => error.into(),
            StudyError::Statistics(error) => Self::failed(error.to_string()),
        }
    }
}
