//! `inspect`: what was understood of a scene, and what a render of it would do.

use super::facts::{columns, figure};
use super::job::{Job, check_light, load_scene, watched};
use super::pressing::press_cost;
use super::regimes::{LayerAngles, layers, regimes};
use super::{Failure, Outcome, Talk, print};
use crate::mechanics::memory::limit_gib;
use crate::mechanics::press::Cost;
use crate::pipeline::{Prepared, method_name, view_of};
use crate::scene::LoadedScene;
use crate::streams::{Role, Streams};
use crate::surface::Surface;
use crate::trace::gains::{Gain, gains};
use crate::trace::{BackendChoice, Devices, Kernel, Method, Plan, Precision, Settings};
use clap::Args;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Show what was understood of a scene: angles, regimes, kernel pieces, adapter.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Scene file, or preset:NAME for a scene that comes with the program.
    scene: PathBuf,
    /// Measure what it gains to leave out what the scene does not need: small images with each piece and without, in
    /// turn.
    #[arg(long)]
    gains: bool,
    /// Rounds of that.
    #[arg(long, value_name = "N", default_value_t = 5, requires = "gains", value_parser = clap::value_parser!(u32).range(2..=100), allow_negative_numbers = true)]
    rounds: u32,
    #[command(flatten)]
    talk: Talk,
}

/// Samples a pixel and most pixels along a side of the images that gains are measured on.
const GAIN_IMAGE: (u32, u32) = (64, 192);

impl Inspect {
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        let (loaded, file) = load_scene(&self.scene)?;
        if check_light(&loaded, &file).is_err() && !self.gains {
            return self.mechanics(&loaded, &file).map(|()| Outcome::Done);
        }
        check_light(&loaded, &file)?;
        let prepared = Job::sketch(&self.scene)?;
        let model = &prepared.model;
        let devices = Devices::open(BackendChoice::Auto, Precision::F32);
        let kernel = Kernel::of(model);
        let plan = Plan::choose(prepared.settings.integrator, &kernel)?;
        let loads = |devices: &Devices| devices.load(model).map_err(|error| error.to_string());
        let device =
            match devices.as_ref().map_err(ToString::to_string).and_then(|devices| Ok((devices, loads(devices)?))) {
                Ok((devices, backend)) => Device {
                    backend: Some(backend.name()),
                    adapter: backend.adapter(),
                    notice: devices.notice().map(str::to_owned),
                },
                Err(error) => Device { backend: None, adapter: "none that can do it".into(), notice: Some(error) },
            };
        let press = press_cost(&loaded, &self.scene)?;
        let gains = if self.gains { Some(self.measure(&devices?, &prepared)?) } else { None };
        let seen = Seen { layers: layers(&prepared), prepared: &prepared, kernel, plan, device, press, gains };
        match self.talk.json {
            true => print(&seen.json()?.to_string())?,
            false => print(&seen.text()?)?,
        }
        let same = seen.gains.iter().flatten().all(|gain| gain.same_image);
        Ok(if same { Outcome::Done } else { Outcome::CheckFailed })
    }

    /// What a scene without light does: its press.
    fn mechanics(&self, loaded: &LoadedScene, file: &Path) -> Result<(), Failure> {
        let (scene, press) = (&loaded.scene, press_cost(loaded, file)?);
        if self.talk.json {
            let light = json!({"undefined": "an indenter guides no light"});
            let press = press.map(|cost| cost_json(&cost));
            let said = json!({"scene": scene.name, "description": scene.description, "light": light, "press": press});
            return print(&said.to_string());
        }
        let light = ("light".to_owned(), "none: an indenter presses in the sensor's place".to_owned());
        let press = press.map(|cost| ("press".to_owned(), cost_text(&cost)));
        let rows: Vec<_> = std::iter::once(light).chain(press).collect();
        print(&format!("{}: {}\n\n{}", scene.name, scene.description, columns(&rows)))
    }

    fn measure(&self, devices: &Devices, prepared: &Prepared) -> Result<Vec<Gain>, Failure> {
        let (spp, most) = GAIN_IMAGE;
        let mut model = prepared.model.clone();
        let camera = &mut model.camera;
        let shrink = camera.size[0].max(camera.size[1]).div_ceil(most);
        camera.size = camera.size.map(|pixels| (pixels / shrink).max(1));
        camera.pixel_tan *= f64::from(shrink);
        // No more photons than paths: the fewest that an image has by itself are for its quality, and would hide its
        // paths here.
        let paths = u64::from(camera.size[0]) * u64::from(camera.size[1]) * u64::from(spp);
        let photons = Some(prepared.settings.photons.unwrap_or(paths).min(paths));
        let settings = Settings { spp, photons, ..prepared.settings.clone() };
        let other = Streams { role: Role::Timing, ..prepared.streams.clone() };
        Ok(watched(self.talk.quiet, |observe| gains(devices, &model, &settings, other.light(), self.rounds, observe))?)
    }
}

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

