//! The pictures of frames.

use super::{Computed, Reading};
use crate::estimate::tissue::Fitted;
use crate::figure::Figure;
use crate::mechanics::frames::Features;
use crate::mechanics::press::element_pressure;
use crate::pages::PageError;
use crate::pages::facts::figure;
use crate::report::{
    AxisName, Curve, CurvePlot, CurveStyle, FramePicture, MeshBody, MeshPicture, MeshValues, curve_plot, frame_picture,
    frames_image, mesh_picture,
};

/// The pictures, as SVG.
pub struct Pictures {
    /// All frames as an image.
    pub frames: String,
    /// The shown frame with its fit.
    pub frame: String,
    /// Peak and base against position.
    pub pressure: String,
    /// Width against position.
    pub width: String,
    /// Eccentricity against position.
    pub eccentricity: String,
    /// The pressed tissue, where it was computed.
    pub pressed: Option<String>,
}

const POSITION: AxisName = AxisName { quantity: "position of the indenter", unit: "mm" };

impl Pictures {
    /// Draws them.
    ///
    /// # Errors
    /// Frames that cannot be drawn.
    pub fn draw(reading: &Reading) -> Result<Self, PageError> {
        let (source, all) = (&reading.source, &reading.features);
        let name = &source.name;
        let middle = source.computed.as_ref().is_some_and(|computed| computed.has_middle);
        let frame = FramePicture {
            title: &format!("{name}: one frame"),
            frame: reading.frame(),
            reference: reading.reference(),
            features: &all[reading.shown],
        };
        let plot = |title: &str, subtitle: &str, y: AxisName, curves: Vec<Curve>| {
            curve_plot(&CurvePlot {
                title: &format!("{name}: {title}"),
                subtitle,
                x: POSITION,
                y,
                curves,
                highest: None,
                from_zero: true,
            })
        };
        let window = format!("parabola over {}", reading.window_text());
        let kpa = AxisName { quantity: "pressure", unit: "kPa" };
        let peak = curve("peak of the parabola", all, |f| &f.peak_kpa);
        let base = curve("base: pressure at the window's ends", all, |f| &f.base_kpa);
        let fitted = |name: &str, pick: fn(&Fitted) -> Option<f64>| fitted(name, reading, pick);
        let pressures =
            [peak, base, fitted("peak that fits", |f| f.peak_kpa), fitted("base that fits", |f| f.base_kpa)].concat();
        let (read, fits) = match reading.tissue {
            Some(_) if reading.noisy.is_some() => ("frames without noise", "tissue that fits those with noise"),
            Some(_) => ("read off the frames", "tissue that fits"),
            None => ("", ""),
        };
        let widths = [curve(read, all, |f| &f.fwhm_mm), fitted(fits, |f| f.fwhm_mm)].concat();
        let leans = match source.computed {
            // Its reference is another.
            Some(_) => curve("", all, |f| &f.eccentricity),
            None => [curve(read, all, |f| &f.eccentricity), fitted(fits, |f| f.eccentricity)].concat(),
        };
        let width = AxisName { quantity: "full width at half of the peak", unit: "mm" };
        let lean = AxisName { quantity: "eccentricity", unit: "" };
        let reference = format!("compared with {}", source.reference_name());
        let pressed = source.computed.as_ref().map(|computed| pressed(name, computed));
        Ok(Self {
            frames: frames_image(&format!("{name}: pressure frames"), &source.frames, middle)?,
            frame: frame_picture(&frame)?,
            pressure: plot("peak and base", &window, kpa, pressures)?,
            width: plot("width", &window, width, widths)?,
            eccentricity: plot("eccentricity", &reference, lean, leans)?,
            pressed: pressed.transpose()?,
        })
    }

    /// Names of their files.
    pub fn files(&self) -> Vec<(&'static str, &str)> {
        let mut files = vec![
            ("frames.svg", self.frames.as_str()),
            ("frame.svg", &self.frame),
            ("features_pressure.svg", &self.pressure),
            ("features_width.svg", &self.width),
            ("features_eccentricity.svg", &self.eccentricity),
        ];
        files.extend(self.pressed.as_deref().map(|svg| ("pressed.svg", svg)));
        files
    }
}

/// A feature against position, a line for each run of frames that have it.
fn curve(name: &str, all: &[Features], pick: fn(&Features) -> &Figure) -> Vec<Curve> {
    let points: Vec<[f64; 2]> = all.iter().filter_map(|f| Some([f.position_mm, pick(f).value()?])).collect();
    // With gaps, a line would show what is not there.
    let style = if points.len() == all.len() && points.len() > 1 { CurveStyle::Line } else { CurveStyle::Points };
    vec![Curve { name: name.to_owned(), points, band: Vec::new(), style }]
}

/// A feature of the tissue that fits, where one was sought.
fn fitted(name: &str, reading: &Reading, pick: fn(&Fitted) -> Option<f64>) -> Vec<Curve> {
    let fitted = reading.tissue.as_ref().map_or(&[][..], |tissue| &tissue.fitted);
    let points: Vec<[f64; 2]> = fitted.iter().filter_map(|f| Some([f.position_mm, pick(f)?])).collect();
    let curve = Curve { name: name.to_owned(), points, band: Vec::new(), style: CurveStyle::Points };
    (!curve.points.is_empty()).then_some(curve).into_iter().collect()
}

/// How much of the tissue beside the indenter is shown, in frames' half widths.
const VIEW: f64 = 1.6;

/// The tissue pressed at the shown position, with the indenter below it.
fn pressed(name: &str, computed: &Computed) -> Result<String, PageError> {
    let (setup, shown) = (&computed.setup, &computed.scanned.shown);
    let half = setup.places_mm.last().copied().unwrap_or(1.0);
    let indenter = setup.indenter_mesh(shown.position_mm, half, 0.1 * half);
    let (values, none) = (element_pressure(&shown.problem, &shown.state), vec![0.0; indenter.element_count()]);
    let lowest = indenter.bounding_box()[0][1];
    let top = setup.tissue.shape.height_mm() - setup.depth_mm;
    let picture = MeshPicture {
        title: &format!("{name}: the pressed tissue"),
        subtitle: &format!("indenter at {} mm, {} mm deep", figure(shown.position_mm), figure(setup.depth_mm)),
        bodies: vec![
            MeshBody {
                mesh: &shown.problem.mesh,
                displacement_mm: &shown.state.displacement,
                values: MeshValues::ElementNode(&values),
            },
            MeshBody { mesh: &indenter, displacement_mm: &[], values: MeshValues::Cell(&none) },
        ],
        values: AxisName { quantity: "pressure", unit: "kPa" },
        range: None,
        horizontal: "x",
        mirrored: false,
        view_mm: Some([[shown.position_mm - VIEW * half, shown.position_mm + VIEW * half], [lowest, top]]),
    };
    Ok(mesh_picture(&picture)?)
}
