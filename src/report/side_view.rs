//! The stack from the side (x to the right, z up): layers, LEDs, what touches, the camera's view, and rays.

use super::raster::PictureError;
use super::svg::{Anchor, Svg, text_width};
use super::ticks;

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
    /// Diameter, mm.
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
    const ALL: [Self; 5] = [
        Self::Guided,
        Self::Scattered,
        Self::EscapedBottom,
        Self::EscapedTop,
        Self::Absorbed,
    ];

    /// Colour (from the Okabe-Ito set, told apart without colour vision), dashes, and name.
    fn look(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Guided => ("#0072b2", "", "guided"),
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

/// Height of the camera's symbol below the pinhole, and of the LEDs' beside the wall, pixels.
const CAMERA_PX: f64 = 34.0;
const LED_PX: f64 = 16.0;
const DRAWING: [f64; 2] = [580.0, 620.0];
const LABEL_PX: f64 = 190.0;

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
        let widest = view
            .leds
            .iter()
            .map(|led| led.x_mm.abs())
            .fold(view.half_width_mm, f64::max);
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
        [
            self.origin[0] + x * self.scale,
            self.origin[1] - z * self.scale,
        ]
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
    let width = frame.right + LED_PX + 24.0 + LABEL_PX;
    let legend = legend_rows(view, width - 48.0);
    let legend_top = frame.bottom + CAMERA_PX + 44.0;
    let mut svg = Svg::new(
        width,
        legend_top + 22.0 * legend.len() as f64 + 8.0,
        &view.title,
        &view.subtitle,
    );
    bands(&mut svg, view, &frame);
    field_of_view(&mut svg, view, &frame);
    tissue(&mut svg, view, &frame);
    rays(&mut svg, view, &frame);
    for interface in &view.interfaces_mm {
        svg.path(
            &frame.polyline(interface),
            false,
            r##"fill="none" stroke="#3b5b7a" stroke-width="1""##,
        );
    }
    leds(&mut svg, view, &frame);
    camera(&mut svg, view, &frame);
    layer_labels(&mut svg, view, &frame);
    scale_bar(&mut svg, view, &frame);
    draw_legend(&mut svg, &legend, legend_top);
    Ok(svg.finish())
}

fn check(view: &SideView) -> Result<(), PictureError> {
    let number = |what, value: f64, allowed| {
        Err(PictureError::Number {
            what,
            value,
            allowed,
        })
    };
    if !(view.half_width_mm > 0.0 && view.half_width_mm.is_finite()) {
        return number(
            "half width of the side view",
            view.half_width_mm,
            "finite and above 0",
        );
    }
    if view.interfaces_mm.len() != view.layers.len() + 1 {
        return number(
            "number of interfaces",
            view.interfaces_mm.len() as f64,
            "one more than that of layers",
        );
    }
    let planar = view
        .interfaces_mm
        .iter()
        .flatten()
        .chain(&view.view_edge_mm)
        .chain(&view.contact_mm)
        .flatten();
    let spatial = view.rays.iter().flat_map(|ray| &ray.points_mm).flatten();
    let leds = view
        .leds
        .iter()
        .flat_map(|led| [&led.x_mm, &led.z_mm, &led.diameter_mm]);
    match planar.chain(spatial).chain(leds).find(|v| !v.is_finite()) {
        Some(&value) => number("a coordinate of the side view", value, "finite"),
        None => Ok(()),
    }
}

/// The layers, deeper blue for a higher index.
fn bands(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let indices = view.layers.iter().map(|layer| layer.n);
    let (low, high) = indices.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), n| {
        (l.min(n), h.max(n))
    });
    for (layer, faces) in view.layers.iter().zip(view.interfaces_mm.windows(2)) {
        let [upper, lower] = faces else { continue };
        let share = if high > low {
            (layer.n - low) / (high - low)
        } else {
            0.5
        };
        let mix = |from: f64, to: f64| (from + share * (to - from)).round() as u8;
        let fill = [mix(234.0, 176.0), mix(243.0, 206.0), mix(251.0, 235.0)];
        let mut outline = frame.polyline(upper);
        outline.extend(frame.polyline(lower).into_iter().rev());
        let [r, g, b] = fill;
        svg.path(
            &outline,
            true,
            &format!(r##"fill="#{r:02x}{g:02x}{b:02x}""##),
        );
    }
}

