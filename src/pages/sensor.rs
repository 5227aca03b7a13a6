//! A sensor's calibration on the bench: its file, its table, its picture.

use super::PageError;
use super::facts::{columns, figure};
use super::tables::table;
use crate::estimate::sensor::{ForceLaw, Scale};
use crate::mechanics::press::PressStep;
use crate::output::OutputFolder;
use crate::pipeline::Shot;
use crate::report::{AxisName, Curve, CurvePlot, CurveStyle, curve_plot};
use crate::scene::{Invalid, LoadedScene, Scene};
use serde::Serialize;
use serde_json::{Value, json};

/// A press at a known force.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Press {
    /// Depth, mm.
    pub depth_mm: f64,
    /// Force, N.
    pub force_n: f64,
    /// Sum of the grey values of its frame.
    pub sum_grey: f64,
}

/// What is known of a sensor after its calibration.
pub struct Bench {
    /// Name of the scene.
    pub name: String,
    /// Millimetres per pixel.
    pub scale: Scale,
    /// Area of the waveguide's bottom, mm².
    pub bottom_area_mm2: f64,
    /// The presses.
    pub presses: Vec<Press>,
    /// Force against the sum of grey values.
    pub law: ForceLaw,
}

/// Presses by which forces are calibrated.
const PRESSES: u32 = 8;

/// A scene pressed to eight depths, the deepest its own.
///
/// # Errors
/// A scene that does not press, or not to depths.
pub fn at_depths(loaded: &LoadedScene) -> Result<LoadedScene, Invalid> {
    let mut loaded = loaded.clone();
    let Some(press) = &mut loaded.scene.press else {
        return Err(Invalid::new("press", "forces are calibrated by presses, and the scene has no [press]"));
    };
    let Some(deepest) = press.depths_mm.as_ref().and_then(|depths| depths.last().copied()) else {
        return Err(Invalid::new("press.depths_mm", "forces are calibrated by presses to depths; give depths_mm"));
    };
    let share = |k: u32| deepest * f64::from(k) / f64::from(PRESSES);
    (press.depths_mm, press.estimate_error) = (Some((1..=PRESSES).map(share).collect()), false);
    Ok(loaded)
}

impl Press {
    /// The press that a shot is of.
    ///
    /// # Errors
    /// A frame with saturated pixels.
    pub fn of(shot: &Shot, step: &PressStep) -> Result<Self, Invalid> {
        let (depth_mm, force_n, camera) = (step.depth_mm, step.force_n, shot.camera_summary());
        if camera.saturated_pixels > 0 {
            let message =
                format!("the frame at {depth_mm} mm has saturated pixels: its sum says too little; expose shorter");
            return Err(Invalid::new("camera.sensor.exposure_ms", message));
        }
        Ok(Self { depth_mm, force_n, sum_grey: camera.sum_grey as f64 })
    }
}

impl Bench {
    /// What presses of a scene say of its sensor.
    ///
    /// # Errors
    /// Says why no law fits them.
    pub fn of(scene: &Scene, scale: Scale, presses: Vec<Press>) -> Result<Self, String> {
        let points: Vec<[f64; 2]> = presses.iter().map(|press| [press.sum_grey, press.force_n]).collect();
        let (law, [width, depth]) = (ForceLaw::fit(&points)?, scene.stack.footprint_mm);
        Ok(Self { name: scene.name.clone(), scale, bottom_area_mm2: width * depth, presses, law })
    }

    /// Writes calibration.toml, presses.csv and force.svg.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), PageError> {
        folder.write("calibration.toml", &self.file())?;
        let head = ["depth_mm", "force_n", "sum_grey", "fitted_force_n"].map(str::to_owned).to_vec();
        let row = |press: &Press| {
            [press.depth_mm, press.force_n, press.sum_grey, self.law.at(press.sum_grey)].map(|v| v.to_string()).to_vec()
        };
        folder.write("presses.csv", &table("presses.csv", head, self.presses.iter().map(row))?)?;
        Ok(folder.write("force.svg", &self.picture()?)?)
    }

    /// The calibration file that `estimate --calibration` reads.
    fn file(&self) -> String {
        let rows: Vec<String> = self.law.rows.iter().map(|[m, f]| format!("    [{m:.6e}, {f:.6e}],\n")).collect();
        format!(
            "# The sensor of the scene {}, calibrated by a target and {} presses without inclusions.\n\
             # Sums are those of whole frames as they are, nothing subtracted, at the scene's exposure.\n\
             mm_per_pixel = {:.8}\nbottom_area_mm2 = {}\nforce_n_from_sum_grey = [\n{}]\n",
            self.name,
            self.presses.len(),
            self.scale.mm_per_pixel,
            self.bottom_area_mm2,
            rows.concat()
        )
    }

    fn picture(&self) -> Result<String, PageError> {
        let curve =
            |name: &str, points: Vec<[f64; 2]>, style| Curve { name: name.to_owned(), points, band: Vec::new(), style };
        let presses = self.presses.iter().map(|press| [press.sum_grey, press.force_n]).collect();
        Ok(curve_plot(&CurvePlot {
            title: &format!("{}: force against light", self.name),
            subtitle: &self.words(),
            x: AxisName { quantity: "sum of grey values", unit: "" },
            y: AxisName { quantity: "force", unit: "N" },
            curves: vec![
                curve("fit", self.law.rows.clone(), CurveStyle::Line),
                curve("presses without inclusions", presses, CurveStyle::Points),
            ],
            highest: None,
            from_zero: true,
        })?)
    }

    fn words(&self) -> String {
        let form = match self.law.form {
            crate::estimate::sensor::Form::Proportional => "F = a M",
            crate::estimate::sensor::Form::Line => "F = a + b M",
            crate::estimate::sensor::Form::Power => "F = a M^b",
            crate::estimate::sensor::Form::Parabola => "F = a + b M + c M²",
        };
        format!("{form}; {} N rms, {} N where left out", figure(self.law.rms_n), figure(self.law.left_out_rms_n))
    }

    /// What `--json` prints.
    pub fn json(&self) -> Value {
        json!({
            "scene": self.name,
            "scale": self.scale,
            "bottom_area_mm2": self.bottom_area_mm2,
            "force": self.law,
            "presses": self.presses,
        })
    }

    /// The same in words.
    pub fn text(&self, out: &str) -> String {
        let row = |name: &str, value: String| (name.to_owned(), value);
        let scale = &self.scale;
        let range = |of: fn(&Press) -> f64| {
            let ends =
                [self.presses.first(), self.presses.last()].map(|press| press.map_or(String::new(), |p| figure(of(p))));
            ends.join(" to ")
        };
        let rows = [
            row(
                "mm per pixel",
                format!(
                    "{}; {} dots, off by {} mm rms, {} at most",
                    figure(scale.mm_per_pixel),
                    scale.dots,
                    figure(scale.rms_mm),
                    figure(scale.worst_mm)
                ),
            ),
            row("force", self.words()),
            row(
                "from",
                format!(
                    "{} presses without inclusions, {} N, M {}",
                    self.presses.len(),
                    range(|p| p.force_n),
                    range(|p| p.sum_grey)
                ),
            ),
            row("area of the bottom", format!("{} mm²", figure(self.bottom_area_mm2))),
            row("calibration", format!("{out}/calibration.toml")),
        ];
        format!("{}\n{}", self.name, columns(&rows))
    }
}
