//! Points with error bars and lines over two logarithmic axes, such as error against run time.

use super::axes::{self, Axes, AxisName, CURVE_COLORS, Key, Mark};
use super::raster::PictureError;
use super::svg::{Anchor, Svg, text_width};
use super::ticks;

/// A point. One whose value is not above 0 is drawn at the upper end of its bar, with an arrow down: it is somewhere
/// below.
#[derive(Debug, Clone, PartialEq)]
pub struct LogPoint {
    /// Where it is.
    pub at: [f64; 2],
    /// Ends of its error bar; a lower end of 0 or less runs out of the picture.
    pub bar: Option<[f64; 2]>,
    /// Words beside it; empty: none.
    pub label: String,
    /// Boxed, such as the point of the default settings.
    pub marked: bool,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogStyle {
    /// Dots with error bars.
    Points,
    /// Dots joined by a line.
    Joined,
    /// A line.
    Line,
    /// A dashed line, such as for a theoretical slope.
    Dashed,
}

/// One series.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSeries {
    /// Its name in the legend.
    pub name: String,
    /// Its points; those without a place on logarithmic axes are left out.
    pub points: Vec<LogPoint>,
    /// How it is drawn.
    pub style: LogStyle,
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct LogPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// A line below the title.
    pub subtitle: &'a str,
    /// The horizontal axis.
    pub x: AxisName<'a>,
    /// The vertical axis.
    pub y: AxisName<'a>,
    /// What the boxes mean; empty: there are none.
    pub mark: &'a str,
    /// The series.
    pub series: Vec<LogSeries>,
}

/// Size of the plot, pixels, and its upper left corner.
const SIZE: [f64; 2] = [600.0, 380.0];
const CORNER: [f64; 2] = [92.0, 76.0];
/// Look of the box around a marked point.
const BOX: &str = r#"class="tt-line" stroke-width="1.6""#;

impl LogPoint {
    /// A point without bar, words and box.
    pub fn plain(at: [f64; 2]) -> Self {
        Self { at, bar: None, label: String::new(), marked: false }
    }

    /// Where it is drawn, and whether as an upper limit.
    fn shown(&self) -> Option<([f64; 2], bool)> {
        let [x, y] = self.at;
        let limit = y <= 0.0;
        let y = if limit { self.bar?[1] } else { y };
        (x > 0.0 && y > 0.0).then_some(([x, y], limit))
    }
}

/// Draws series over logarithmic axes as a self-contained SVG.
///
/// # Errors
/// Where a number is not finite.
pub fn log_plot(plot: &LogPlot) -> Result<String, PictureError> {
    let all = || plot.series.iter().flat_map(|s| &s.points);
    axes::check("a point", all().flat_map(|p| p.at.into_iter().chain(p.bar.into_iter().flatten())))?;
    let points = || all().filter_map(LogPoint::shown).map(|(at, _)| at);
    let bars = all().filter(|p| p.shown().is_some()).filter_map(|p| p.bar).flatten().filter(|v| *v > 0.0);
    let x = span(points().map(|at| at[0]));
    // A bar that ends near 0 would stretch the picture: two decades below the lowest point are enough.
    let floor = points().map(|at| at[1]).fold(f64::INFINITY, f64::min) * 0.1;
    let y = span(points().map(|at| at[1]).chain(bars.filter(|v| *v >= floor)));
    let axes = Axes { area: [CORNER[0], CORNER[1], SIZE[0], SIZE[1]], low: [x[0], y[0]], high: [x[1], y[1]] };
    let keys = keys(plot);
    let legend_top = CORNER[1] + SIZE[1] + 68.0;
    let height = legend_top + axes::legend_height(&keys, SIZE[0]);
    let mut svg = Svg::new(CORNER[0] + SIZE[0] + 40.0, height, plot.title, plot.subtitle);
    grid(&mut svg, &axes);
    svg.clip(axes.area);
    for (i, series) in plot.series.iter().enumerate() {
        draw(&mut svg, &axes, series, CURVE_COLORS[i % CURVE_COLORS.len()]);
    }
    svg.end_clip();
    labels(&mut svg, &axes, plot);
    scales(&mut svg, &axes, plot);
    axes::legend(&mut svg, &keys, [CORNER[0], legend_top], SIZE[0]);
    Ok(svg.finish())
}

/// Range of decimal logarithms with a little room.
fn span(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] = axes::range(values.map(f64::log10)).unwrap_or([-1.0, 0.0]);
    let room = (0.06 * (high - low)).max(0.15);
    [low - room, high + room]
}

