//! Images as the library takes them, before they are Python's: pressed, traced and exposed.

use crate::press::stopped;
use crate::scene::Scene;
use crate::trouble::Trouble;
use tirtouch::camera::{Frame, Suited};
use tirtouch::pipeline::{Order, Prepared, Session, Shot, ShotSummary};
use tirtouch::progress::Observer;
use tirtouch::trace::Outcome;

/// A shot that owns what it was traced from.
pub struct Taken {
    pub prepared: Prepared,
    pub outcome: Outcome,
    pub frame: Frame,
    pub suited: Suited,
    pub mm_per_pixel: f64,
    pub summary: ShotSummary,
}

impl Taken {
    /// Traces the image and exposes it.
    ///
    /// # Errors
    /// What the library says, of a scene of that file.
    pub fn take(session: &Session, prepared: Prepared, scene: &Scene, observe: &mut Observer) -> Result<Self, Trouble> {
        let shot = session.shoot(&prepared, observe).map_err(|error| Trouble::of_scene(error, &scene.file))?;
        let summary = shot.summary();
        let Shot { outcome, frame, suited, mm_per_pixel, .. } = shot;
        Ok(Self { prepared, outcome, frame, suited, mm_per_pixel, summary })
    }

    /// The shot as the library knows it.
    pub fn shot(&self) -> Shot<'_> {
        Shot {
            prepared: &self.prepared,
            outcome: self.outcome.clone(),
            frame: self.frame.clone(),
            suited: self.suited,
            mm_per_pixel: self.mm_per_pixel,
        }
    }
}

/// The scene, pressed where it presses, at its last load.
pub fn prepared(
    session: &mut Session,
    scene: &Scene,
    order: &Order,
    observe: &mut Observer,
) -> Result<Prepared, Trouble> {
    let without_inclusions = order.without_inclusions;
    let of_press = |error| stopped(error, scene, without_inclusions);
    session.prepare(scene.loaded.clone(), order, observe).map_err(of_press)
}

/// The load that is traced without inclusions.
///
/// # Errors
/// What the library says.
pub fn baseline(
    session: &mut Session,
    scene: &Scene,
    prepared: &Prepared,
    observe: &mut Observer,
) -> Result<Taken, Trouble> {
    let baseline = session.baseline(prepared, observe).map_err(|error| Trouble::of_scene(error, &scene.file))?;
    Taken::take(session, baseline, scene, observe)
}

/// Images of the loads before the one that is prepared.
///
/// # Errors
/// What the library says.
pub fn earlier_loads(
    session: &Session,
    scene: &Scene,
    prepared: &Prepared,
    observe: &mut Observer,
) -> Result<Vec<Taken>, Trouble> {
    let last = prepared.press.as_ref().map_or(0, |(_, load)| *load);
    let at = |load| {
        let earlier = prepared.at_load(load).map_err(|error| Trouble::of_scene(error, &scene.file))?;
        Taken::take(session, earlier, scene, observe)
    };
    (0..last).map(at).collect()
}