fn field_of_view(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let right = frame.polyline(&view.view_edge_mm);
    let left: Vec<[f64; 2]> = view
        .view_edge_mm
        .iter()
        .map(|&[x, z]| frame.at([-x, z]))
        .collect();
    let outline: Vec<_> = right.iter().chain(left.iter().rev()).copied().collect();
    svg.path(&outline, true, r##"fill="#e3b341" fill-opacity="0.16""##);
    for edge in [&right, &left] {
        svg.path(
            edge,
            false,
            r##"fill="none" stroke="#9a6700" stroke-dasharray="5 4" stroke-opacity="0.8""##,
        );
    }
}

fn tissue(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let Some(face) = view.interfaces_mm.first() else {
        return;
    };
    let top =
        face.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max) + 0.12 * view.half_width_mm;
    for &[from, to] in &view.contact_mm {
        let mut outline = vec![[from, top], [from, height_at(face, from)]];
        outline.extend(face.iter().filter(|p| p[0] > from && p[0] < to));
        outline.extend([[to, height_at(face, to)], [to, top]]);
        let drawn = frame.polyline(&outline);
        svg.path(&drawn, true, r##"fill="#e9b8a6""##);
        let contact = drawn.get(1..drawn.len() - 1).unwrap_or_default();
        svg.path(
            contact,
            false,
            r##"fill="none" stroke="#a0402a" stroke-width="3""##,
        );
        let [x, y] = frame.at([0.5 * (from + to), top]);
        if (to - from) * frame.scale > text_width("tissue") + 8.0 {
            svg.text_with(
                [x, y + 16.0],
                Anchor::Middle,
                r##"fill="#6b2a1a""##,
                "tissue",
            );
        }
    }
}

/// Height of a polyline at x, linear between its points.
fn height_at(face: &[[f64; 2]], x: f64) -> f64 {
    let piece = face.windows(2).find_map(|pair| match pair {
        [a, b] if (a[0]..=b[0]).contains(&x) && b[0] > a[0] => {
            Some(a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]))
        }
        _ => None,
    });
    piece.or(face.first().map(|p| p[1])).unwrap_or(0.0)
}

fn rays(svg: &mut Svg, view: &SideView, frame: &Frame) {
    // Many rays are drawn thinner so that they remain lines.
    let width = if view.rays.len() > 24 { 0.8 } else { 1.4 };
    svg.group(&format!(
        r#"fill="none" stroke-linejoin="round" stroke-width="{width}" stroke-opacity="0.85""#
    ));
    for ray in &view.rays {
        let points: Vec<[f64; 2]> = ray
            .points_mm
            .iter()
            .map(|&[x, _, z]| frame.at([x, z]))
            .collect();
        let (color, dashes, _) = ray.fate.look();
        svg.path(&points, false, &stroke(color, dashes));
    }
    svg.end_group();
}

