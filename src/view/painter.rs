//! Makes the images of what is wished for.

use super::desk::{Desk, Wish};
use super::look::Look;
use super::rungs::{Rung, rungs};
use super::tev::Tev;
use crate::calibrate::estimates_of;
use crate::estimate::GreyImage;
use crate::pipeline::{Order, PipelineError, Prepared, Session, Shot, Truth};
use crate::scene::Scene;
use crate::trace::Settings;
use serde_json::json;
use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time between two words on how far the work is.
const BETWEEN_WORDS: Duration = Duration::from_millis(150);

/// Makes images of the latest wish until the desk's end; they also go to `tev`, if there is one. `settings` say how the
/// last image of each wish is traced.
pub fn paint(mut session: Session, desk: &Desk, settings: &dyn Fn(&Scene) -> Settings, mut tev: Option<Tev>) {
    let mut before = 0;
    while let Some(wish) = desk.next(before) {
        before = wish.number;
        desk.show(|seen| (seen.wish, seen.busy, seen.error, seen.step) = (wish.number, true, None, 0));
        let painted = Painter { session: &mut session, desk, wish: &wish, told: Instant::now(), tev: &mut tev }
            .paint(&settings(&wish.loaded.scene));
        let error = painted.err().map(|error| error.to_string()).filter(|_| desk.is_latest(wish.number));
        desk.show(|seen| (seen.busy, seen.error, seen.done) = (!desk.is_latest(wish.number), error, 1.0));
    }
}

/// The work on one wish.
struct Painter<'a> {
    session: &'a mut Session,
    desk: &'a Desk,
    wish: &'a Wish,
    told: Instant,
    tev: &'a mut Option<Tev>,
}

impl Painter<'_> {
    fn paint(&mut self, asked: &Settings) -> Result<(), Box<dyn Error>> {
        let wish = self.wish;
        let scene = &wish.loaded.scene;
        let truth = json!(Truth::of(scene.phantom.as_ref(), &wish.loaded.files, false)?);
        let rungs = rungs(asked, scene.press.is_some());
        let others = scene.press.is_some();
        let steps = rungs.len() + usize::from(others);
        let mut last = None;
        for (step, Rung { settings, sketch }) in rungs.into_iter().enumerate() {
            self.at(step, steps);
            let order = Order { settings, sketch, near: sketch, ..Order::of(scene) };
            let prepared = self.prepare(&order)?;
            let is_last = step + 1 + usize::from(others) == steps;
            let shot = self.shoot(&prepared)?;
            let look = Look::of(&shot, &truth, wish.number, step + 1, is_last)?;
            if let Some(tev) = self.tev {
                // Who looks there may have closed it: the page goes on.
                let _ = tev.show(&shot.outcome.film, &shot.outcome.unseen.variances(&shot.outcome.film));
            }
            self.show(look);
            if is_last {
                let frame = GreyImage::from_frame(&shot.frame)?;
                drop(shot);
                last = Some((prepared, frame));
            }
        }
        match last {
            Some((prepared, frame)) if others => {
                self.at(steps - 1, steps);
                self.estimate(&prepared, frame)
            }
            _ => Ok(()),
        }
    }

    /// Traces the loads before the last, and says what all frames tell of the inclusion.
    fn estimate(&mut self, prepared: &Prepared, frame: GreyImage) -> Result<(), Box<dyn Error>> {
        let Some((pressed, last)) = &prepared.press else { return Ok(()) };
        let mut frames = Vec::with_capacity(last + 1);
        for (load, step) in pressed.steps.iter().enumerate().take(*last) {
            let earlier = prepared.at_load(load)?;
            frames.push((step.depth_mm, GreyImage::from_frame(&self.shoot(&earlier)?.frame)?));
        }
        frames.extend(pressed.steps.get(*last).map(|step| (step.depth_mm, frame)));
        let estimates = json!(estimates_of(None, &self.wish.loaded, &frames));
        self.desk.show(|seen| seen.estimates = Some(estimates));
        Ok(())
    }

    fn prepare(&mut self, order: &Order) -> Result<Prepared, PipelineError> {
        let Self { session, desk, wish, told, .. } = self;
        session.prepare(wish.loaded.clone(), order, &mut |stage| tell(desk, wish, told, stage.what, stage.done))
    }

    fn shoot<'p>(&mut self, prepared: &'p Prepared) -> Result<Shot<'p>, PipelineError> {
        let Self { session, desk, wish, told, .. } = self;
        session.shoot(prepared, &mut |stage| tell(desk, wish, told, stage.what, stage.done))
    }

    fn at(&mut self, step: usize, steps: usize) {
        self.desk.show(|seen| (seen.step, seen.steps, seen.done) = (step + 1, steps, 0.0));
    }

    fn show(&mut self, look: Look) {
        self.desk.show(|seen| (seen.look, seen.estimates) = (Some(Arc::new(look)), None));
    }
}

/// Tells the page how far the work is, now and then; false where the wish is no longer the latest.
fn tell(desk: &Desk, wish: &Wish, told: &mut Instant, what: &str, done: f64) -> bool {
    if told.elapsed() >= BETWEEN_WORDS {
        *told = Instant::now();
        desk.show(|seen| (seen.what, seen.done) = (what.to_owned(), done));
    }
    desk.is_latest(wish.number)
}
