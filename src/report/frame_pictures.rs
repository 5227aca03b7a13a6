//! Pressure frames as a two-dimensional image, and one frame with its fit: figures 5 and 4 of Galea and Howe.

use super::axes::{self, Axes, AxisName, CURVE_COLORS, Key, Mark};
use super::curves::{CurveStyle, draw_curve};
use super::false_color;
use super::raster::PictureError;
use super::svg::{Anchor, Svg, text_width};
use super::ticks;
use crate::mechanics::frames::{Features, Frame, Frames};

/// Size of the plots, pixels.
const IMAGE: [f64; 2] = [480.0, 420.0];
const PLOT: [f64; 2] = [560.0, 340.0];
/// Pixels of the bitmap: a little more than a screen shows.
const BITMAP: [usize; 2] = [640, 560];
/// A frame of more places than this is a line: its dots would touch.
const MOST_DOTS: usize = 90;
/// Distance of two lines of text, pixels.
const LINE_PX: f64 = 17.0;
const PLACE: AxisName = AxisName { quantity: "place along the indenter", unit: "mm" };
const PRESSURE: AxisName = AxisName { quantity: "pressure", unit: "kPa" };

/// Draws frames in false colour as a self-contained SVG: each frame a horizontal stripe, positions upward. A frame
/// reaches halfway to its neighbours; along the indenter the pressure is linear between places. With `mark_inclusion` a
/// line shows where position 0 lies under the indenter.
///
/// # Errors
/// Where a number cannot be drawn.
pub fn frames_image(title: &str, frames: &Frames, mark_inclusion: bool) -> Result<String, PictureError> {
    let all = frames.as_slice();
    axes::check(
        "a number of the frames",
        all.iter().flat_map(|f| f.pressure_kpa.iter().copied().chain([f.position_mm])),
    )?;
    let places = all.first().map_or(&[][..], |f| &f.x_mm);
    axes::check("a place of the frames", places.iter().copied())?;
    let bounds = stripe_bounds(all);
    let (low, high) = (bounds.first().copied().unwrap_or(0.0), bounds.last().copied().unwrap_or(1.0));
    let [least, most] = axes::range(all.iter().flat_map(|f| f.pressure_kpa.iter().copied())).unwrap_or([0.0, 0.0]);
    let [least, most] = axes::widened(least.min(0.0), most.max(0.0));
    let axes = Axes {
        area: [86.0, 76.0, IMAGE[0], IMAGE[1]],
        low: [places.first().copied().unwrap_or(0.0), low],
        high: [places.last().copied().unwrap_or(1.0), high],
    };
    let mut subtitle = format!("{} frames of {} places · highest {} kPa", all.len(), places.len(), ticks::short(most));
    if mark_inclusion {
        subtitle.push_str(" · dotted: middle of the inclusion");
    }
    let mut svg = Svg::new(86.0 + IMAGE[0] + 120.0, 76.0 + IMAGE[1] + 60.0, title, &subtitle);
    let rgb = stripes(all, &axes, &bounds, [least, most]);
    svg.bitmap(axes.area, BITMAP[0], BITMAP[1], &rgb)?;
    if mark_inclusion {
        svg.clip(axes.area);
        // Under an indenter at position s, what lies at 0 is at -s.
        let line = axes.polyline(&[[-low, low], [-high, high]]);
        svg.path(
            &line,
            false,
            r##"fill="none" stroke="#ffffff" stroke-opacity="0.75" stroke-dasharray="2 5" stroke-width="1.4""##,
        );
        svg.end_clip();
    }
    axes.scales(&mut svg, PLACE, AxisName { quantity: "position of the indenter", unit: "mm" });
    let bar = [86.0 + IMAGE[0] + 22.0, 76.0, 18.0, IMAGE[1]];
    axes::color_bar(&mut svg, bar, [least, most], &false_color::color, PRESSURE, [false; 2])?;
    Ok(svg.finish())
}

/// Lower and upper bound of each frame's stripe: halfway to the neighbours, as far on the other side of the outermost.
fn stripe_bounds(frames: &[Frame]) -> Vec<f64> {
    let s: Vec<f64> = frames.iter().map(|f| f.position_mm).collect();
    let (Some(&first), Some(&last)) = (s.first(), s.last()) else {
        return Vec::new();
    };
    let between: Vec<f64> = s.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    let (lower, upper) = match (between.first(), between.last()) {
        (Some(b), Some(t)) => (2.0 * first - b, 2.0 * last - t),
        _ => (first - 0.5, last + 0.5),
    };
    [lower].into_iter().chain(between).chain([upper]).collect()
}

