//! `demo`: the whole job on a scene that comes with the program.

use super::flags::SceneFile;
use super::job::Job;
use super::measure::SceneReading;
use super::run::whole_job;
use super::{Common, Failure, Outcome, print};
use crate::vary::Set;
use clap::Args;

/// The demo's scene.
const SCENE: &str = "preset:phantom-size-8mm";
/// Camera paths a pixel: a relative error of 1 %, in some seconds on two cores without a GPU.
const SPP: u32 = 32;

/// Do the whole job on a built-in scene: images, estimates, report.html.
///
/// A second run replaces the folder out/demo of the first.
#[derive(Debug, Args)]
pub(super) struct Demo {
    /// Set a key of the scene, as in `stack.layer[0].n=1.42`; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Set>,
    #[command(flatten)]
    common: Common,
}

impl Demo {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let mut common = self.common.clone();
        if common.seconds.or(common.target_error).is_none() {
            common.spp.get_or_insert(SPP);
        }
        let place = &mut common.place;
        place.force |= place.out.is_none();
        let folder = place.take("demo")?;
        let job = Job::read(&SceneFile { scene: SCENE.into(), set: self.set.clone() }, &common)?;
        let reading = SceneReading { subtract_baseline: true, ..SceneReading::default() };
        let out = whole_job(job, &reading, &common, folder)?;
        if !(common.talk.json || common.talk.quiet) {
            print(&format!("\nOpen {} in a browser.", out.join("report.html").display()))?;
        }
        Ok(Outcome::Done)
    }
}
