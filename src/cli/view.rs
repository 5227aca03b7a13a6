//! `view`: a scene to look at in a browser while its numbers change.

use super::flags::{Backend, SceneFile};
use super::job::check_light;
use super::{Failure, Outcome, Talk, cancel};
use crate::trace::Settings;
use crate::view::{Desk, Knob, Server, Span, Tev, ViewError, paint};
use clap::Args;
use serde_json::json;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Time that the work has to pause at the end; after it the program ends all the same.
const LAST_PAUSE: Duration = Duration::from_millis(700);

/// Look at a scene in a browser, with a slider for each of its numbers; Ctrl-C ends it.
///
/// The page is served on this machine alone, at an address that is printed.
#[derive(Debug, Args)]
pub(super) struct View {
    #[command(flatten)]
    scene: SceneFile,
    /// Show this number first, with its range: KEY or KEY=FROM:TO; may be given again.
    #[arg(long, value_name = "KEY=FROM:TO")]
    slider: Vec<Span>,
    /// Port of 127.0.0.1 to listen at [default: a free one].
    #[arg(long, value_name = "N", default_value_t, hide_default_value = true)]
    port: u16,
    /// Send the images to tev, or to a viewer that listens as it does, too.
    #[arg(long, value_name = "HOST:PORT")]
    tev: Option<String>,
    /// Seed of all random numbers [default: the scene's].
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    #[command(flatten)]
    backend: Backend,
    #[command(flatten)]
    talk: Talk,
}

impl View {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = self.scene.open()?;
        check_light(&loaded, &file)?;
        let knobs = Knob::of(&loaded, &file, &self.slider).map_err(ViewError::Knob)?;
        let tev = self.tev.as_deref().map(|place| Tev::connect(place, &loaded.scene.name)).transpose()?;
        let devices = self.backend.open(self.talk.quiet)?;
        let desk = Arc::new(Desk::new(loaded, file));
        let server = Server::open(desk.clone(), &knobs, self.port)?;
        let painter = {
            let (desk, seed) = (desk.clone(), self.seed);
            let settings = move |scene: &crate::scene::Scene| {
                let own = Settings::of(&scene.render);
                Settings { seed: seed.unwrap_or(own.seed), ..own }
            };
            let work = move || paint(devices.into(), &desk, &settings, tev);
            thread::Builder::new().spawn(work).map_err(ViewError::System)?
        };
        self.talk.tell(json!({"url": server.url()}), format!("Open {} in a browser; Ctrl-C ends it.", server.url()))?;
        server.serve(&|| cancel::requested() || painter.is_finished());
        desk.end();
        if painter.is_finished() && !cancel::requested() {
            return Err(Failure::failed("the work on the image broke off"));
        }
        let asked = Instant::now();
        while !painter.is_finished() && asked.elapsed() < LAST_PAUSE {
            thread::sleep(Duration::from_millis(10));
        }
        // That was how it ends.
        cancel::last_word();
        Ok(Outcome::Done)
    }
}
