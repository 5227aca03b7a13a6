//! Curves over one axis, such as contact pressure against radius.

use super::axes::{self, Axes, AxisName, CURVE_COLORS, Key, Mark};
use super::raster::PictureError;
use super::svg::Svg;

/// How a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveStyle {
    /// A line.
    Line,
    /// A dashed line, such as for a closed form.
    Dashed,
    /// Dots, such as for what was measured.
    Points,
}

/// One curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend; a curve without one is not in it.
    pub name: String,
    /// Its points in the order in which they are joined.
    pub points: Vec<[f64; 2]>,
    /// x, least and greatest value of an error band; empty: none.
    pub band: Vec<[f64; 3]>,
    /// How it is drawn.
    pub style: CurveStyle,
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePlot<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// A line below the title.
    pub subtitle: &'a str,
    /// The horizontal axis.
    pub x: AxisName<'a>,
    /// The vertical axis.
    pub y: AxisName<'a>,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Greatest value shown; curves are cut off there. Absent: everything.
    pub highest: Option<f64>,
    /// Whether 0 is shown; else the picture is of where the curves lie.
    pub from_zero: bool,
}

/// Size of the plot, pixels.
const SIZE: [f64; 2] = [600.0, 340.0];

/// Draws curves as a self-contained SVG.
///
/// # Errors
/// Where a number is not finite.
pub fn curve_plot(plot: &CurvePlot) -> Result<String, PictureError> {
    let points = || plot.curves.iter().flat_map(|c| &c.points);
    let bands = || plot.curves.iter().flat_map(|c| &c.band);
    axes::check("a point of a curve", points().flatten().chain(bands().flatten()).copied())?;
    let x = axes::range(points().map(|p| p[0]).chain(bands().map(|b| b[0]))).unwrap_or([0.0, 1.0]);
    let heights = points().map(|p| p[1]).chain(bands().flat_map(|b| [b[1], b[2]]));
    let zero = plot.from_zero.then_some(0.0);
    let y = axes::range(heights.chain(zero)).unwrap_or([0.0, 1.0]);
    let ([left, right], [bottom, top]) = (axes::widened(x[0], x[1]), axes::widened(y[0], y[1]));
    // A twentieth of room, but none below a floor of 0.
    let room = 0.05 * (top - bottom);
    let axes = Axes {
        area: [86.0, 76.0, SIZE[0], SIZE[1]],
        low: [left, if bottom < 0.0 || !plot.from_zero { bottom - room } else { 0.0 }],
        high: [right, plot.highest.unwrap_or(if top > 0.0 || !plot.from_zero { top + room } else { top })],
    };
    let keys: Vec<Key> = plot.curves.iter().enumerate().filter(|(_, c)| !c.name.is_empty()).map(key).collect();
    let legend_top = 76.0 + SIZE[1] + 68.0;
    let height = legend_top + axes::legend_height(&keys, SIZE[0]);
    let mut svg = Svg::new(86.0 + SIZE[0] + 30.0, height, plot.title, plot.subtitle);
    axes.grid(&mut svg);
    svg.clip(axes.area);
    for (i, curve) in plot.curves.iter().enumerate() {
        draw_band(&mut svg, &axes, curve, color(i));
    }
    let of_dots = |dots: bool| {
        let curves = plot.curves.iter().enumerate();
        curves.filter(move |(_, curve)| (curve.style == CurveStyle::Points) == dots)
    };
    for (i, curve) in of_dots(false) {
        draw_curve(&mut svg, &axes.polyline(&curve.points), curve.style, color(i));
    }
    svg.end_clip();
    // Dots on the frame are whole.
    let inside = |point: &[f64; 2]| (0..2).all(|axis| (axes.low[axis]..=axes.high[axis]).contains(&point[axis]));
    for (i, curve) in of_dots(true) {
        let points: Vec<[f64; 2]> = curve.points.iter().copied().filter(inside).collect();
        draw_curve(&mut svg, &axes.polyline(&points), curve.style, color(i));
    }
    axes.scales(&mut svg, plot.x, plot.y);
    axes::legend(&mut svg, &keys, [86.0, legend_top], SIZE[0]);
    Ok(svg.finish())
}

fn color(curve: usize) -> &'static str {
    CURVE_COLORS[curve % CURVE_COLORS.len()]
}

