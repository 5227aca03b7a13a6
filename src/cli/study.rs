//! `study`: true against estimated, for hundreds of phantoms.

use super::command::{command_line, described};
use super::job::watching;
use super::sweep::How;
use super::{Failure, Outcome};
use crate::output::{RESULT, Records};
use crate::pages::study::{About, Folders};
use crate::study::{Parts, Reader, StudyFile};
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
        let out = self.how.folder_of_parts(&name)?;
        let reader = Reader::of(&parts)?;
        let kind = if parts.paper.is_some() { "study of the paper" } else { "study" };
        // Others may compute parts of the same study.
        let records = Records::join(&out, &json!({"kind": kind}), false, out.is_dir())?;
        let folders = self.folders(&parts, &out)?;
        let page = About { name: &name, parts: &parts, out: &out.display().to_string(), command: &command_line() };
        let said = page.said(&reader, &folders, &watching(self.how.talk.quiet))?.ok_or_else(Failure::cancelled)?;
        said.write(&records)?;
        let result = described(said.summary, Some(&out));
        records.write(RESULT, &format!("{result:#}\n"))?;
        self.how.talk.tell(&result, &said.text)
    }

    /// Folders of the phantoms with inclusions and, where they are asked for, without.
    fn folders(&self, parts: &Parts, out: &Path) -> Result<Folders, Failure> {
        let (folders, is_whole) = self.how.parts(out, |work| {
            let phantoms = work.part(&parts.phantoms, "phantoms")?;
            let empty = parts.empty.as_deref().map(|empty| work.part(empty, "empty")).transpose()?;
            Ok((Folders { phantoms, empty }, work.is_whole))
        })?;
        if !is_whole {
            self.how.talk.note("not all points are there yet: the study is of those that are");
        }
        Ok(folders)
    }
}
