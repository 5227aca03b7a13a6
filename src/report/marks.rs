//! What was measured, drawn on the image that it was measured on: the outline of the lit pixels, and their centroid.

use super::raster::Raster;
use super::svg::{Anchor, Svg};

/// What is drawn on an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marks {
    /// Pixels above this are lit, in the unit of the image.
    pub threshold: f64,
    /// Centroid (column, row), pixels from the upper left corner; none where it is undefined.
    pub centroid_px: Option<[f64; 2]>,
}

/// Height that the legend takes below a picture, pixels.
pub(super) const LEGEND_PX: f64 = 24.0;
/// Most columns and rows of the outline: of larger images it is that of means over blocks, so that noise at the
/// threshold cannot fill megabytes.
const OUTLINE: [usize; 2] = [400, 300];
/// Told apart from every colour of the map, on dark and on light.
const OUTLINE_STROKE: &str = r##"fill="none" stroke="#39d3ff" stroke-width="1.2""##;
const CROSS_STROKE: &str = r##"fill="none" stroke="#ffffff" stroke-width="1.6""##;
const CROSS_EDGE: &str = r##"fill="none" stroke="#000000" stroke-width="3.4" stroke-opacity="0.55""##;
const CROSS_PX: f64 = 8.0;

/// Draws the marks on an image that fills the rectangle x, y, width, height, and what they mean at `legend_y`.
pub(super) fn draw(svg: &mut Svg, [x, y, w, h]: [f64; 4], raster: &Raster, marks: &Marks, legend_y: f64) {
    svg.commands(&outline([x, y, w, h], raster, marks.threshold), OUTLINE_STROKE);
    let unit = if raster.unit.is_empty() { raster.quantity } else { raster.unit };
    let threshold = super::ticks::short(marks.threshold);
    svg.line([x, legend_y], [x + 26.0, legend_y], OUTLINE_STROKE);
    svg.text([x + 33.0, legend_y + 4.5], Anchor::Start, "tt-ink", &format!("above {unit} {threshold}"));
    if let Some([column, row]) = marks.centroid_px {
        cross(svg, [x + column / raster.width as f64 * w, y + row / raster.height as f64 * h]);
        cross(svg, [x + 210.0, legend_y]);
        svg.text([x + 225.0, legend_y + 4.5], Anchor::Start, "tt-ink", "centroid");
    }
}

fn cross(svg: &mut Svg, [x, y]: [f64; 2]) {
    for stroke in [CROSS_EDGE, CROSS_STROKE] {
        svg.line([x - CROSS_PX, y], [x + CROSS_PX, y], stroke);
        svg.line([x, y - CROSS_PX], [x, y + CROSS_PX], stroke);
    }
}

/// The edges between lit pixels and others, and where lit ones end with the image, as SVG commands.
fn outline([x, y, w, h]: [f64; 4], raster: &Raster, threshold: f64) -> String {
    let blocks = raster.blocks(OUTLINE[0], OUTLINE[1]);
    let lit = |column: usize, row: usize| {
        let inside = column < blocks.width && row < blocks.height;
        inside && blocks.values.get(row * blocks.width + column).is_some_and(|&value| value > threshold)
    };
    let [step_x, step_y] = [w / blocks.width as f64, h / blocks.height as f64];
    let mut commands = String::new();
    // Along each line between rows, and between columns: runs of edges are one stroke.
    for row in 0..=blocks.height {
        let edge = |column: usize| lit(column, row) != (row > 0 && lit(column, row - 1));
        for [from, to] in runs(blocks.width, edge) {
            let (from, to, at) = (x + from as f64 * step_x, x + to as f64 * step_x, y + row as f64 * step_y);
            commands.push_str(&format!("M{from:.1} {at:.1}H{to:.1}"));
        }
    }
    for column in 0..=blocks.width {
        let edge = |row: usize| lit(column, row) != (column > 0 && lit(column - 1, row));
        for [from, to] in runs(blocks.height, edge) {
            let (from, to, at) = (y + from as f64 * step_y, y + to as f64 * step_y, x + column as f64 * step_x);
            commands.push_str(&format!("M{at:.1} {from:.1}V{to:.1}"));
        }
    }
    commands
}

/// Runs of places from 0 to `count` where `edge` holds: first place and the one after the last.
fn runs(count: usize, edge: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for place in (0..count).filter(|&place| edge(place)) {
        match runs.last_mut() {
            Some(run) if run[1] == place => run[1] = place + 1,
            _ => runs.push([place, place + 1]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outline_runs_around_what_is_above_the_threshold() {
        // Two pixels side by side are lit, the right one at the image's edge.
        let values = [0.0, 0.0, 0.0, 0.0, 9.0, 5.1, 5.0, 0.0, 0.0];
        let raster =
            Raster { width: 3, height: 3, values: &values, quantity: "grey level", unit: "", mm_per_pixel: None };
        let drawn = outline([0.0, 0.0, 30.0, 30.0], &raster, 5.0);
        assert_eq!(drawn, "M10.0 10.0H30.0M10.0 20.0H30.0M10.0 10.0V20.0M30.0 10.0V20.0");
        assert_eq!(outline([0.0, 0.0, 30.0, 30.0], &raster, 9.0), "");
    }
}