fn stroke(color: &str, dashes: &str) -> String {
    if dashes.is_empty() {
        format!(r#"stroke="{color}""#)
    } else {
        format!(r#"stroke="{color}" stroke-dasharray="{dashes}""#)
    }
}

fn leds(svg: &mut Svg, view: &SideView, frame: &Frame) {
    for led in &view.leds {
        let [x, top] = frame.at([led.x_mm, led.z_mm + 0.5 * led.diameter_mm]);
        let height = led.diameter_mm * frame.scale;
        let left = if led.x_mm < 0.0 { x - LED_PX } else { x };
        svg.rect(
            [left, top, LED_PX, height],
            r##"rx="3" fill="#2da44e" stroke="#116329" stroke-width="1""##,
        );
        let text = [left + 0.5 * LED_PX, top - 6.0];
        svg.text_with(
            text,
            Anchor::Middle,
            r#"class="tt-ink" font-size="11""#,
            "LED",
        );
    }
}

fn camera(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let Some(&pinhole) = view.view_edge_mm.first() else {
        return;
    };
    let [x, y] = frame.at(pinhole);
    svg.path(
        &[[x, y], [x - 12.0, y + 12.0], [x + 12.0, y + 12.0]],
        true,
        r##"fill="#57606a""##,
    );
    svg.rect(
        [x - 22.0, y + 12.0, 44.0, CAMERA_PX - 12.0],
        r##"rx="4" fill="#57606a""##,
    );
    svg.text([x + 32.0, y + 27.0], Anchor::Start, "tt-ink", "camera");
    svg.text(
        [frame.left, frame.origin[1] + 22.0],
        Anchor::Start,
        "tt-muted",
        &surround(view),
    );
}

fn surround(view: &SideView) -> String {
    format!("surround, n {}", index(view.surround_n))
}

/// A refractive index with the digits that tell layers apart.
fn index(n: f64) -> String {
    let text = format!("{n:.4}");
    let text = text.trim_end_matches('0');
    if text.ends_with('.') {
        format!("{text}00")
    } else {
        text.to_owned()
    }
}

/// Names beside the layers, moved apart where layers are thin, with lines that lead to them.
fn layer_labels(svg: &mut Svg, view: &SideView, frame: &Frame) {
    const ROW: f64 = 36.0;
    let edge = |interface: &Vec<[f64; 2]>| interface.last().map_or(0.0, |p| p[1]);
    let middles: Vec<f64> = view
        .interfaces_mm
        .windows(2)
        .map(|faces| frame.at([0.0, 0.5 * faces.iter().map(edge).sum::<f64>()])[1])
        .collect();
    let wall = frame.at([view.half_width_mm, 0.0])[0];
    let x = frame.right + LED_PX + 26.0;
    for ((layer, &middle), y) in
        view.layers
            .iter()
            .zip(&middles)
            .zip(spread(&middles, ROW, frame.top + 12.0))
    {
        svg.path(
            &[
                [wall - 7.0, middle],
                [wall + LED_PX + 8.0, middle],
                [x - 10.0, y],
                [x - 5.0, y],
            ],
            false,
            r#"class="tt-hair" stroke-width="1.2""#,
        );
        svg.path(
            &[[wall - 7.0, middle], [wall - 7.5, middle]],
            false,
            r##"stroke="#3b5b7a" stroke-width="4" stroke-linecap="round""##,
        );
        svg.text(
            [x, y - 2.0],
            Anchor::Start,
            "tt-ink",
            &shortened(&layer.name),
        );
        let figures = format!(
            "n {} · {} mm",
            index(layer.n),
            ticks::short(layer.thickness_mm)
        );
        svg.text([x, y + 14.0], Anchor::Start, "tt-muted", &figures);
    }
}

/// A name that fits the margin.
fn shortened(name: &str) -> String {
    let most = (LABEL_PX / 7.2) as usize - 2;
    if name.chars().count() <= most {
        return name.to_owned();
    }
    name.chars()
        .take(most - 1)
        .chain(std::iter::once('…'))
        .collect()
}

/// Moves positions (rising) at least `gap` apart, keeping clusters about their wished places but below `top`.
fn spread(wished: &[f64], gap: f64, top: f64) -> Vec<f64> {
    // Clusters of (sum of wished starts, members); a cluster's first label stands at the mean.
    let mut clusters: Vec<(f64, usize)> = Vec::new();
    let start = |(sum, count): (f64, usize)| (sum / count as f64).max(top);
    for &y in wished {
        let mut cluster = (y, 1);
        while let Some(&last) = clusters.last() {
            if start(last) + gap * last.1 as f64 <= start(cluster) {
                break;
            }
            clusters.pop();
            cluster = (
                last.0 + cluster.0 - gap * (last.1 * cluster.1) as f64,
                last.1 + cluster.1,
            );
        }
        clusters.push(cluster);
    }
    clusters
        .into_iter()
        .flat_map(|c| (0..c.1).map(move |i| start(c) + gap * i as f64))
        .collect()
}

fn scale_bar(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let length = ticks::round_length(0.5 * view.half_width_mm);
    let drawn = length * frame.scale;
    let (x, y) = (frame.left, frame.bottom + CAMERA_PX + 14.0);
    svg.path(
        &[[x, y - 5.0], [x, y + 5.0]],
        false,
        r#"class="tt-line" stroke-width="1.6""#,
    );
    svg.path(
        &[[x, y], [x + drawn, y]],
        false,
        r#"class="tt-line" stroke-width="1.6""#,
    );
    svg.path(
        &[[x + drawn, y - 5.0], [x + drawn, y + 5.0]],
        false,
        r#"class="tt-line" stroke-width="1.6""#,
    );
    let label = format!("{} mm, both axes", ticks::short(length));
    svg.text([x + drawn + 10.0, y + 4.5], Anchor::Start, "tt-ink", &label);
}

/// An entry of the legend: its colour, dashes and text.
type Entry = (&'static str, &'static str, String);

/// The fates that occur, in rows that fit the width.
fn legend_rows(view: &SideView, width: f64) -> Vec<Vec<Entry>> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    let mut used = f64::INFINITY;
    for fate in Fate::ALL {
        let count = view.rays.iter().filter(|ray| ray.fate == fate).count();
        if count == 0 {
            continue;
        }
        let (color, dashes, name) = fate.look();
        let entry = (color, dashes, format!("{name} ({count})"));
        let needed = entry_width(&entry);
        if used + needed > width {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += needed;
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    rows
}

fn entry_width(entry: &Entry) -> f64 {
    60.0 + text_width(&entry.2)
}

fn draw_legend(svg: &mut Svg, rows: &[Vec<Entry>], top: f64) {
    for (i, row) in rows.iter().enumerate() {
        let y = top + 22.0 * i as f64;
        let mut x = 24.0;
        for entry in row {
            let (color, dashes, text) = entry;
            svg.line(
                [x, y],
                [x + 26.0, y],
                &format!(r#"stroke-width="2.4" {}"#, stroke(color, dashes)),
            );
            svg.text([x + 33.0, y + 4.5], Anchor::Start, "tt-ink", text);
            x += entry_width(entry);
        }
    }
}

#[cfg(test)]
#[path = "side_view_tests.rs"]
mod tests;
