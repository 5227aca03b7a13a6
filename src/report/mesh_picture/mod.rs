//! A deformed mesh in two dimensions with a scalar in colour: pressure, most of all.
//!
//! Colours are a bitmap painted through the elements' own quadratic map; element edges are drawn over it as the
//! quadratic curves that they are, boundaries and regions thicker. A scalar that is nowhere negative has one hue (pale
//! to dark red); one with both signs has two (blue below 0, red above), 0 in the middle.

mod edges;
mod paint;

use super::axes::{self, Axes, AxisName};
use super::raster::PictureError;
use super::svg::Svg;
use crate::mechanics::mesh::Mesh;

/// A scalar on a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MeshValues<'a> {
    /// One value for each element.
    Cell(&'a [f64]),
    /// One value for each node: continuous.
    Node(&'a [f64]),
    /// One value for each node of each element, in the order of [`Mesh::elements`]: jumps between elements are kept.
    ElementNode(&'a [f64]),
}

/// A body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshBody<'a> {
    /// Its mesh, in two dimensions.
    pub mesh: &'a Mesh,
    /// Displacement of each node, mm; empty: none.
    pub displacement_mm: &'a [[f64; 3]],
    /// What is coloured.
    pub values: MeshValues<'a>,
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshPicture<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// A line below the title.
    pub subtitle: &'a str,
    /// The bodies.
    pub bodies: Vec<MeshBody<'a>>,
    /// What the colour shows.
    pub values: AxisName<'a>,
    /// Values of the first and the last colour; absent: all but the lowest and the highest 0.5 % of the values, because
    /// pressure is singular at edges and corners.
    pub range: Option<[f64; 2]>,
    /// Name of the horizontal axis: x, or r.
    pub horizontal: &'a str,
    /// Whether the mesh is the right half of what is drawn.
    pub mirrored: bool,
    /// Least and greatest horizontal and vertical place shown, mm; absent: everything.
    pub view_mm: Option<[[f64; 2]; 2]>,
}

/// Most of the drawing, pixels.
const SIZE: [f64; 2] = [640.0, 560.0];
const CORNER: [f64; 2] = [86.0, 76.0];

/// Draws a deformed mesh as a self-contained SVG, both axes in one scale.
///
/// # Errors
/// Where a mesh is not in two dimensions, a list does not fit its mesh, or a number is not finite.
pub fn mesh_picture(picture: &MeshPicture) -> Result<String, PictureError> {
    let mut shapes = Vec::with_capacity(picture.bodies.len());
    for body in &picture.bodies {
        shapes.push(Shape::new(body)?);
    }
    let axes = axes_of(picture, &shapes)?;
    let colors = Colors::choose(picture, &shapes)?;
    let [left, top, width, height] = axes.area;
    let bar_height = height.max(160.0);
    let size = [left + width + 124.0, top + bar_height + 60.0];
    let mut svg = Svg::new(size[0].max(480.0), size[1], picture.title, picture.subtitle);
    let sides: &[f64] = if picture.mirrored { &[1.0, -1.0] } else { &[1.0] };
    svg.clip(axes.area);
    paint::values(&mut svg, &axes, &shapes, sides, &colors)?;
    for shape in &shapes {
        edges::draw(&mut svg, &axes, shape, sides);
    }
    svg.end_clip();
    let millimetres = |quantity| AxisName { quantity, unit: "mm" };
    axes.scales(&mut svg, millimetres(picture.horizontal), millimetres("z"));
    // The pointed ends take 12 pixels.
    let bar = [left + width + 24.0, top + 12.0, 18.0, bar_height - 24.0];
    axes::color_bar(&mut svg, bar, [colors.low, colors.high], &|s| colors.at_share(s), picture.values, colors.beyond)?;
    Ok(svg.finish())
}

/// A body as it is drawn.
struct Shape<'a> {
    mesh: &'a Mesh,
    /// Deformed places (x or r, z), mm.
    places: Vec<[f64; 2]>,
    /// The scalar at the nodes of the elements, nine each.
    values: Vec<f64>,
}

