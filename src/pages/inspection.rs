//! What was understood of a scene, and what a render of it would do.

use super::facts::{columns, figure};
use super::regimes::{LayerAngles, layers, regimes};
use super::truth::{loads, phantom_rows};
use crate::camera::ProjectionError;
use crate::mechanics::from_scene::press_cost;
use crate::mechanics::memory::limit_gib;
use crate::mechanics::press::Cost;
use crate::pipeline::{PipelineError, Prepared, Truth, guides_light, look, method_name, view_of};
use crate::progress::Observer;
use crate::scene::LoadedScene;
use crate::streams::{Role, Streams};
use crate::surface::Surface;
use crate::trace::gains::{Gain, gains, small};
use crate::trace::{Devices, Integrator, Kernel, Model, Plan, REPLICATES, TraceError};
use serde_json::{Value, json};
use std::fmt::Write;
use std::sync::Arc;

/// What was understood of a scene.
pub struct Inspection(What);

enum What {
    /// A scene that guides light.
    Seen(Box<Seen>),
    /// An indenter that presses in the sensor's place.
    Unlit(Box<Unlit>),
}

impl Inspection {
    /// Looks at a scene, which traces nothing: it is pressed on a coarse mesh. `devices` are what would trace it, or
    /// why there is nothing that could.
    ///
    /// # Errors
    /// A scene that cannot be pressed or traced; a look that `observe` stops.
    pub fn of(
        loaded: Arc<LoadedScene>,
        devices: Result<&Devices, &TraceError>,
        observe: &mut Observer,
    ) -> Result<Self, PipelineError> {
        if guides_light(&loaded).is_err() {
            let (press, truth) = (press_cost(&loaded)?, truth_of(&loaded)?);
            return Ok(Self(What::Unlit(Box::new(Unlit { loaded, press, truth }))));
        }
        let prepared = look(loaded.clone(), observe)?;
        let kernel = Kernel::of(&prepared.model);
        let plan = Plan::choose(prepared.settings.integrator, &kernel)?;
        let device = Device::of(devices, &prepared.model);
        let (layers, press, truth) = (layers(&prepared), press_cost(&loaded)?, truth_of(&loaded)?);
        let seen = Seen { prepared, layers, kernel, plan, device, press, truth, gains: None };
        Ok(Self(What::Seen(Box::new(seen))))
    }

    /// Measures what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// so many rounds. Whether the images agree.
    ///
    /// # Errors
    /// A scene without light; what the tracer says.
    pub fn measure_gains(
        &mut self,
        devices: &Devices,
        rounds: u32,
        observe: &mut Observer,
    ) -> Result<bool, PipelineError> {
        let What::Seen(seen) = &mut self.0 else { return Err(PipelineError::NoLight) };
        let (model, settings) = small(&seen.prepared.model, &seen.prepared.settings);
        let other = Streams { role: Role::Timing, ..seen.prepared.streams.clone() };
        let found = gains(devices, &model, &settings, other.light(), rounds, observe)?;
        let same = found.iter().all(|gain| gain.same_image);
        seen.gains = Some(found);
        Ok(same)
    }

    /// For programs.
    ///
    /// # Errors
    /// A camera that does not see the face.
    pub fn json(&self) -> Result<Value, ProjectionError> {
        match &self.0 {
            What::Seen(seen) => seen.json(),
            What::Unlit(unlit) => Ok(unlit.json()),
        }
    }

    /// For people.
    ///
    /// # Errors
    /// As [`Self::json`].
    pub fn text(&self) -> Result<String, ProjectionError> {
        match &self.0 {
            What::Seen(seen) => seen.text(),
            What::Unlit(unlit) => Ok(unlit.text()),
        }
    }
}

fn truth_of(loaded: &LoadedScene) -> Result<Truth, PipelineError> {
    Ok(Truth::of(loaded.scene.phantom.as_ref(), &loaded.files, false)?)
}

/// What a scene without light does: its press.
struct Unlit {
    loaded: Arc<LoadedScene>,
    press: Option<Cost>,
    truth: Truth,
}

impl Unlit {
    fn json(&self) -> Value {
        let (scene, press) = (&self.loaded.scene, self.press.map(|cost| cost_json(&cost)));
        let light = json!({"undefined": "an indenter guides no light"});
        json!({
            "scene": scene.name, "description": scene.description, "light": light, "truth": self.truth, "press": press
        })
    }

