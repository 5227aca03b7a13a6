//! A quantity over two axes: one coloured cell a point.

use super::axes::{self, Axes, AxisName};
use super::false_color::color;
use super::raster::PictureError;
use super::svg::Svg;

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap<'a> {
    /// Title of the picture.
    pub title: &'a str,
    /// A line below the title.
    pub subtitle: &'a str,
    /// The horizontal axis.
    pub x: AxisName<'a>,
    /// The vertical axis.
    pub y: AxisName<'a>,
    /// What the colours show.
    pub z: AxisName<'a>,
    /// Points: both coordinates and the value.
    pub points: Vec<[f64; 3]>,
}

/// Size of the plot, pixels.
const SIZE: [f64; 2] = [520.0, 380.0];

/// Draws cells as a self-contained SVG. A cell reaches half way to the next values of each axis; where there is no
/// point there is no cell.
///
/// # Errors
/// Where a number is not finite.
pub fn heat_map(map: &HeatMap) -> Result<String, PictureError> {
    axes::check("a point of a map", map.points.iter().flatten().copied())?;
    let edges = [0, 1].map(|axis| edges(map.points.iter().map(|point| point[axis])));
    let [low, high] = axes::range(map.points.iter().map(|point| point[2])).unwrap_or([0.0, 1.0]);
    let [low, high] = axes::widened(low, high);
    let end = |cells: &[[f64; 3]], last: bool| {
        let cell = if last { cells.last() } else { cells.first() };
        cell.map_or(f64::from(u8::from(last)), |cell| if last { cell[2] } else { cell[1] })
    };
    let axes = Axes {
        area: [86.0, 76.0, SIZE[0], SIZE[1]],
        low: [end(&edges[0], false), end(&edges[1], false)],
        high: [end(&edges[0], true), end(&edges[1], true)],
    };
    let mut svg = Svg::new(86.0 + SIZE[0] + 140.0, 76.0 + SIZE[1] + 62.0, map.title, map.subtitle);
    for [x, y, value] in &map.points {
        let cell = |axis: usize, at: f64| edges[axis].iter().find(|cell| cell[0] == at);
        let (Some([_, left, right]), Some([_, bottom, top])) = (cell(0, *x), cell(1, *y)) else { continue };
        let ([x0, y1], [x1, y0]) = (axes.at([*left, *bottom]), axes.at([*right, *top]));
        let [r, g, b] = color((value - low) / (high - low));
        // Neighbours overlap by a hair, so that no page shows between them.
        svg.rect(
            [x0, y0, x1 - x0 + 0.3, y1 - y0 + 0.3],
            &format!(r##"shape-rendering="crispEdges" fill="#{r:02x}{g:02x}{b:02x}""##),
        );
    }
    axes.scales(&mut svg, map.x, map.y);
    let bar = [86.0 + SIZE[0] + 24.0, 76.0, 18.0, SIZE[1]];
    axes::color_bar(&mut svg, bar, [low, high], &color, map.z, [false; 2])?;
    Ok(svg.finish())
}

/// Each value of an axis with the ends of its cell, in ascending order.
fn edges(values: impl Iterator<Item = f64>) -> Vec<[f64; 3]> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let gap = |k: usize| values.get(k + 1).map(|next| next - values[k]);
    let lone = values.first().map_or(1.0, |value| value.abs().max(1.0));
    (0..values.len())
        .map(|k| {
            let before = k.checked_sub(1).and_then(gap).or(gap(k)).unwrap_or(lone);
            let after = gap(k).or(k.checked_sub(1).and_then(gap)).unwrap_or(lone);
            [values[k], values[k] - 0.5 * before, values[k] + 0.5 * after]
        })
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::svg::assert_well_formed;
    use super::*;

    #[test]
    fn cells_meet_half_way() {
        let found = edges([1.0, 2.0, 4.0, 2.0].into_iter());
        assert_eq!(found, [[1.0, 0.5, 1.5], [2.0, 1.5, 3.0], [4.0, 3.0, 5.0]]);
        assert_eq!(edges([3.0].into_iter()), [[3.0, 1.5, 4.5]]);
    }

    #[test]
    fn every_point_is_a_cell_and_the_largest_is_the_lightest() {
        let name = |quantity| AxisName { quantity, unit: "" };
        let points = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 3.0]];
        let map = HeatMap { title: "t", subtitle: "s", x: name("x"), y: name("y"), z: name("z"), points };
        let svg = heat_map(&map).unwrap();
        assert_well_formed(&svg);
        let cells = |share: f64| {
            let [r, g, b] = color(share);
            svg.matches(&format!(r##"fill="#{r:02x}{g:02x}{b:02x}""##)).count()
        };
        assert_eq!([cells(0.0), cells(0.5), cells(1.0)], [1; 3]);
        // x = 1 is drawn right of x = 0: the middle of the plot is where they meet.
        assert!(svg.contains(r#"x="346""#), "{svg}");
        heat_map(&HeatMap { points: Vec::new(), ..map.clone() }).unwrap();
        assert!(heat_map(&HeatMap { points: vec![[0.0, f64::NAN, 1.0]], ..map }).is_err());
    }
}
