//! The part of a report that answers: pictures whose pixels tell their values, loads to choose from, a body that turns.
//!
//! Here stands what the page carries; scripts and style are files of their own, which the page holds too. Without
//! scripts nothing of it is seen.

mod packed;
mod points;

pub use packed::Packed;
pub use points::{Point, Points};

use super::false_color::{ColorScale, Mapping, color};
use super::raster::Raster;
use serde::Serialize;

/// What can be looked at.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Explore {
    /// Loads of the press, in order; the last one is shown first.
    pub loads: Vec<Load>,
    /// Pictures.
    pub views: Vec<View>,
    /// Contact pressure along the radius.
    pub curves: Option<Curves>,
    /// The deformed bodies.
    pub solid: Option<Solid>,
}

/// A load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Load {
    /// In words.
    pub name: String,
    /// Depth, mm.
    pub depth_mm: f64,
    /// Force, N.
    pub force_n: f64,
    /// Peak pressure, kPa.
    pub peak_pressure_kpa: f64,
}

/// A picture with its values.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct View {
    /// Heading.
    pub title: String,
    /// What the values are.
    pub quantity: &'static str,
    /// Their unit; empty where there is none.
    pub unit: &'static str,
    /// What the error of a value is, in words.
    pub error_is: &'static str,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Edge of the squares of the image's pixels of which each value is the mean.
    pub block: usize,
    /// Where a pixel lies.
    pub place: Place,
    /// How values become colours.
    pub scale: Scale,
    /// Which colours.
    pub palette: &'static str,
    /// Noise of a grey level, where values are such.
    pub noise: Option<Noise>,
    /// The image at each load that has one.
    pub frames: Vec<Frame>,
}

/// An image.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Frame {
    /// Its load.
    pub load: usize,
    /// File with the same values; empty where there is none.
    pub file: String,
    /// Values, row-major, row 0 at positive y.
    pub values: Packed,
    /// Standard errors.
    pub errors: Option<Packed>,
}

/// Places on the touched face.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Place {
    /// Seen through a lens and the stack: distances from the axis, mm, of points `step_px` pixels apart in the image.
    Lens {
        /// Distance of two points in the image, pixels.
        step_px: f64,
        /// From the axis, mm, from 0.
        radius_mm: Vec<f64>,
    },
    /// Pixels of one size.
    Flat {
        /// Edge of a pixel, mm.
        mm_per_pixel: f64,
    },
}

/// From values to a share of the colours, 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scale {
    /// Value of the first colour.
    pub low: f64,
    /// Of the last.
    pub high: f64,
    /// Whether ratios are even.
    pub log: bool,
    /// Whether values lie beyond the ends.
    pub beyond: bool,
}

impl Scale {
    /// That of the picture in false colour.
    pub fn of(raster: &Raster, scale: ColorScale) -> Self {
        let Mapping { low, high, log } = Mapping::choose(&raster.blocks(raster.width, raster.height), scale);
        Self { low, high, log, beyond: false }
    }
}

/// Noise of a camera's grey level v: its square is `per_level` (v - `black`) + `floor`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Noise {
    /// Grey levels per electron.
    pub per_level: f64,
    /// Grey level without light.
    pub black: f64,
    /// Square of the noise without light, grey levels.
    pub floor: f64,
}

/// Contact pressure along the radius at each load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curves {
    /// Name of the horizontal axis.
    pub along: &'static str,
    /// Greatest pressure shown, kPa.
    pub highest_kpa: f64,
    /// Points (distance in mm, pressure in kPa) of each load.
    pub loads: Vec<Vec<[f64; 2]>>,
}

/// The deformed bodies as quadrilaterals.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solid {
    /// What the quadrilaterals are.
    pub kind: SolidKind,
    /// Signs of x and y of the parts that are drawn.
    pub copies: Vec<[f64; 2]>,
    /// Corners of each quadrilateral.
    pub quads: Packed,
    /// Ends of the outline's edges, of a section.
    pub outline: Packed,
    /// Places before the press, mm: all x (or r), then all z of a section; all x, y, z of a surface.
    pub places: Packed,
    /// What each load makes of it.
    pub loads: Vec<SolidLoad>,
    /// Pressures of the first and the last colour, kPa.
    pub range_kpa: [f64; 2],
}

/// What the quadrilaterals of a solid are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolidKind {
    /// Half of the section through the axis of a body of revolution.
    Revolved,
    /// Half of the section of a long body.
    Extruded,
    /// The surface of a part that shows its cuts.
    Surface,
}

/// A solid at a load.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SolidLoad {
    /// Displacements, mm, in the order of the places.
    pub moved: Packed,
    /// Mean compressive stress at each place, kPa.
    pub pressure_kpa: Packed,
}

/// Colours of the palettes.
const COLORS: usize = 256;

#[derive(Serialize)]
struct Palettes {
    light: String,
    pressure: String,
    signed: String,
}

fn hex(color: impl Fn(f64) -> [u8; 3]) -> String {
    let share = |i: usize| i as f64 / (COLORS - 1) as f64;
    (0..COLORS).flat_map(|i| color(share(i)).map(|byte| format!("{byte:02x}"))).collect()
}

fn rgb(color: colorous::Color) -> [u8; 3] {
    [color.r, color.g, color.b]
}

/// The skeleton that scripts fill.
pub(super) const PAGE: &str = include_str!("explore.html");
/// Its style.
pub(super) const STYLE: &str = include_str!("explore.css");
/// The scripts, in order: numbers, a picture that tells them, a body that turns, and all of it linked.
pub(super) const SCRIPTS: [&str; 4] =
    [include_str!("numbers.js"), include_str!("probe.js"), include_str!("solid.js"), include_str!("explore.js")];
/// The same of the points of a sweep.
pub(super) const POINTS_PAGE: &str = include_str!("points.html");
pub(super) const POINTS_SCRIPTS: [&str; 2] = [include_str!("numbers.js"), include_str!("points.js")];

impl Explore {
    /// All that the scripts know, as JSON that is safe inside of a page.
    pub(super) fn json(&self) -> String {
        #[derive(Serialize)]
        struct Whole<'a> {
            #[serde(flatten)]
            explore: &'a Explore,
            palettes: Palettes,
        }
        let palettes = Palettes {
            light: hex(color),
            pressure: hex(|share| rgb(colorous::YELLOW_ORANGE_RED.eval_continuous(share))),
            signed: hex(|share| rgb(colorous::RED_BLUE.eval_continuous(1.0 - share))),
        };
        in_page(&Whole { explore: self, palettes })
    }
}

/// JSON that does not end the script around it. Numbers, texts and lists of them always become some.
pub(super) fn in_page(content: &impl Serialize) -> String {
    serde_json::to_string(content).unwrap_or_default().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_does_not_end_the_script_that_holds_it() {
        let load = Load { name: "</script>".into(), depth_mm: 1.0, force_n: 2.0, peak_pressure_kpa: 3.0 };
        let json = Explore { loads: vec![load], ..Explore::default() }.json();
        assert!(!json.contains('<') && json.contains("\\u003c/script>"), "{json}");
    }

    #[test]
    fn palettes_begin_and_end_with_the_colours_of_the_pictures() {
        let light = hex(color);
        assert_eq!((light.len(), &light[..6], &light[light.len() - 6..]), (6 * COLORS, "000004", "fcffa4"));
    }
}
