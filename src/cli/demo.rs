//! `demo`: the whole job on a scene that comes with the program.

use super::job::Job;
use super::measure::SceneReading;
use super::run::whole_job;
use super::{Common, Failure, Outcome, print};
use crate::output::OutputFolder;
use clap::Args;
use std::path::{Path, PathBuf};

/// The demo's scene.
const SCENE: &str = "preset:phantom-size-8mm";
/// Camera paths a pixel: a relative error of 1 %, in some seconds on two cores without a GPU.
const SPP: u32 = 32;

/// Do the whole job on a built-in scene: images, estimates, report.html.
///
/// A second run replaces the folder out/demo of the first.
#[derive(Debug, Args)]
pub(super) struct Demo {
    #[command(flatten)]
    common: Common,
}

impl Demo {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let mut common = self.common.clone();
        let budget = common.seconds.is_some() || common.target_error.is_some();
        if !budget {
            common.spp.get_or_insert(SPP);
        }
        let place = common.out.clone().unwrap_or_else(|| PathBuf::from("out/demo"));
        let folder = OutputFolder::create(&place, common.force || common.out.is_none())?;
        let job = Job::read(Path::new(SCENE), &common)?;
        let reading = SceneReading { subtract_baseline: true, ..SceneReading::default() };
        let out = whole_job(job, &reading, &common, folder)?;
        if !(common.talk.json || common.talk.quiet) {
            print(&format!("\nOpen {} in a browser.", out.join("report.html").display()))?;
        }
        Ok(Outcome::Done)
    }
}
