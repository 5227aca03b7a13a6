//! What stays from image to image.

use super::{Order, PipelineError, Prepared, Shot};
use crate::mechanics::from_scene::press_setup;
use crate::mechanics::press::{Cost, Findings, Load, PressError, PressSettings, Pressed, Setup, press_near};
use crate::progress::Observer;
use crate::scene::{LoadedScene, sha256};
use crate::streams::{Role, Streams};
use crate::trace::{BackendChoice, Devices, Precision, TraceError};
use crate::version::SOURCES;
use std::collections::VecDeque;
use std::sync::Arc;

/// Presses that are kept.
const KEPT_PRESSES: usize = 4;

/// Unknowns of a press that a look at a scene waits for.
const SKETCHED_UNKNOWNS: usize = 30_000;

/// Devices with their kernels, and the last presses.
pub struct Session {
    devices: Devices,
    presses: VecDeque<Kept>,
    /// Presses without inclusions, each with the press that it started from.
    baselines: VecDeque<(Setup, Arc<Pressed>, Arc<Pressed>)>,
}

/// Where presses are kept for other sessions, in this program or another.
pub trait Shelf {
    /// What the press of a name found; none where it is the caller's to make. Waits while another session makes it, as
    /// long as `observe` says so.
    fn find(&self, name: &str, observe: &mut Observer) -> Option<Findings>;

    /// Keeps what it found, or nothing where it could not be made.
    fn keep(&self, name: &str, findings: Option<&Findings>);
}

/// Finds and keeps nothing.
impl Shelf for () {
    fn find(&self, _: &str, _: &mut Observer) -> Option<Findings> {
        None
    }

    fn keep(&self, _: &str, _: Option<&Findings>) {}
}

/// The press of a description as the shelf has it, or as it is made, and then kept there. Its name tells it from all
/// others, those of other versions and those that start from another press.
fn shelved(
    shelf: &dyn Shelf,
    setup: &Setup,
    near: Option<&Pressed>,
    settings: PressSettings,
    observe: &mut Observer,
) -> Result<Pressed, PressError> {
    let from = near.map(|near| (&near.setup, near.steps.iter().any(|step| step.error.is_some())));
    let whole = format!("{SOURCES} {settings:?} {setup:?} from {from:?}");
    let name = format!("press-{:.32}", sha256(whole.as_bytes()));
    if let Some(found) = shelf.find(&name, observe).and_then(|findings| Pressed::of_findings(setup, findings)) {
        return Ok(found);
    }
    let made = press_near(setup, near, settings, observe);
    shelf.keep(&name, made.as_ref().ok().map(Pressed::findings).as_ref());
    made
}

/// A press by what it was asked.
struct Kept {
    setup: Setup,
    estimate_error: bool,
    /// Whether it started from another: its bits then depend on that one.
    near: bool,
    pressed: Arc<Pressed>,
}

impl Session {
    /// Opens what is asked for. f64 is computed by the built-in tracer alone.
    ///
    /// # Errors
    /// `NoAdapter` where a GPU is asked for and none is there; what a driver says.
    pub fn open(choice: BackendChoice, precision: Precision) -> Result<Self, TraceError> {
        Devices::open(choice, precision).map(Self::from)
    }

    /// What traces.
    pub fn devices(&self) -> &Devices {
        &self.devices
    }

    /// Presses a scene's phantom, or takes the press of a scene whose phantom, sensor and loads were the same.
    ///
    /// # Errors
    /// [`PipelineError::Press`]; a press that stops early holds the loads that it reached.
    pub fn press(
        &mut self,
        loaded: &LoadedScene,
        order: &Order,
        observe: &mut Observer,
    ) -> Result<Arc<Pressed>, PipelineError> {
        self.press_by(&(), loaded, order, observe)
    }

    /// The same with a shelf for what this session does not have. A press that starts from the last one is not put
    /// there.
    ///
    /// # Errors
    /// As [`Self::press`].
    pub fn press_by(
        &mut self,
        shelf: &dyn Shelf,
        loaded: &LoadedScene,
        order: &Order,
        observe: &mut Observer,
    ) -> Result<Arc<Pressed>, PipelineError> {
        let (setup, settings) = asked(loaded, order)?;
        let same = |kept: &Kept| {
            kept.estimate_error == settings.estimate_error && kept.setup == setup && (order.near || !kept.near)
        };
        if let Some(kept) = self.presses.iter().position(same).and_then(|place| self.presses.remove(place)) {
            let pressed = kept.pressed.clone();
            self.presses.push_front(kept);
            return Ok(pressed);
        }
        let near = self.presses.front().filter(|_| order.near).map(|kept| &*kept.pressed);
        let pressed = Arc::new(match near {
            Some(_) => press_near(&setup, near, settings, observe)?,
            None => shelved(shelf, &setup, None, settings, observe)?,
        });
        let (near, estimate_error) = (near.is_some(), settings.estimate_error);
        self.presses.truncate(KEPT_PRESSES - 1);
        let kept = Kept { setup, estimate_error, near, pressed: pressed.clone() };
        self.presses.push_front(kept);
        Ok(pressed)
    }

