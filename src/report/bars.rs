//! Bars with their intervals, one below the other.

use super::axes::{self, Axes, AxisName, CURVE_COLORS, Key, Mark};
use super::raster::PictureError;
use super::svg::{Anchor, Svg, text_width};

/// A value with the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// How long the bar is.
    pub value: f64,
    /// Its interval.
    pub interval: [f64; 2],
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct BarPlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// A line below the title.
    pub subtitle: &'a str,
    /// The horizontal axis.
    pub x: AxisName<'a>,
    /// What the bars of each row show.
    pub kinds: Vec<&'a str>,
    /// Rows: a name, and a bar of each kind.
    pub rows: Vec<(&'a str, Vec<Bar>)>,
}

/// Width of the plot and height of a bar, pixels.
const WIDTH: f64 = 480.0;
const BAR: f64 = 14.0;

/// Draws bars as a self-contained SVG; lines across them are the intervals.
///
/// # Errors
/// Where a number is not finite.
pub fn bar_plot(plot: &BarPlot) -> Result<String, PictureError> {
    let bars = || plot.rows.iter().flat_map(|(_, bars)| bars);
    let numbers = || bars().flat_map(|bar| [bar.value, bar.interval[0], bar.interval[1]]);
    axes::check("a bar", numbers())?;
    let [low, high] = axes::range(numbers().chain([0.0])).unwrap_or([0.0, 1.0]);
    let [low, high] = axes::widened(low, high);
    let room = 0.05 * (high - low);
    let left = 44.0 + plot.rows.iter().map(|(name, _)| text_width(name)).fold(0.0, f64::max);
    let row = BAR * plot.kinds.len() as f64 + 12.0;
    let area = [left, 76.0, WIDTH, row * plot.rows.len().max(1) as f64];
    let axes = Axes {
        area,
        low: [if low < 0.0 { low - room } else { 0.0 }, 0.0],
        high: [if high > 0.0 { high + room } else { 0.0 }, 1.0],
    };
    let fill = |kind: usize| format!(r#"fill="{}""#, CURVE_COLORS[kind % CURVE_COLORS.len()]);
    let key = |(kind, text): (usize, &&str)| Key { mark: Mark::Box(fill(kind)), text: (*text).to_owned() };
    // One kind is what the title says.
    let keys: Vec<Key> = plot.kinds.iter().enumerate().map(key).filter(|_| plot.kinds.len() > 1).collect();
    let legend_top = area[1] + area[3] + 68.0;
    let height = legend_top + axes::legend_height(&keys, WIDTH);
    let mut svg = Svg::new(left + WIDTH + 30.0, height, plot.title, plot.subtitle);
    let x = |value: f64| axes.at([value, 0.0])[0];
    for (k, (name, bars)) in plot.rows.iter().enumerate() {
        let top = area[1] + row * k as f64 + 6.0;
        svg.text([left - 10.0, top + 0.5 * row - 1.5], Anchor::End, "tt-ink", name);
        for (kind, bar) in bars.iter().enumerate() {
            let y = top + BAR * kind as f64;
            let [from, to] = [x(bar.value.min(0.0)), x(bar.value.max(0.0))];
            svg.rect([from, y, to - from, BAR - 3.0], &fill(kind));
            let [from, to, middle] = [x(bar.interval[0]), x(bar.interval[1]), y + 0.5 * (BAR - 3.0)];
            let look = r#"class="tt-line" stroke-width="1.2""#;
            svg.line([from, middle], [to, middle], look);
            for end in [from, to] {
                svg.line([end, middle - 3.5], [end, middle + 3.5], look);
            }
        }
    }
    axes.scale_across(&mut svg, plot.x);
    axes::legend(&mut svg, &keys, [left, legend_top], WIDTH);
    Ok(svg.finish())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::svg::assert_well_formed;
    use super::*;

    #[test]
    fn bars_start_at_0_and_are_as_long_as_their_values() {
        let bar = |value: f64| Bar { value, interval: [value - 0.1, value + 0.1] };
        let rows = vec![("size", vec![bar(0.8), bar(0.9)]), ("depth", vec![bar(0.4), bar(-0.1)])];
        let x = AxisName { quantity: "share of the variance", unit: "" };
        let plot = BarPlot { title: "t", subtitle: "s", x, kinds: vec!["alone", "with all others"], rows };
        let svg = bar_plot(&plot).unwrap();
        assert_well_formed(&svg);
        let widths: Vec<f64> = svg
            .lines()
            .filter(|line| line.starts_with("<rect") && line.contains("height=\"11\""))
            .filter_map(|line| line.split("width=\"").nth(1)?.split('"').next()?.parse().ok())
            .collect();
        // 1.2 units and a tenth of that as room over 480 pixels.
        let unit = 480.0 / (1.2 * 1.1);
        for (width, value) in widths.iter().zip([0.8, 0.9, 0.4, 0.1]) {
            assert!((width - unit * value).abs() < 0.02, "{width} for {value}");
        }
        assert_eq!(widths.len(), 4);
        assert!(bar_plot(&BarPlot { rows: vec![("a", vec![bar(f64::INFINITY)])], ..plot.clone() }).is_err());
        bar_plot(&BarPlot { rows: Vec::new(), ..plot }).unwrap();
    }
}