fn draw_band(svg: &mut Svg, axes: &Axes, curve: &Curve, color: &str) {
    if curve.band.is_empty() {
        return;
    }
    let low = curve.band.iter().map(|&[x, low, _]| axes.at([x, low]));
    let high = curve.band.iter().rev().map(|&[x, _, high]| axes.at([x, high]));
    let outline: Vec<[f64; 2]> = low.chain(high).collect();
    svg.path(&outline, true, &format!(r#"fill="{color}" fill-opacity="0.18""#));
}

/// Draws a polyline of the picture in a style.
pub(super) fn draw_curve(svg: &mut Svg, points: &[[f64; 2]], style: CurveStyle, color: &str) {
    if points.is_empty() {
        return;
    }
    let look = look(style, color);
    if style == CurveStyle::Points {
        // Lines of no length with round ends are dots: one path for all.
        let dots: String = points.iter().map(|[x, y]| format!("M{x:.1} {y:.1}h0")).collect();
        svg.commands(&dots, &look);
    } else {
        svg.path(points, false, &look);
    }
}

fn look(style: CurveStyle, color: &str) -> String {
    let more = match style {
        CurveStyle::Line => r#"stroke-width="2" stroke-linejoin="round""#,
        CurveStyle::Dashed => r#"stroke-width="2" stroke-dasharray="7 4""#,
        CurveStyle::Points => r#"stroke-width="5" stroke-linecap="round""#,
    };
    format!(r#"fill="none" stroke="{color}" {more}"#)
}

fn key((i, curve): (usize, &Curve)) -> Key {
    let look = look(curve.style, color(i)).replace(r#"fill="none" "#, "");
    let mark = if curve.style == CurveStyle::Points { Mark::Dot(look) } else { Mark::Line(look) };
    Key { mark, text: curve.name.clone() }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::svg::{assert_well_formed, keep_sample};
    use super::*;

    fn hertz() -> CurvePlot<'static> {
        let exact = |r: f64| 5.0 * (1.0 - r * r / 16.0).max(0.0).sqrt();
        let closed: Vec<[f64; 2]> = (0..=200).map(|i| 0.03 * f64::from(i)).map(|r| [r, exact(r)]).collect();
        let dots: Vec<[f64; 2]> = (0..24).map(|i| 0.25 * f64::from(i)).map(|r| [r, 1.01 * exact(r)]).collect();
        let soft: Vec<[f64; 2]> = closed.iter().map(|[r, p]| [*r, 0.6 * p * (1.0 - 0.02 * r)]).collect();
        let band = soft.iter().step_by(4).map(|[r, p]| [*r, 0.95 * p, 1.05 * p]).collect();
        let curve = |name: &str, points, band, style| Curve { name: name.into(), points, band, style };
        CurvePlot {
            title: "Contact pressure",
            subtitle: "sphere of 20 mm on a half space, 0.8 mm deep",
            x: AxisName { quantity: "r", unit: "mm" },
            y: AxisName { quantity: "pressure", unit: "kPa" },
            curves: vec![
                curve("finite elements", dots, vec![], CurveStyle::Points),
                curve("Hertz", closed, vec![], CurveStyle::Dashed),
                curve("softer, with its error", soft, band, CurveStyle::Line),
            ],
            from_zero: true,
            highest: None,
        }
    }

    #[test]
    fn curves_have_axes_units_and_a_legend() {
        let svg = curve_plot(&hertz()).unwrap();
        assert_well_formed(&svg);
        for text in ["pressure (kPa)", "r (mm)", "finite elements", "Hertz", "Contact pressure"] {
            assert!(svg.contains(&format!(">{text}<")), "{text}");
        }
        keep_sample("curves.svg", &svg);
    }

    /// Dots on the frame are drawn whole, beyond the clipped area; those above the highest value are left out.
    #[test]
    fn dots_are_whole_or_not_there() {
        let mut plot = hertz();
        // After the end of the clipped part.
        let dots = |plot: &CurvePlot| {
            let svg = curve_plot(plot).unwrap();
            svg.split_once("</svg>").unwrap().1.matches("h0").count()
        };
        let whole = dots(&plot);
        plot.highest = Some(4.0);
        let cut = plot.curves[0].points.iter().filter(|point| point[1] > 4.0).count();
        assert!(whole >= 24 && cut > 5, "{whole} {cut}");
        assert_eq!(dots(&plot), whole - cut);
    }

    #[test]
    fn empty_single_and_negative_curves_are_drawn() {
        let mut plot = hertz();
        for points in [vec![], vec![[1.0, 0.0]], vec![[0.0, -3.0], [1.0, -1.0]], vec![[0.0, 1e-12], [1e-9, 2e-12]]] {
            plot.curves = vec![Curve { name: String::new(), points, band: vec![], style: CurveStyle::Line }];
            assert_well_formed(&curve_plot(&plot).unwrap());
        }
        plot.curves.clear();
        assert_well_formed(&curve_plot(&plot).unwrap());
    }

    #[test]
    fn what_is_not_finite_is_refused() {
        let mut plot = hertz();
        plot.curves[0].points[3][1] = f64::NAN;
        assert!(matches!(curve_plot(&plot), Err(PictureError::Number { .. })));
        let mut plot = hertz();
        plot.curves[2].band[0][2] = f64::INFINITY;
        assert!(curve_plot(&plot).is_err());
    }
}
