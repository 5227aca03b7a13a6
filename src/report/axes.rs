//! Axes of a plot: place, grid, ticks, names; colour bars and legends.

use super::raster::PictureError;
use super::svg::{Anchor, Svg, text_width};
use super::ticks;

/// What an axis or a colour shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AxisName<'a> {
    /// The quantity, such as "pressure".
    pub quantity: &'a str,
    /// Its unit, such as "kPa"; empty where there is none.
    pub unit: &'a str,
}

impl AxisName<'_> {
    /// "pressure (10³ kPa)".
    pub(super) fn label(&self, exponent: i32) -> String {
        let power = if exponent == 0 { String::new() } else { ticks::power_of_ten(exponent) };
        let unit = [power.as_str(), self.unit].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
        if unit.is_empty() { self.quantity.to_owned() } else { format!("{} ({unit})", self.quantity) }
    }
}

/// Colours of curves that are told apart without colour vision (near the Okabe-Ito set), on light and dark pages.
pub(super) const CURVE_COLORS: [&str; 6] = ["#0a7cc4", "#d55e00", "#009e73", "#aa4499", "#b07d00", "#6e7781"];

/// A plot's rectangle in the picture and the ranges that it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes {
    /// x, y, width, height in pixels.
    pub area: [f64; 4],
    /// Least values shown, horizontal and vertical.
    pub low: [f64; 2],
    /// Greatest values shown.
    pub high: [f64; 2],
}