fn stripes(frames: &[Frame], axes: &Axes, bounds: &[f64], [least, most]: [f64; 2]) -> Vec<u8> {
    let [columns, rows] = BITMAP;
    let mut rgb = Vec::with_capacity(3 * columns * rows);
    for row in 0..rows {
        let position = axes.high[1] - (axes.high[1] - axes.low[1]) * (row as f64 + 0.5) / rows as f64;
        let stripe = bounds.partition_point(|&b| b <= position).saturating_sub(1).min(frames.len().saturating_sub(1));
        let Some(frame) = frames.get(stripe) else { continue };
        for column in 0..columns {
            let x = axes.low[0] + (axes.high[0] - axes.low[0]) * (column as f64 + 0.5) / columns as f64;
            rgb.extend(false_color::color((pressure_at(frame, x) - least) / (most - least)));
        }
    }
    rgb
}

/// Pressure at a place within the frame, linear between places.
fn pressure_at(frame: &Frame, x: f64) -> f64 {
    let right = frame.x_mm.partition_point(|&place| place < x).clamp(1, frame.x_mm.len() - 1);
    let (x0, x1) = (frame.x_mm[right - 1], frame.x_mm[right]);
    let (p0, p1) = (frame.pressure_kpa[right - 1], frame.pressure_kpa[right]);
    p0 + (p1 - p0) * (x - x0) / (x1 - x0)
}

/// One frame with what was read off it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePicture<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// The frame.
    pub frame: &'a Frame,
    /// What its eccentricity compares with, at the same places.
    pub reference: &'a Frame,
    /// Its features.
    pub features: &'a Features,
}

/// Draws a frame, its parabola, peak, base, width, and what the inclusion adds left and right of the centre, as a
/// self-contained SVG.
///
/// # Errors
/// Where a number cannot be drawn, or the reference has other places.
pub fn frame_picture(picture: &FramePicture) -> Result<String, PictureError> {
    let FramePicture { title, frame, reference, features } = *picture;
    let curves = [frame, reference].map(curve);
    axes::check("a number of the frame", curves.iter().flatten().flatten().copied())?;
    if frame.x_mm != reference.x_mm {
        let value = reference.x_mm.len() as f64;
        let allowed = "the same places as the frame's";
        return Err(PictureError::Number { what: "number of places of the reference", value, allowed });
    }
    let peak = features.peak_kpa.value().unwrap_or(0.0);
    let heights = curves.iter().flatten().map(|p| p[1]).chain([0.0, peak]);
    let [bottom, top] = axes::range(heights).map_or([0.0, 1.0], |[l, h]| axes::widened(l, h));
    let axes = Axes {
        area: [86.0, 76.0, PLOT[0], PLOT[1]],
        low: [frame.x_mm.first().copied().unwrap_or(0.0), bottom],
        // Room above the peak for its label.
        high: [frame.x_mm.last().copied().unwrap_or(1.0), top + 0.16 * (top - bottom)],
    };
    let style = if frame.x_mm.len() <= MOST_DOTS { CurveStyle::Points } else { CurveStyle::Line };
    let keys = keys(features, style);
    let legend_top = 76.0 + PLOT[1] + 68.0;
    let size = [86.0 + PLOT[0] + 110.0, legend_top + axes::legend_height(&keys, PLOT[0] + 80.0)];
    let mut svg = Svg::new(size[0], size[1], title, &subtitle(features));
    axes.grid(&mut svg);
    svg.clip(axes.area);
    shade(&mut svg, &axes, &curves);
    draw_curve(&mut svg, &axes.polyline(&curves[1]), CurveStyle::Dashed, CURVE_COLORS[5]);
    draw_curve(&mut svg, &axes.polyline(&curves[0]), style, CURVE_COLORS[0]);
    parabola(&mut svg, &axes, features);
    svg.end_clip();
    marks(&mut svg, &axes, features);
    axes.scales(&mut svg, PLACE, PRESSURE);
    axes::legend(&mut svg, &keys, [86.0, legend_top], PLOT[0] + 80.0);
    Ok(svg.finish())
}

fn curve(frame: &Frame) -> Vec<[f64; 2]> {
    frame.x_mm.iter().zip(&frame.pressure_kpa).map(|(&x, &p)| [x, p]).collect()
}

fn subtitle(features: &Features) -> String {
    let position = format!("indenter at {} mm", ticks::short(features.position_mm));
    let mut parts = vec![position];
    if let Some(fit) = features.parabola {
        let [from, to] = fit.window_mm.map(ticks::short);
        parts.push(format!("fit over {from} to {to} mm"));
    }
    if let Some(e) = features.eccentricity.value() {
        parts.push(format!("eccentricity {}", ticks::number(e, 3)));
    }
    parts.join(" · ")
}

const LEFT_FILL: &str = r##"fill="#aa4499" fill-opacity="0.22""##;
const RIGHT_FILL: &str = r##"fill="#b07d00" fill-opacity="0.26""##;

