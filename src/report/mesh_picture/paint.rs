//! The scalar as a bitmap, through the elements' quadratic map.

use super::super::axes::Axes;
use super::super::raster::PictureError;
use super::super::svg::Svg;
use super::{Colors, Shape};

/// Pixels of the bitmap to one of the picture, for screens that have them.
const FINENESS: f64 = 1.5;
/// Distance of samples in pixels of the bitmap: below 1 / sqrt(2) no pixel inside an element is missed.
const SAMPLE_PX: f64 = 0.6;
/// Most samples along one side of an element: one that fills the picture.
const MOST_SAMPLES: usize = 2400;

/// Draws the scalar of all bodies.
pub(super) fn values(
    svg: &mut Svg,
    axes: &Axes,
    shapes: &[Shape],
    sides: &[f64],
    colors: &Colors,
) -> Result<(), PictureError> {
    let (size, rgba) = bitmap(axes, shapes, sides, colors);
    svg.bitmap_rgba(axes.area, size, &rgba)
}

/// Columns and rows, and the pixels; transparent where there is no body.
pub(super) fn bitmap(axes: &Axes, shapes: &[Shape], sides: &[f64], colors: &Colors) -> ([usize; 2], Vec<u8>) {
    let [left, top, width, height] = axes.area;
    let size = [width, height].map(|length| (length * FINENESS).ceil() as usize);
    let mut rgba = vec![0u8; 4 * size[0] * size[1]];
    let to_pixel = |[x, z]: [f64; 2]| {
        let [px, py] = axes.at([x, z]);
        [(px - left) / width * size[0] as f64, (py - top) / height * size[1] as f64]
    };
    for shape in shapes {
        for e in 0..shape.mesh.element_count() {
            let Some(values) = shape.values.get(9 * e..9 * e + 9) else { continue };
            let nodes = shape.element(e);
            for &side in sides {
                let places = nodes.map(|[x, z]| to_pixel([side * x, z]));
                element(&mut rgba, size, &places, values, colors);
            }
        }
    }
    (size, rgba)
}

/// Colours the pixels under one element.
fn element(rgba: &mut [u8], [columns, rows]: [usize; 2], places: &[[f64; 2]; 9], values: &[f64], colors: &Colors) {
    let is_outside = |axis: usize, most: usize| {
        let (low, high) =
            places.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        // A quadratic bulges beyond its nodes by less than its own size.
        high + (high - low) < 0.0 || low - (high - low) > most as f64
    };
    if is_outside(0, columns) || is_outside(1, rows) {
        return;
    }
    let [across, upward] = [samples(places, 1, 3), samples(places, 3, 1)];
    let first: Vec<[f64; 3]> = (0..=across).map(|i| shape_functions(i, across)).collect();
    for j in 0..=upward {
        let b = shape_functions(j, upward);
        // The element's rows collapse to one quadratic for this line of samples.
        let line: [[f64; 3]; 3] = std::array::from_fn(|i| {
            let sum = |f: &dyn Fn(usize) -> f64| b[0] * f(i) + b[1] * f(i + 3) + b[2] * f(i + 6);
            [sum(&|a| places[a][0]), sum(&|a| places[a][1]), sum(&|a| values[a])]
        });
        for a in &first {
            let [x, y, value] = std::array::from_fn(|k| a[0] * line[0][k] + a[1] * line[1][k] + a[2] * line[2][k]);
            if x >= 0.0 && y >= 0.0 && x < columns as f64 && y < rows as f64 {
                let at = 4 * (y as usize * columns + x as usize);
                let [r, g, b] = colors.at(value);
                if let Some(pixel) = rgba.get_mut(at..at + 4) {
                    pixel.copy_from_slice(&[r, g, b, 255]);
                }
            }
        }
    }
}

/// Samples along one axis of the lattice: the longest of its three lines decides. An uneven middle node makes the map
/// run up to twice as fast as on average.
fn samples(places: &[[f64; 2]; 9], step: usize, line: usize) -> usize {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let length = |i: usize| {
        let [a, b, c] = [places[i * line], places[i * line + step], places[i * line + 2 * step]];
        2.0 * distance(a, b).max(distance(b, c))
    };
    let longest = (0..3).map(length).fold(0.0, f64::max);
    ((longest / SAMPLE_PX).ceil() as usize).clamp(2, MOST_SAMPLES)
}

/// Quadratic Lagrange polynomials at sample `i` of `count`.
fn shape_functions(i: usize, count: usize) -> [f64; 3] {
    let t = 2.0 * i as f64 / count as f64 - 1.0;
    [0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)]
}