fn place(axes: &Axes, [x, y]: [f64; 2]) -> [f64; 2] {
    axes.at([x.log10(), y.log10()])
}

fn draw(svg: &mut Svg, axes: &Axes, series: &LogSeries, color: &str) {
    let points: Vec<(&LogPoint, [f64; 2], bool)> =
        series.points.iter().filter_map(|p| p.shown().map(|(at, limit)| (p, place(axes, at), limit))).collect();
    let line: Vec<[f64; 2]> = points.iter().map(|(_, at, _)| *at).collect();
    if series.style != LogStyle::Points && line.len() > 1 {
        let dashes = if series.style == LogStyle::Dashed { r#" stroke-dasharray="7 4""# } else { "" };
        let look = format!(r#"fill="none" stroke="{color}" stroke-width="1.8" stroke-linejoin="round"{dashes}"#);
        svg.path(&line, false, &look);
    }
    if !matches!(series.style, LogStyle::Points | LogStyle::Joined) {
        return;
    }
    let bottom = 10f64.powf(axes.low[1]);
    for (point, [x, y], limit) in points {
        if limit {
            let down = y + 24.0;
            svg.commands(
                &format!("M{:.1} {y:.1}h12M{x:.1} {y:.1}V{down:.1}l-4 -6M{x:.1} {down:.1}l4 -6", x - 6.0),
                &format!(r#"fill="none" stroke="{color}" stroke-width="1.8""#),
            );
        } else if let Some([low, high]) = point.bar {
            let ends = [low.max(bottom * 1e-3), high].map(|v| place(axes, [point.at[0], v])[1]);
            svg.commands(
                &format!("M{x:.1} {:.1}V{:.1}M{:.1} {:.1}h8", ends[0], ends[1], x - 4.0, ends[1]),
                &format!(r#"fill="none" stroke="{color}" stroke-width="1.4""#),
            );
        }
        if !limit {
            dot(svg, [x, y], color, 7.0);
        }
        if point.marked {
            svg.rect([x - 9.0, y - 9.0, 18.0, 18.0], BOX);
        }
    }
}

fn dot(svg: &mut Svg, [x, y]: [f64; 2], color: &str, width: f64) {
    let look = format!(r#"fill="none" stroke="{color}" stroke-width="{width}" stroke-linecap="round""#);
    svg.commands(&format!("M{x:.1} {y:.1}h0"), &look);
}

/// Words beside points, each only where it meets no earlier one.
fn labels(svg: &mut Svg, axes: &Axes, plot: &LogPlot) {
    let mut taken: Vec<[f64; 4]> = Vec::new();
    let named = plot.series.iter().flat_map(|s| &s.points).filter(|p| !p.label.is_empty());
    for (point, at) in named.filter_map(|p| p.shown().map(|(at, _)| (p, at))) {
        let [x, y] = place(axes, at);
        let width = text_width(&point.label);
        let (anchor, left) = if x + width + 12.0 > CORNER[0] + SIZE[0] {
            (Anchor::End, x - 12.0 - width)
        } else {
            (Anchor::Start, x + 12.0)
        };
        let meets = |top: f64| {
            let apart = |b: &[f64; 4]| left > b[1] || left + width < b[0] || top > b[3] || top + 14.0 < b[2];
            !taken.iter().all(apart)
        };
        let Some(top) = [y - 18.0, y + 4.0, y - 32.0].into_iter().find(|&top| !meets(top)) else { continue };
        taken.push([left, left + width, top, top + 14.0]);
        let at = [if anchor == Anchor::End { left + width } else { left }, top + 11.0];
        svg.text(at, anchor, "tt-muted", &point.label);
    }
}

fn marks(axes: &Axes, axis: usize) -> Vec<(f64, String)> {
    ticks::logarithmic(10f64.powf(axes.low[axis]), 10f64.powf(axes.high[axis]))
}

fn grid(svg: &mut Svg, axes: &Axes) {
    let [left, top, width, height] = axes.area;
    for (value, _) in marks(axes, 0) {
        let x = axes.at([value.log10(), axes.low[1]])[0];
        svg.line([x, top], [x, top + height], r#"class="tt-hair""#);
    }
    for (value, _) in marks(axes, 1) {
        let y = axes.at([axes.low[0], value.log10()])[1];
        svg.line([left, y], [left + width, y], r#"class="tt-hair""#);
    }
}

fn scales(svg: &mut Svg, axes: &Axes, plot: &LogPlot) {
    let [left, top, width, height] = axes.area;
    let bottom = top + height;
    let line = r#"class="tt-line" stroke-width="1.2""#;
    svg.path(&[[left, top], [left, bottom], [left + width, bottom]], false, line);
    // Labels that would touch the one before are left out.
    let mut free = f64::NEG_INFINITY;
    for (value, label) in marks(axes, 0) {
        let x = axes.at([value.log10(), axes.low[1]])[0];
        svg.line([x, bottom], [x, bottom + 5.0], r#"class="tt-line""#);
        let half = 0.5 * text_width(&label);
        if x - half > free {
            svg.text([x, bottom + 19.0], Anchor::Middle, "tt-ink", &label);
            free = x + half + 6.0;
        }
    }
    svg.text([left + 0.5 * width, bottom + 40.0], Anchor::Middle, "tt-muted", &plot.x.label(0));
    let mut free = f64::INFINITY;
    for (value, label) in marks(axes, 1) {
        let y = axes.at([axes.low[0], value.log10()])[1];
        svg.line([left - 5.0, y], [left, y], r#"class="tt-line""#);
        if y < free {
            svg.text([left - 9.0, y + 4.5], Anchor::End, "tt-ink", &label);
            free = y - 16.0;
        }
    }
    svg.text_upward([left - 72.0, top + 0.5 * height], "tt-muted", &plot.y.label(0));
}

fn keys(plot: &LogPlot) -> Vec<Key> {
    let key = |(i, series): (usize, &LogSeries)| {
        let color = CURVE_COLORS[i % CURVE_COLORS.len()];
        let mark = match series.style {
            LogStyle::Points | LogStyle::Joined => {
                Mark::Dot(format!(r#"stroke="{color}" stroke-width="7" stroke-linecap="round""#))
            }
            LogStyle::Line => Mark::Line(format!(r#"stroke="{color}" stroke-width="1.8""#)),
            LogStyle::Dashed => Mark::Line(format!(r#"stroke="{color}" stroke-width="1.8" stroke-dasharray="7 4""#)),
        };
        Key { mark, text: series.name.clone() }
    };
    let named = plot.series.iter().enumerate().filter(|(_, s)| !s.name.is_empty());
    let mut keys: Vec<Key> = named.map(key).collect();
    if !plot.mark.is_empty() {
        keys.push(Key { mark: Mark::Box(BOX.into()), text: plot.mark.into() });
    }
    keys
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::svg::{assert_well_formed, keep_sample};
    use super::*;

    fn plot() -> LogPlot<'static> {
        let point = |k: i32| {
            let (x, y) = (4f64.powi(k), 0.3 * 0.5f64.powi(k));
            LogPoint { at: [x, y], bar: Some([0.8 * y, 1.2 * y]), label: format!("{} spp", 4 << k), marked: k == 2 }
        };
        let slope = [1.0, 256.0].map(|x: f64| LogPoint::plain([x, 0.3 / x.sqrt()]));
        LogPlot {
            title: "Error against run time",
            subtitle: "path, 48 x 36 pixels",
            x: AxisName { quantity: "tracing time", unit: "s" },
            y: AxisName { quantity: "relative error", unit: "" },
            mark: "default settings",
            series: vec![
                LogSeries { name: "path".into(), points: (0..5).map(point).collect(), style: LogStyle::Joined },
                LogSeries { name: "slope −1/2".into(), points: slope.to_vec(), style: LogStyle::Dashed },
            ],
        }
    }

    #[test]
    fn points_have_bars_words_and_boxes() {
        let svg = log_plot(&plot()).unwrap();
        assert_well_formed(&svg);
        for text in ["relative error", "tracing time (s)", "default settings", "path", "4 spp"] {
            assert!(svg.contains(&format!(">{text}<")), "{text}");
        }
        keep_sample("log_plot.svg", &svg);
    }

    #[test]
    fn nothing_zeros_and_bars_to_zero_are_drawn() {
        let mut plot = plot();
        let arrows = |plot: &LogPlot| log_plot(plot).unwrap().matches("l4 -6").count();
        assert_eq!(arrows(&plot), 0);
        plot.series[0].points[1].at[1] = 0.0;
        assert_eq!(arrows(&plot), 1);
        plot.series[0].points[2].bar = Some([-1.0, 1.0]);
        assert_well_formed(&log_plot(&plot).unwrap());
        plot.series.clear();
        assert_well_formed(&log_plot(&plot).unwrap());
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let mut plot = plot();
        plot.series[0].points[0].at[0] = f64::NAN;
        assert!(matches!(log_plot(&plot), Err(PictureError::Number { .. })));
    }
}
