//! The stack from the side (x to the right, z up): layers, LEDs, what touches, the camera's view, and rays.

mod labels;
mod stack;

use super::raster::PictureError;
use super::svg::Svg;

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct SideView {
    /// Title of the picture.
    pub title: String,
    /// A line below the title.
    pub subtitle: String,
    /// Half of the stack's footprint along x, mm.
    pub half_width_mm: f64,
    /// The layers, touch side first.
    pub layers: Vec<SideLayer>,
    /// The interfaces as polylines (x, z) in mm with x rising, touched face first: one more than layers.
    pub interfaces_mm: Vec<Vec<[f64; 2]>>,
    /// Refractive index of the surround.
    pub surround_n: f64,
    /// One edge of the camera's field of view as (x, z) in mm, from the pinhole to the touched face, x not negative
    /// (the first three-dimensional points of [`crate::camera::View::ray_mm`] without y). It is mirrored.
    pub view_edge_mm: Vec<[f64; 2]>,
    /// The LEDs at the left and right wall.
    pub leds: Vec<SideLed>,
    /// Stretches of x in mm where tissue touches.
    pub contact_mm: Vec<[f64; 2]>,
    /// Rays, drawn in this order.
    pub rays: Vec<RayPolyline>,
}

/// One layer.
#[derive(Debug, Clone, PartialEq)]
pub struct SideLayer {
    /// Name.
    pub name: String,
    /// Refractive index.
    pub n: f64,
    /// Thickness where undeformed, mm.
    pub thickness_mm: f64,
}

/// One LED seen from the side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideLed {
    /// Place of its emitting face along x, mm; it faces the middle.
    pub x_mm: f64,
    /// Height of its centre, mm.
    pub z_mm: f64,
    /// Extent along its wall in the section: a chord of its disc, mm.
    pub diameter_mm: f64,
}

/// One ray.
#[derive(Debug, Clone, PartialEq)]
pub struct RayPolyline {
    /// Its points, mm, in the scene's coordinates; y is not drawn.
    pub points_mm: Vec<[f64; 3]>,
    /// What became of it.
    pub fate: Fate,
}

/// What became of a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// Stays in the stack by total internal reflection until it leaves by a wall.
    Guided,
    /// Reaches a place of contact and is scattered by the tissue.
    Scattered,
    /// Leaves through the lowest face.
    EscapedBottom,
    /// Leaves through the touched face.
    EscapedTop,
    /// Ends inside, absorbed.
    Absorbed,
}

impl Fate {
    const ALL: [Self; 5] = [Self::Guided, Self::Scattered, Self::EscapedBottom, Self::EscapedTop, Self::Absorbed];

    /// Colour (near the Okabe-Ito set, told apart without colour vision), dashes, and name.
    fn look(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Guided => ("#0a7cc4", "", "guided"),
            Self::Scattered => ("#d55e00", "", "scattered by contact"),
            Self::EscapedBottom => ("#009e73", "", "escaped below"),
            Self::EscapedTop => ("#aa4499", "", "escaped above"),
            Self::Absorbed => ("#6e7781", "4 3", "absorbed"),
        }
    }
}

/// From millimetres to the picture: one scale along both axes.
struct Frame {
    scale: f64,
    origin: [f64; 2],
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

/// Size of the camera's symbol below the pinhole, of an LED's beside the wall, and most of the whole drawing, pixels.
const CAMERA_PX: f64 = 34.0;
const LED_PX: f64 = 16.0;
const DRAWING: [f64; 2] = [580.0, 620.0];

impl Frame {
    fn new(view: &SideView) -> Self {
        let heights = view.interfaces_mm.iter().flatten().map(|p| p[1]);
        let mut highest = heights.fold(0.0, f64::max);
        if !view.contact_mm.is_empty() {
            highest += 0.12 * view.half_width_mm;
        }
        let lowest = view.view_edge_mm.iter().map(|p| p[1]).fold(0.0, f64::min);
        // A band of surround above so that escaping rays are seen to escape.
        let highest = highest + 0.1 * view.half_width_mm;
        let widest = view.leds.iter().map(|led| led.x_mm.abs()).fold(view.half_width_mm, f64::max);
        let scale = (DRAWING[0] / (2.0 * widest)).min(DRAWING[1] / (highest - lowest));
        let left = 24.0 + LED_PX + 8.0;
        let (width, height) = (2.0 * widest * scale, (highest - lowest) * scale);
        let top = 72.0;
        Self {
            scale,
            origin: [left + 0.5 * width, top + highest * scale],
            left,
            right: left + width,
            top,
            bottom: top + height,
        }
    }

    fn at(&self, [x, z]: [f64; 2]) -> [f64; 2] {
        [self.origin[0] + x * self.scale, self.origin[1] - z * self.scale]
    }

    fn polyline(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().map(|&p| self.at(p)).collect()
    }
}

/// Draws the side view as a self-contained SVG.
///
/// # Errors
/// Where the footprint or a coordinate is not finite, or there is not one interface more than layers.
pub fn side_view(view: &SideView) -> Result<String, PictureError> {
    check(view)?;
    let frame = Frame::new(view);
    let width = frame.right + LED_PX + 26.0 + labels::margin_px(view) + 24.0;
    let legend = labels::legend_rows(view, width - 48.0);
    let legend_top = frame.bottom + CAMERA_PX + 44.0;
    let mut svg = Svg::new(width, legend_top + 22.0 * legend.len() as f64 + 8.0, &view.title, &view.subtitle);
    stack::bands(&mut svg, view, &frame);
    stack::field_of_view(&mut svg, view, &frame);
    stack::tissue(&mut svg, view, &frame);
    stack::rays(&mut svg, view, &frame);
    for interface in &view.interfaces_mm {
        svg.path(&frame.polyline(interface), false, r##"fill="none" stroke="#3b5b7a" stroke-width="1""##);
    }
    stack::leds(&mut svg, view, &frame);
    stack::camera(&mut svg, view, &frame);
    labels::layers(&mut svg, view, &frame);
    labels::surround(&mut svg, view, &frame);
    labels::scale_bar(&mut svg, view, &frame);
    labels::draw_legend(&mut svg, &legend, legend_top);
    Ok(svg.finish())
}

fn check(view: &SideView) -> Result<(), PictureError> {
    let number = |what, value: f64, allowed| Err(PictureError::Number { what, value, allowed });
    if !(view.half_width_mm > 0.0 && view.half_width_mm.is_finite()) {
        return number("half width of the side view", view.half_width_mm, "finite and above 0");
    }
    if view.interfaces_mm.len() != view.layers.len() + 1 {
        return number("number of interfaces", view.interfaces_mm.len() as f64, "one more than that of layers");
    }
    let planar = view.interfaces_mm.iter().flatten().chain(&view.view_edge_mm).chain(&view.contact_mm).flatten();
    let spatial = view.rays.iter().flat_map(|ray| &ray.points_mm).flatten();
    let leds = view.leds.iter().flat_map(|led| [&led.x_mm, &led.z_mm, &led.diameter_mm]);
    match planar.chain(spatial).chain(leds).find(|v| !v.is_finite()) {
        Some(&value) => number("a coordinate of the side view", value, "finite"),
        None => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