fn keys(features: &Features, style: CurveStyle) -> Vec<Key> {
    let key = |mark, text: &str| Key { mark, text: text.to_owned() };
    let line = |color: &str, more: &str| Mark::Line(format!(r#"stroke="{color}" stroke-width="2" {more}"#));
    let dot = format!(r#"stroke="{}" stroke-width="5" stroke-linecap="round""#, CURVE_COLORS[0]);
    let frame = if style == CurveStyle::Points { Mark::Dot(dot) } else { line(CURVE_COLORS[0], "") };
    let mut keys = vec![key(frame, "frame")];
    if features.parabola.is_some() {
        keys.push(key(line(CURVE_COLORS[1], ""), "fitted parabola"));
    }
    keys.push(key(line(CURVE_COLORS[5], r#"stroke-dasharray="7 4""#), "reference"));
    keys.push(key(Mark::Box(LEFT_FILL.to_owned()), "difference left"));
    keys.push(key(Mark::Box(RIGHT_FILL.to_owned()), "right"));
    keys
}

/// The area between frame and reference, left and right of the centre.
fn shade(svg: &mut Svg, axes: &Axes, [frame, reference]: &[Vec<[f64; 2]>; 2]) {
    for (side, fill) in [(-1.0, LEFT_FILL), (1.0, RIGHT_FILL)] {
        let outline = half(frame, side).into_iter().chain(half(reference, side).into_iter().rev());
        svg.path(&axes.polyline(&outline.collect::<Vec<_>>()), true, fill);
    }
}

/// The part of a curve on one side of x = 0, with a point there.
fn half(points: &[[f64; 2]], side: f64) -> Vec<[f64; 2]> {
    let crossing = points.windows(2).find(|p| p[0][0] < 0.0 && p[1][0] >= 0.0).map(|p| {
        let [[x0, p0], [x1, p1]] = [p[0], p[1]];
        [0.0, p0 + (p1 - p0) * -x0 / (x1 - x0)]
    });
    let mut kept: Vec<[f64; 2]> = points.iter().copied().filter(|p| side * p[0] > 0.0).collect();
    kept.extend(crossing);
    kept.sort_by(|a, b| a[0].total_cmp(&b[0]));
    kept
}

fn parabola(svg: &mut Svg, axes: &Axes, features: &Features) {
    let Some(fit) = features.parabola else { return };
    let [from, to] = fit.window_mm;
    let points: Vec<[f64; 2]> =
        (0..=80).map(|i| from + (to - from) * f64::from(i) / 80.0).map(|x| [x, fit.at(x)]).collect();
    draw_curve(svg, &axes.polyline(&points), CurveStyle::Line, CURVE_COLORS[1]);
}

/// Peak, base and width with their values: peak and base in the margin, where no curve is.
fn marks(svg: &mut Svg, axes: &Axes, features: &Features) {
    let ink = r#"class="tt-line" stroke-width="1.3""#;
    let dashed = r#"class="tt-line" stroke-width="1.3" stroke-dasharray="3 4""#;
    let figure = |name: &str, value: f64, unit: &str| format!("{name} {} {unit}", ticks::short(value));
    let [left, _, width, _] = axes.area;
    let base = features.base_kpa.value();
    if let Some(base) = base {
        let y = axes.at([0.0, base])[1];
        svg.line([left, y], [left + width, y], dashed);
        svg.text([left + width + 8.0, y + 4.5], Anchor::Start, "tt-ink", &figure("base", base, "kPa"));
    }
    let (Some(peak), Some(center)) = (features.peak_kpa.value(), features.center_mm.value()) else { return };
    let [x, y] = axes.at([center, peak]);
    svg.line([x, y], [left + width, y], dashed);
    svg.line([x, y], [x, y], &format!(r#"stroke="{}" stroke-width="9" stroke-linecap="round""#, CURVE_COLORS[1]));
    let lowest = base.map_or(f64::INFINITY, |base| axes.at([0.0, base])[1] - LINE_PX);
    svg.text([left + width + 8.0, y.min(lowest) + 4.5], Anchor::Start, "tt-ink", &figure("peak", peak, "kPa"));
    let Some(fwhm) = features.fwhm_mm.value() else { return };
    let level = 0.5 * peak;
    let (from, to) = (axes.at([center - 0.5 * fwhm, level]), axes.at([center + 0.5 * fwhm, level]));
    svg.line(from, to, ink);
    for ([x, y], inward) in [(from, 1.0), (to, -1.0)] {
        svg.path(&[[x + 9.0 * inward, y - 5.0], [x, y], [x + 9.0 * inward, y + 5.0]], false, ink);
    }
    let (middle, text) = (0.5 * (from[0] + to[0]), figure("FWHM", fwhm, "mm"));
    let wide = text_width(&text) + 12.0;
    svg.rect([middle - 0.5 * wide, from[1] - 22.0, wide, 18.0], r#"rx="4" class="tt-page" fill-opacity="0.8""#);
    svg.text([middle, from[1] - 8.0], Anchor::Middle, "tt-ink", &text);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