/// All that `inspect` shows.
struct Seen<'a> {
    prepared: &'a Prepared,
    layers: Vec<LayerAngles>,
    kernel: Kernel,
    plan: Plan,
    device: Device,
    press: Option<Cost>,
    gains: Option<Vec<Gain>>,
}

impl Seen<'_> {
    /// The cone that every layer traps: twice the acceptance of the layer that accepts least.
    fn launch_cone_deg(&self) -> f64 {
        2.0 * self.layers.iter().map(|layer| layer.acceptance_deg).fold(90.0, f64::min)
    }

    fn pieces(&self, wanted: bool) -> Vec<&'static str> {
        self.kernel.pieces().iter().filter(|(_, is_in)| *is_in == wanted).map(|(name, _)| *name).collect()
    }

    /// Bytes that a render holds, on the device and in the program, about.
    fn memory(&self) -> [u64; 2] {
        let [columns, rows] = self.prepared.model.camera.size.map(u64::from);
        let pixels = columns * rows;
        let texels = (self.prepared.model.map_size[0] * self.prepared.model.map_size[1]) as u64;
        let deposits = match self.plan.method {
            Method::Path => 0,
            Method::Splat => 8 * pixels,
            Method::Map => (2 * 8 + 16) * texels,
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
        [2 * (16 * pixels + 4 * control) + deposits, 64 * pixels + deposits + 8 * control]
    }

    fn json(&self) -> Result<Value, Failure> {
        let scene = self.prepared.scene();
        let [device, program] = self.memory();
        Ok(json!({
            "scene": scene.name,
            "description": scene.description,
            "layers": self.layers,
            "launch_cone_deg": self.launch_cone_deg(),
            "regimes": regimes(self.prepared, &self.layers),
            "surface": self.prepared.surface.name(),
            "integrator": self.plan.method.name(),
            "why": self.plan.why,
            "kernel": {"included": self.pieces(true), "left_out": self.pieces(false)},
            "camera": {"pixels": scene.camera.pixels, "mm_per_pixel": view_of(self.prepared.scene())?.mm_per_pixel()},
            "memory": {"device_bytes": device, "program_bytes": program},
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

    fn text(&self) -> Result<String, Failure> {
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
        for regime in regimes(self.prepared, &self.layers) {
            let _ = writeln!(text, "  - {regime}");
        }
        let [device, program] = self.memory().map(|bytes| figure(bytes as f64 / f64::from(1 << 20)));
        let list = |pieces: Vec<&str>| if pieces.is_empty() { "nothing".to_owned() } else { pieces.join(", ") };
        let row = |name: &str, value: String| (name.to_owned(), value);
        let mut rows = vec![
            row("surface", self.prepared.surface.name().to_owned()),
            row("integrator", format!("{}: {}", self.plan.method.name(), self.plan.why)),
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
            row("memory", format!("about {device} MiB on the device, {program} MiB in the program")),
        ];
        rows.extend(self.press.map(|cost| row("press", cost_text(&cost))));
        rows.push(row("adapter", self.device.adapter.clone()));
        rows.extend(self.device.notice.iter().map(|notice| row("notice", notice.clone())));
        let _ = write!(text, "\n{}", columns(&rows));
        text.extend(self.gains.as_deref().map(Self::gains_text));
        Ok(text)
    }
}