    /// Makes a scene ready, pressed first where it presses; it is then at the last load.
    ///
    /// # Errors
    /// As [`Self::press`] and [`Prepared::new`]; a scene without light.
    pub fn prepare(
        &mut self,
        loaded: impl Into<Arc<LoadedScene>>,
        order: &Order,
        observe: &mut Observer,
    ) -> Result<Prepared, PipelineError> {
        let loaded = loaded.into();
        guides_light(&loaded)?;
        let (press, load) = match loaded.scene.press {
            Some(_) => {
                let pressed = self.press(&loaded, order, observe)?;
                let last = pressed.steps.len().saturating_sub(1);
                (Some((pressed, last)), last)
            }
            None => (None, 0),
        };
        let streams = Streams { load, ..order.streams(&loaded) };
        Prepared::new(loaded, press, order.settings.clone(), streams)
    }

    /// The load that is traced without inclusions, with random numbers of its own. It starts from the press with them.
    ///
    /// # Errors
    /// As [`Self::prepare`]; `NoBaseline` where nothing is pressed.
    pub fn baseline(&mut self, prepared: &Prepared, observe: &mut Observer) -> Result<Prepared, PipelineError> {
        self.baseline_by(&(), prepared, observe)
    }

    /// The same with a shelf for what this session does not have.
    ///
    /// # Errors
    /// As [`Self::baseline`].
    pub fn baseline_by(
        &mut self,
        shelf: &dyn Shelf,
        prepared: &Prepared,
        observe: &mut Observer,
    ) -> Result<Prepared, PipelineError> {
        let Some((from, load)) = &prepared.press else { return Err(PipelineError::NoBaseline) };
        let pressed = &**from;
        let (load, at) = load_of_baseline(pressed, *load);
        let setup = Setup { load, ..pressed.setup.without_inclusions() };
        let same = |(kept, start, _): &&(Setup, Arc<Pressed>, Arc<Pressed>)| *kept == setup && Arc::ptr_eq(start, from);
        let baseline = match self.baselines.iter().find(same) {
            Some((_, _, baseline)) => baseline.clone(),
            None => {
                let baseline = shelved(shelf, &setup, Some(pressed), PressSettings::default(), observe)?;
                let baseline = Arc::new(baseline);
                self.baselines.truncate(KEPT_PRESSES - 1);
                self.baselines.push_front((setup, from.clone(), baseline.clone()));
                baseline
            }
        };
        let streams = Streams { role: Role::Baseline, ..prepared.streams.clone() };
        Prepared::new(prepared.loaded.clone(), Some((baseline, at)), prepared.settings.clone(), streams)
    }

    /// Traces the image and exposes it.
    ///
    /// # Errors
    /// An exposure that makes no sense, before the work; what the tracer says.
    pub fn shoot<'a>(&self, prepared: &'a Prepared, observe: &mut Observer) -> Result<Shot<'a>, PipelineError> {
        Shot::take(&self.devices, prepared, observe)
    }
}

impl From<Devices> for Session {
    fn from(devices: Devices) -> Self {
        Self { devices, presses: VecDeque::new(), baselines: VecDeque::new() }
    }
}

/// A look at a scene, which traces nothing and presses on a coarse mesh.
pub(crate) fn look(loaded: Arc<LoadedScene>, observe: &mut Observer) -> Result<Prepared, PipelineError> {
    let order = Order { sketch: true, ..Order::of(&loaded.scene) };
    Session::from(Devices::cpu(Precision::F32)).prepare(loaded, &order, observe)
}

/// Refuses a scene whose light cannot be traced.
pub(crate) fn guides_light(loaded: &LoadedScene) -> Result<(), PipelineError> {
    match &loaded.scene.press {
        Some(press) if press.indenter.is_some() => Err(PipelineError::NoLight),
        _ => Ok(()),
    }
}

/// What brings a phantom without its inclusions to a load of a press, and which of its loads that is: the depth that
/// was reached, with all that came before it where the way counts, and with the last where it turns on its way.
fn load_of_baseline(pressed: &Pressed, load: usize) -> (Load, usize) {
    if let Load::Path(poses) = &pressed.setup.load {
        return (Load::Path(poses.iter().take(load + 1).copied().collect()), load);
    }
    let first = if pressed.assembly.problem.way_counts() { 0 } else { load };
    let turns = pressed.setup.tilt_deg != [0.0; 2];
    let depths = pressed.steps.iter().map(|step| step.depth_mm).enumerate();
    let wanted = depths.filter(|(k, _)| *k >= first && (turns || *k <= load));
    (Load::Depths(wanted.map(|(_, depth)| depth).collect()), load - first)
}

/// The press that an order asks for.
fn asked(loaded: &LoadedScene, order: &Order) -> Result<(Setup, PressSettings), PipelineError> {
    let setup = press_setup(loaded)?;
    let setup = if order.without_inclusions { setup.without_inclusions() } else { setup };
    let setup = if order.sketch { sketch(&setup) } else { setup };
    let asked = loaded.scene.press.as_ref().is_some_and(|press| press.estimate_error);
    Ok((setup, PressSettings { estimate_error: asked && !order.sketch, ..PressSettings::default() }))
}

/// The same press on elements of twice the size; in three dimensions on larger ones still, until it takes a moment.
fn sketch(setup: &Setup) -> Setup {
    let mut sketch = setup.halved();
    for _ in 0..2 {
        match Cost::of(&sketch, None) {
            Ok(cost) if cost.unknowns > SKETCHED_UNKNOWNS => sketch = sketch.halved(),
            _ => break,
        }
    }
    sketch
}
