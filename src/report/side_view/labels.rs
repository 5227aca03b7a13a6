//! The words: names of the layers, legend, scale.

use super::super::svg::{Anchor, Svg, text_width};
use super::super::ticks;
use super::stack::{LED_FILL, TISSUE_FILL, stroke};
use super::{CAMERA_PX, Fate, Frame, LED_PX, SideLayer, SideView};

/// Distance of two labels, pixels: two lines of text.
const ROW_PX: f64 = 36.0;
/// Most letters of a layer's name: a margin wider than that leaves no room for the drawing.
const NAME_LETTERS: usize = 26;

/// Width of the margin that holds the layers' names, pixels.
pub(super) fn margin_px(view: &SideView) -> f64 {
    let text = |layer: &SideLayer| text_width(&name(layer)).max(text_width(&figures(view, layer)));
    view.layers.iter().map(text).fold(40.0, f64::max)
}

/// Names beside the layers, moved apart where layers are thin, with lines that lead to them.
pub(super) fn layers(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let edge = |interface: &Vec<[f64; 2]>| interface.last().map_or(0.0, |p| p[1]);
    let middle = |faces: &[Vec<[f64; 2]>]| 0.5 * faces.iter().map(edge).sum::<f64>();
    let middles: Vec<f64> = view.interfaces_mm.windows(2).map(|f| frame.at([0.0, middle(f)])[1]).collect();
    let wall = frame.at([view.half_width_mm, 0.0])[0];
    let x = frame.right + LED_PX + 26.0;
    let places = spread(&middles, ROW_PX, frame.top + 12.0);
    for ((layer, &middle), y) in view.layers.iter().zip(&middles).zip(places) {
        let leader = [[wall - 7.0, middle], [wall + LED_PX + 8.0, middle], [x - 10.0, y], [x - 5.0, y]];
        svg.path(&leader, false, r#"class="tt-hair" stroke-width="1.2""#);
        let dot = r##"stroke="#3b5b7a" stroke-width="4" stroke-linecap="round""##;
        svg.line([wall - 7.0, middle], [wall - 7.5, middle], dot);
        svg.text([x, y - 2.0], Anchor::Start, "tt-ink", &name(layer));
        svg.text([x, y + 14.0], Anchor::Start, "tt-muted", &figures(view, layer));
    }
}

/// What lies around the stack, said below it.
pub(super) fn surround(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let text = format!("surround, n {:.*}", decimals(view), view.surround_n);
    svg.text([frame.left, frame.origin[1] + 22.0], Anchor::Start, "tt-muted", &text);
}

fn figures(view: &SideView, layer: &SideLayer) -> String {
    format!("n {:.*} · {} mm", decimals(view), layer.n, ticks::short(layer.thickness_mm))
}

/// Decimals that tell the indices apart: 2 to 6.
fn decimals(view: &SideView) -> usize {
    let exact = |n: f64, places: usize| (n * 10f64.powi(places as i32)).fract().abs().min(1.0);
    let whole = |n: f64, places: usize| {
        let rest = exact(n, places);
        rest.min(1.0 - rest) < 1e-6
    };
    (2..6).find(|&places| view.layers.iter().all(|layer| whole(layer.n, places))).unwrap_or(6)
}

/// A name that fits the margin.
fn name(layer: &SideLayer) -> String {
    if layer.name.chars().count() <= NAME_LETTERS {
        return layer.name.clone();
    }
    layer.name.chars().take(NAME_LETTERS - 1).chain(std::iter::once('…')).collect()
}

/// Moves positions (rising) at least `gap` apart, keeping clusters about their wished places but below `top`.
pub(super) fn spread(wished: &[f64], gap: f64, top: f64) -> Vec<f64> {
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
            cluster = (last.0 + cluster.0 - gap * (last.1 * cluster.1) as f64, last.1 + cluster.1);
        }
        clusters.push(cluster);
    }
    clusters.into_iter().flat_map(|c| (0..c.1).map(move |i| start(c) + gap * i as f64)).collect()
}

pub(super) fn scale_bar(svg: &mut Svg, view: &SideView, frame: &Frame) {
    let length = ticks::round_length(0.5 * view.half_width_mm);
    let (x, y) = (24.0, frame.bottom + CAMERA_PX + 14.0);
    svg.scale_bar([x, y], length * frame.scale, &format!("{} mm, both axes", ticks::short(length)));
}

/// An entry of the legend.
pub(super) struct Entry {
    /// SVG attributes of its line, or of its box.
    mark: Result<String, String>,
    text: String,
}

impl Entry {
    fn width(&self) -> f64 {
        58.0 + text_width(&self.text)
    }
}

/// The entries for what is drawn, in rows that fit the width.
pub(super) fn legend_rows(view: &SideView, width: f64) -> Vec<Vec<Entry>> {
    let mut rows: Vec<Vec<Entry>> = Vec::new();
    let mut used = f64::INFINITY;
    for entry in legend(view) {
        if used + entry.width() > width {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += entry.width();
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    rows
}

fn legend(view: &SideView) -> Vec<Entry> {
    let ray = |fate: Fate| {
        let count = view.rays.iter().filter(|ray| ray.fate == fate).count();
        let (color, dashes, name) = fate.look();
        (count > 0).then(|| Entry { mark: Ok(stroke(color, dashes)), text: format!("{name} ({count})") })
    };
    let filled = |present: bool, fill: &str, text: &str| {
        present.then(|| Entry { mark: Err(fill.to_owned()), text: text.to_owned() })
    };
    let boxes = [
        filled(!view.leds.is_empty(), LED_FILL, "LED"),
        filled(!view.contact_mm.is_empty(), TISSUE_FILL, "tissue in contact"),
    ];
    Fate::ALL.into_iter().map(ray).chain(boxes).flatten().collect()
}

pub(super) fn draw_legend(svg: &mut Svg, rows: &[Vec<Entry>], top: f64) {
    for (i, row) in rows.iter().enumerate() {
        let y = top + 22.0 * i as f64;
        let mut x = 24.0;
        for entry in row {
            match &entry.mark {
                Ok(line) => svg.line([x, y], [x + 26.0, y], &format!(r#"stroke-width="2.4" {line}"#)),
                Err(fill) => svg.rect([x + 7.0, y - 6.0, 12.0, 12.0], &format!(r#"rx="2" {fill}"#)),
            }
            svg.text([x + 33.0, y + 4.5], Anchor::Start, "tt-ink", &entry.text);
            x += entry.width();
        }
    }
}