impl<'a> Shape<'a> {
    fn new(body: &MeshBody<'a>) -> Result<Self, PictureError> {
        let mesh = body.mesh;
        let number = |what, value: usize, allowed| PictureError::Number { what, value: value as f64, allowed };
        if mesh.dim != 2 || mesh.elements.len() != 9 * mesh.element_count() {
            return Err(number("dimension of a drawn mesh", mesh.dim, "2, with 9 nodes to an element"));
        }
        if let Some(&node) = mesh.elements.iter().find(|&&n| n as usize >= mesh.nodes.len()) {
            return Err(number("a node of an element", node as usize, "one that the mesh has"));
        }
        let displaced = body.displacement_mm.len();
        if displaced != 0 && displaced != mesh.nodes.len() {
            return Err(number("number of displacements", displaced, "that of the nodes"));
        }
        let still = [0.0; 3];
        let moved = mesh.nodes.iter().enumerate().map(|(i, node)| {
            let u = body.displacement_mm.get(i).unwrap_or(&still);
            [node[0] + u[0], node[1] + u[1]]
        });
        let places: Vec<[f64; 2]> = moved.collect();
        let (values, given, needed): (Vec<f64>, usize, usize) = match body.values {
            MeshValues::Cell(v) => (v.iter().flat_map(|&v| [v; 9]).collect(), v.len(), mesh.element_count()),
            MeshValues::Node(v) => {
                let value = |&n: &u32| v.get(n as usize).copied().unwrap_or(f64::NAN);
                (mesh.elements.iter().map(value).collect(), v.len(), mesh.nodes.len())
            }
            MeshValues::ElementNode(v) => (v.to_vec(), v.len(), mesh.elements.len()),
        };
        if given != needed {
            return Err(number("number of values on a mesh", given, "that of its elements, nodes, or elements' nodes"));
        }
        axes::check("a place or value of a mesh", places.as_flattened().iter().chain(&values).copied())?;
        Ok(Self { mesh, places, values })
    }

    /// Places of an element's nodes, nine.
    fn element(&self, e: usize) -> [[f64; 2]; 9] {
        let mut nodes = [[0.0; 2]; 9];
        for (place, &node) in nodes.iter_mut().zip(self.mesh.element(e)) {
            *place = self.places[node as usize];
        }
        nodes
    }
}

/// The view in one scale for both axes.
fn axes_of(picture: &MeshPicture, shapes: &[Shape]) -> Result<Axes, PictureError> {
    let extent = |axis: usize| {
        let all = shapes.iter().flat_map(|s| &s.places).map(|p| p[axis]);
        let [low, high] = axes::range(all).unwrap_or([0.0, 1.0]);
        let [low, high] = if axis == 0 && picture.mirrored { [-high, high] } else { [low, high] };
        let [low, high] = axes::widened(low, high);
        // Room for the thick lines at the edge.
        [low - 0.01 * (high - low), high + 0.01 * (high - low)]
    };
    let [x, z] = picture.view_mm.unwrap_or([extent(0), extent(1)]);
    axes::check("the view of a mesh", x.into_iter().chain(z))?;
    let (wide, high) = (x[1] - x[0], z[1] - z[0]);
    if !(wide > 0.0 && high > 0.0) {
        return Err(PictureError::Number { what: "size of the view, mm", value: wide.min(high), allowed: "above 0" });
    }
    let scale = (SIZE[0] / wide).min(SIZE[1] / high);
    let area = [CORNER[0], CORNER[1], (wide * scale).max(4.0), (high * scale).max(4.0)];
    Ok(Axes { area, low: [x[0], z[0]], high: [x[1], z[1]] })
}

/// From values to colours.
struct Colors {
    low: f64,
    high: f64,
    /// Whether values lie below `low` and above `high`.
    beyond: [bool; 2],
}

/// Steps of colour: more than an eye separates side by side, few enough for a small bitmap.
const STEPS: f64 = 160.0;

impl Colors {
    fn choose(picture: &MeshPicture, shapes: &[Shape]) -> Result<Self, PictureError> {
        let mut sorted: Vec<f64> = shapes.iter().flat_map(|s| &s.values).copied().collect();
        sorted.sort_by(f64::total_cmp);
        let pick = |i: usize| sorted.get(i).copied().unwrap_or(0.0);
        let cut = sorted.len() / 200;
        let [mut low, mut high] = match picture.range {
            Some(range) => range,
            // 0 belongs to the scale of a pressure.
            None => [pick(cut).min(0.0), pick(sorted.len().saturating_sub(1 + cut)).max(0.0)],
        };
        axes::check("an end of the colour scale", [low, high])?;
        if picture.range.is_none() && low < 0.0 {
            // A trace of tension beside much pressure, or the reverse, does not deserve half of the colours.
            match low.abs() / high.max(f64::MIN_POSITIVE) {
                share if share < 0.02 => low = 0.0,
                _ => (low, high) = (-high.max(-low), high.max(-low)),
            }
        }
        if high <= low {
            high = low + low.abs().max(1.0);
        }
        let beyond = [pick(0) < low, pick(sorted.len().saturating_sub(1)) > high];
        Ok(Self { low, high, beyond })
    }

    fn at_share(&self, share: f64) -> [u8; 3] {
        let stepped = ((share.clamp(0.0, 1.0) * STEPS).floor() / (STEPS - 1.0)).min(1.0);
        let color = if self.low < 0.0 {
            // Blue to red; the map's own order is red to blue.
            colorous::RED_BLUE.eval_continuous(1.0 - stepped)
        } else {
            colorous::YELLOW_ORANGE_RED.eval_continuous(stepped)
        };
        [color.r, color.g, color.b]
    }

    fn at(&self, value: f64) -> [u8; 3] {
        self.at_share((value - self.low) / (self.high - self.low))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