    fn text(&self) -> String {
        let scene = &self.loaded.scene;
        let light = ("light".to_owned(), "none: an indenter presses in the sensor's place".to_owned());
        let press = self.press.map(|cost| ("press".to_owned(), cost_text(&cost)));
        let loads = scene.press.as_ref().map(|press| ("loads".to_owned(), loads(press)));
        let rows: Vec<_> = std::iter::once(light).chain(phantom_rows(&self.truth)).chain(loads).chain(press).collect();
        format!("{}: {}\n\n{}", scene.name, scene.description, columns(&rows))
    }
}

/// What a press will take, for programs.
fn cost_json(cost: &Cost) -> Value {
    json!({
        "elements": cost.elements,
        "dofs": cost.unknowns,
        "method": method_name(cost.method),
        "memory_gib": cost.memory_gib,
        "memory_limit_gib": limit_gib(),
        "seconds": cost.seconds,
    })
}

/// The same for people.
fn cost_text(cost: &Cost) -> String {
    let fits = if cost.memory_gib <= limit_gib() { "of" } else { "MORE THAN" };
    format!(
        "{} elements, {} unknowns by {}: at most {} GiB, {fits} {} that may be had; about {} s, to a factor of 3",
        cost.elements,
        cost.unknowns,
        method_name(cost.method),
        figure(cost.memory_gib),
        figure(limit_gib()),
        figure(cost.seconds)
    )
}

/// Where a render would compute.
struct Device {
    backend: Option<&'static str>,
    adapter: String,
    /// Why not on a GPU.
    notice: Option<String>,
}

impl Device {
    /// Of the devices that were opened, if they can trace the model.
    fn of(devices: Result<&Devices, &TraceError>, model: &Model<f64>) -> Self {
        let backend = devices.map_err(ToString::to_string).and_then(|devices| {
            let backend = devices.load(model).map_err(|error| error.to_string())?;
            Ok((backend, devices.notice()))
        });
        match backend {
            Ok((backend, notice)) => {
                Self { backend: Some(backend.name()), adapter: backend.adapter(), notice: notice.map(str::to_owned) }
            }
            Err(error) => Self { backend: None, adapter: "none that can do it".into(), notice: Some(error) },
        }
    }
}

/// What a scene that guides light does.
struct Seen {
    prepared: Prepared,
    layers: Vec<LayerAngles>,
    kernel: Kernel,
    plan: Plan,
    device: Device,
    press: Option<Cost>,
    truth: Truth,
    gains: Option<Vec<Gain>>,
}

impl Seen {
    /// The cone that every layer traps: twice the acceptance of the layer that accepts least.
    fn launch_cone_deg(&self) -> f64 {
        2.0 * self.layers.iter().map(|layer| layer.acceptance_deg).fold(90.0, f64::min)
    }