impl Axes {
    /// The picture's point of a point of the plot.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, width, height] = self.area;
        let share = |v: f64, axis: usize| (v - self.low[axis]) / (self.high[axis] - self.low[axis]);
        [left + width * share(x, 0), top + height * (1.0 - share(y, 1))]
    }

    pub fn polyline(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        points.iter().map(|&p| self.at(p)).collect()
    }

    fn scale(&self, axis: usize) -> ticks::Ticks {
        // A tick each 64 pixels across and 50 upward leaves room for the labels.
        let count = if axis == 0 { self.area[2] / 64.0 } else { self.area[3] / 50.0 };
        ticks::linear(self.low[axis], self.high[axis], (count as usize).max(2))
    }

    /// Hairlines at the ticks, to be drawn before the data.
    pub fn grid(&self, svg: &mut Svg) {
        let [left, top, width, height] = self.area;
        for (value, _) in self.scale(0).marks {
            let x = self.at([value, self.low[1]])[0];
            svg.line([x, top], [x, top + height], r#"class="tt-hair""#);
        }
        for (value, _) in self.scale(1).marks {
            let y = self.at([self.low[0], value])[1];
            svg.line([left, y], [left + width, y], r#"class="tt-hair""#);
        }
    }

    /// Lines, and ticks and a name below.
    pub fn scale_across(&self, svg: &mut Svg, name: AxisName) {
        let [left, top, width, height] = self.area;
        let bottom = top + height;
        let line = r#"class="tt-line" stroke-width="1.2""#;
        svg.path(&[[left, top], [left, bottom], [left + width, bottom]], false, line);
        let across = self.scale(0);
        for (value, label) in &across.marks {
            let x = self.at([*value, self.low[1]])[0];
            svg.line([x, bottom], [x, bottom + 5.0], r#"class="tt-line""#);
            svg.text([x, bottom + 19.0], Anchor::Middle, "tt-ink", label);
        }
        let middle = [left + 0.5 * width, bottom + 40.0];
        svg.text(middle, Anchor::Middle, "tt-muted", &name.label(across.exponent));
    }

    /// Lines, ticks, and names below and to the left.
    pub fn scales(&self, svg: &mut Svg, x_name: AxisName, y_name: AxisName) {
        self.scale_across(svg, x_name);
        let [left, top, _, height] = self.area;
        let upward = self.scale(1);
        let mut widest = 0.0f64;
        for (value, label) in &upward.marks {
            let y = self.at([self.low[0], *value])[1];
            svg.line([left - 5.0, y], [left, y], r#"class="tt-line""#);
            svg.text([left - 9.0, y + 4.5], Anchor::End, "tt-ink", label);
            widest = widest.max(text_width(label));
        }
        svg.text_upward([left - 20.0 - widest, top + 0.5 * height], "tt-muted", &y_name.label(upward.exponent));
    }
}

/// A range that is not empty: widened about a single value.
pub(super) fn widened(low: f64, high: f64) -> [f64; 2] {
    let slack = if high > low { 0.0 } else { 0.5 * low.abs().max(1.0) };
    [low - slack, high + slack]
}

/// The first number that cannot be drawn, as an error. Beyond 1e300 the layout's arithmetic would overflow.
pub(super) fn check(what: &'static str, numbers: impl IntoIterator<Item = f64>) -> Result<(), PictureError> {
    match numbers.into_iter().find(|v| v.is_nan() || v.abs() > 1e300) {
        Some(value) => Err(PictureError::Number { what, value, allowed: "finite" }),
        None => Ok(()),
    }
}

/// Least and greatest of numbers; `None` of none.
pub(super) fn range(numbers: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    numbers.into_iter().fold(None, |range, v| match range {
        None => Some([v, v]),
        Some([low, high]) => Some([low.min(v), high.max(v)]),
    })
}

/// A colour bar in the rectangle x, y, width, height for values `low` to `high`; `color` takes the share, 0 to 1. An
/// end beyond which there are values is pointed.
pub(super) fn color_bar(
    svg: &mut Svg,
    [x, y, w, h]: [f64; 4],
    [low, high]: [f64; 2],
    color: &dyn Fn(f64) -> [u8; 3],
    name: AxisName,
    beyond: [bool; 2],
) -> Result<(), PictureError> {
    let steps = 256;
    // Some columns, because readers that smooth a bitmap blur its edges by one of its pixels.
    let columns = w.ceil() as usize;
    let row = |i: usize| color(i as f64 / (steps - 1) as f64).repeat(columns);
    let rgb: Vec<u8> = (0..steps).rev().flat_map(row).collect();
    svg.bitmap([x, y, w, h], columns, steps, &rgb)?;
    svg.rect([x, y, w, h], r#"class="tt-hair""#);
    for (is_beyond, base, tip, share) in [(beyond[0], y + h, y + h + 12.0, 0.0), (beyond[1], y, y - 12.0, 1.0)] {
        if is_beyond {
            let [r, g, b] = color(share);
            let fill = format!(r##"fill="#{r:02x}{g:02x}{b:02x}""##);
            svg.path(&[[x, base], [x + w, base], [x + 0.5 * w, tip]], true, &fill);
            svg.path(&[[x, base], [x + 0.5 * w, tip], [x + w, base]], false, r#"class="tt-hair""#);
        }
    }
    let ticks = ticks::linear(low, high, ((h / 50.0) as usize).max(2));
    let mut widest = 0.0f64;
    for (value, label) in &ticks.marks {
        let at = y + h * (1.0 - (value - low) / (high - low));
        svg.line([x + w, at], [x + w + 5.0, at], r#"class="tt-line""#);
        svg.text([x + w + 9.0, at + 4.5], Anchor::Start, "tt-ink", label);
        widest = widest.max(text_width(label));
    }
    svg.text_upward([x + w + 26.0 + widest, y + 0.5 * h], "tt-muted", &name.label(ticks.exponent));
    Ok(())
}

/// An entry of a legend: SVG attributes of a line, or of a box, and its words.
pub(super) struct Key {
    pub mark: Mark,
    pub text: String,
}

/// The sign before the words.
pub(super) enum Mark {
    Line(String),
    Box(String),
    Dot(String),
}

/// Draws entries in rows no wider than `width` from the baseline `top`, and says how high they are.
pub(super) fn legend(svg: &mut Svg, keys: &[Key], [left, top]: [f64; 2], width: f64) -> f64 {
    let (mut x, mut y) = (left, top);
    for key in keys {
        let needed = 58.0 + text_width(&key.text);
        if x > left && x + needed > left + width + 20.0 {
            (x, y) = (left, y + 22.0);
        }
        match &key.mark {
            Mark::Line(look) => svg.line([x, y], [x + 26.0, y], &format!(r#"fill="none" {look}"#)),
            Mark::Box(look) => svg.rect([x + 4.0, y - 6.0, 18.0, 12.0], &format!(r#"rx="2" {look}"#)),
            Mark::Dot(look) => svg.line([x + 13.0, y], [x + 13.0, y], look),
        }
        svg.text([x + 33.0, y + 4.5], Anchor::Start, "tt-ink", &key.text);
        x += needed;
    }
    if keys.is_empty() { 0.0 } else { y - top + 22.0 }
}

/// How high [`legend`] will be.
pub(super) fn legend_height(keys: &[Key], width: f64) -> f64 {
    legend(&mut Svg::new(0.0, 0.0, "", ""), keys, [0.0, 0.0], width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_ranges_are_corners_of_the_area() {
        let axes = Axes { area: [10.0, 20.0, 300.0, 200.0], low: [-1.0, 5.0], high: [2.0, 9.0] };
        assert_eq!(axes.at([-1.0, 5.0]), [10.0, 220.0]);
        assert_eq!(axes.at([2.0, 9.0]), [310.0, 20.0]);
    }

    #[test]
    fn long_legends_break_into_rows() {
        let key = |text: &str| Key { mark: Mark::Line(String::new()), text: text.to_owned() };
        let keys = [key("one of many"), key("two of many"), key("three of many")];
        assert_eq!(legend_height(&keys, 1000.0), 22.0);
        assert_eq!(legend_height(&keys, 200.0), 66.0);
        assert_eq!(legend_height(&[], 200.0), 0.0);
    }
}
