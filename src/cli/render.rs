//! `render`: the light of a scene, as radiance and as the camera sees it.

use super::facts::{columns, facts, ledger};
use super::job::Order;
use super::shot::Shot;
use super::{Common, Failure, Outcome, OutputFolder, print};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Trace the light of a scene: radiance.exr, camera.png and pictures of them.
#[derive(Debug, Args)]
pub(super) struct Render {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    #[command(flatten)]
    common: Common,
}

impl Render {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let common = &self.common;
        let order = Order::read(&self.scene, common)?;
        let folder = OutputFolder::create(&common.destination(order.name()), common.force)?;
        let job = order.prepare()?;
        let shot = Shot::take(&job, common.talk.quiet)?;
        shot.write(&folder)?;
        let out = folder.commit()?.display().to_string();
        if common.talk.json {
            let mut object = shot.json();
            object.insert("out".into(), json!(out));
            print(&Value::Object(object).to_string())?;
        } else {
            let mut rows = facts(&shot);
            rows.push(("light".into(), ledger(&shot)));
            rows.push(("folder".into(), format!("{out}: camera.png radiance.exr radiance.svg relief.svg side.svg")));
            print(&format!("{}\n{}", job.scene().name, columns(&rows)))?;
        }
        Ok(Outcome::Done)
    }
}