    fn pieces(&self, wanted: bool) -> Vec<&'static str> {
        self.kernel.pieces().iter().filter(|(_, is_in)| *is_in == wanted).map(|(name, _)| *name).collect()
    }

    /// Bytes that a render holds, on the device and in the program, about; and what a render to an asked error keeps
    /// beside it of each replicate's photons.
    fn memory(&self) -> [u64; 3] {
        let [columns, rows] = self.prepared.model.camera.size.map(u64::from);
        let pixels = columns * rows;
        let texels = (self.prepared.model.map_size[0] * self.prepared.model.map_size[1]) as u64;
        let deposits = match self.plan.integrator {
            Integrator::Path => 0,
            Integrator::Splat => 8 * pixels,
            Integrator::Map => (2 * 8 + 16) * texels,
        };
        let control = match &self.prepared.surface {
            Surface::Fields(fields) => fields.iter().flatten().map(|field| field.control.len() as u64).sum(),
            Surface::Profiles(profiles) => {
                profiles.iter().flatten().map(|profile| 4 * profile.cells.len() as u64).sum()
            }
            _ => 0,
        };
        // Device: two words a sum and the count of segments beside it, and the surface, once for camera paths and once
        // for photons. Program: what comes back, the replicate, running mean and deviation, film, picture values.
        let kept = if self.plan.integrator == Integrator::Map { u64::from(REPLICATES) * 2 * 8 * texels } else { 0 };
        [2 * (16 * pixels + 4 * control) + deposits, 64 * pixels + deposits + 8 * control, kept]
    }

    fn json(&self) -> Result<Value, ProjectionError> {
        let scene = self.prepared.scene();
        let [device, program, kept] = self.memory();
        Ok(json!({
            "scene": scene.name,
            "description": scene.description,
            "layers": self.layers,
            "launch_cone_deg": self.launch_cone_deg(),
            "regimes": regimes(&self.prepared, &self.layers),
            "surface": self.prepared.surface.name(),
            "integrator": self.plan.integrator.name(),
            "why": self.plan.why,
            "kernel": {"included": self.pieces(true), "left_out": self.pieces(false)},
            "camera": {"pixels": scene.camera.pixels, "mm_per_pixel": view_of(self.prepared.scene())?.mm_per_pixel()},
            "memory": {"device_bytes": device, "program_bytes": program, "asked_error_bytes": kept},
            "truth": self.truth,
            "press": self.press.map(|cost| cost_json(&cost)),
            "backend": self.device.backend,
            "adapter": self.device.adapter,
            "notice": self.device.notice,
            "gains": self.gains,
        }))
    }

    /// What leaving out gains, a row each.
    fn gains_text(gains: &[Gain]) -> String {
        let row = |gain: &Gain| {
            let image = if gain.same_image { "same image" } else { "ANOTHER IMAGE" };
            let times = format!("{:.2} times the time ({:.2} to {:.2}), {image}", gain.slower, gain.low, gain.high);
            (gain.piece.clone(), times)
        };
        let rows: Vec<_> = gains.iter().map(row).collect();
        format!("\n  with what is left out, on a small image:\n{}", columns(&rows))
    }

    fn text(&self) -> Result<String, ProjectionError> {
        let scene = self.prepared.scene();
        let width = self.layers.iter().map(|layer| layer.name.chars().count()).max().unwrap_or(0).max(5);
        let mut text = format!("{}: {}\n\n", scene.name, scene.description);
        let _ = writeln!(
            text,
            "  {:width$}  {:>8}  {:>12}  {:>16}  {:>22}",
            "layer", "n", "thickness/mm", "acceptance/deg", "critical angle/deg"
        );
        for layer in &self.layers {
            let critical = layer.critical_text();
            let _ = writeln!(
                text,
                "  {:width$}  {:>8.5}  {:>12}  {:>16.3}  {critical:>22}",
                layer.name, layer.n, layer.thickness_mm, layer.acceptance_deg
            );
        }
        let _ = writeln!(
            text,
            "\n  light from the edge is trapped within a cone of {:.3} degrees\n",
            self.launch_cone_deg()
        );
        for regime in regimes(&self.prepared, &self.layers) {
            let _ = writeln!(text, "  - {regime}");
        }
        let [device, program, kept] = self.memory().map(|bytes| figure(bytes as f64 / f64::from(1 << 20)));
        let list = |pieces: Vec<&str>| if pieces.is_empty() { "nothing".to_owned() } else { pieces.join(", ") };
        let row = |name: &str, value: String| (name.to_owned(), value);
        let mut rows = vec![
            row("surface", self.prepared.surface.name().to_owned()),
            row("integrator", format!("{}: {}", self.plan.integrator.name(), self.plan.why)),
            row("kernel has", list(self.pieces(true))),
            row("leaves out", list(self.pieces(false))),
            row(
                "camera",
                format!(
                    "{} x {} pixels, {} mm each on the touched face",
                    scene.camera.pixels[0],
                    scene.camera.pixels[1],
                    figure(view_of(self.prepared.scene())?.mm_per_pixel())
                ),
            ),
            row(
                "memory",
                format!(
                    "about {device} MiB on the device, {program} MiB in the program, {kept} more to an asked error"
                ),
            ),
        ];
        rows.extend(phantom_rows(&self.truth));
        rows.extend(scene.press.as_ref().map(|press| row("loads", loads(press))));
        rows.extend(self.press.map(|cost| row("press", cost_text(&cost))));
        rows.push(row("adapter", self.device.adapter.clone()));
        rows.extend(self.device.notice.iter().map(|notice| row("notice", notice.clone())));
        let _ = write!(text, "\n{}", columns(&rows));
        text.extend(self.gains.as_deref().map(Self::gains_text));
        Ok(text)
    }
}
