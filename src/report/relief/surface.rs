//! The surface of a relief: shaded cells and the cuts at its near edges.

use super::super::false_color::color;
use super::super::raster::Blocks;
use super::super::svg::Svg;
use super::{BOX_HEIGHT, Stage};

/// The vertices of the surface: block means at block centres, the outermost moved to the edge of the box.
struct Grid<'a> {
    stage: &'a Stage,
    blocks: &'a Blocks,
}

impl Grid<'_> {
    fn height(&self, column: usize, row: usize) -> f64 {
        self.stage.height(self.blocks.values.get(row * self.blocks.width + column).copied().unwrap_or(0.0))
    }

    /// Place from -1 to 1 along an axis of `count` vertices.
    fn place(index: usize, count: usize) -> f64 {
        match index {
            0 => -1.0,
            _ if index + 1 == count => 1.0,
            _ => (2.0 * index as f64 + 1.0) / count as f64 - 1.0,
        }
    }

    fn at(&self, column: usize, row: usize, z: f64) -> [f64; 2] {
        let y = -Self::place(row, self.blocks.height);
        self.stage.project(Self::place(column, self.blocks.width), y, z)
    }

    fn vertex(&self, column: usize, row: usize) -> [f64; 2] {
        self.at(column, row, self.height(column, row))
    }

    /// Colour of the cell whose upper left vertex is given.
    fn cell_color(&self, column: usize, row: usize) -> [u8; 3] {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| self.height(column + i, row + j));
        let rise = |change: f64, count: usize, half: f64| change * BOX_HEIGHT * count as f64 / (2.0 * half);
        let slope_x = rise((b - a) + (c - d), self.blocks.width, self.stage.half[0]);
        let slope_y = rise((a - d) + (b - c), self.blocks.height, self.stage.half[1]);
        shaded(color(0.25 * (a + b + c + d)), slope_x, slope_y)
    }
}

/// The cells from the back to the front, then the cuts at the two near edges. Neighbours of one colour are one strip.
pub(super) fn draw(svg: &mut Svg, stage: &Stage, blocks: &Blocks) {
    let grid = Grid { stage, blocks };
    let (columns, rows) = (blocks.width, blocks.height);
    svg.group(r#"fill="currentColor" stroke="currentColor" stroke-width="0.7" stroke-linejoin="round""#);
    for row in 0..rows.saturating_sub(1) {
        let mut start = 0;
        for column in 0..columns.saturating_sub(1) {
            let fill = grid.cell_color(column, row);
            if column + 2 == columns || grid.cell_color(column + 1, row) != fill {
                let upper = straightened((start..=column + 1).map(|c| grid.vertex(c, row)));
                let lower = straightened((start..=column + 1).rev().map(|c| grid.vertex(c, row + 1)));
                fill_path(svg, &[upper, lower].concat(), fill);
                start = column + 1;
            }
        }
    }
    // Dark sides close the body where the values do not fall to the floor.
    if columns > 1 && rows > 1 {
        let front = straightened((0..columns).map(|c| grid.vertex(c, rows - 1)));
        let feet = [grid.at(columns - 1, rows - 1, 0.0), grid.at(0, rows - 1, 0.0)];
        fill_path(svg, &[front, feet.to_vec()].concat(), [44, 26, 62]);
        let side = straightened((0..rows).map(|r| grid.vertex(columns - 1, r)));
        let feet = [grid.at(columns - 1, rows - 1, 0.0), grid.at(columns - 1, 0, 0.0)];
        fill_path(svg, &[side, feet.to_vec()].concat(), [28, 16, 40]);
    }
    svg.end_group();
}

fn fill_path(svg: &mut Svg, points: &[[f64; 2]], [r, g, b]: [u8; 3]) {
    // Of the group's fill and stroke alike.
    svg.path(points, true, &format!("color='#{r:02x}{g:02x}{b:02x}'"));
}

/// A polyline without the points that lie on the straight line between their neighbours.
fn straightened(points: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for p in points {
        if let [.., a, b] = kept[..] {
            let [along, aside] = [[p[0] - a[0], p[1] - a[1]], [b[0] - a[0], b[1] - a[1]]];
            let distance = (along[0] * aside[1] - along[1] * aside[0]).abs() / along[0].hypot(along[1]);
            // A twentieth of a pixel is not seen.
            if distance < 0.05 {
                kept.pop();
            }
        }
        kept.push(p);
    }
    kept
}

/// Lambert shading by a light from the upper left with a generous ambient part: the colour must stay readable.
fn shaded(rgb: [u8; 3], slope_x: f64, slope_y: f64) -> [u8; 3] {
    const LIGHT: [f64; 3] = [-0.48, -0.32, 0.82];
    let length = (slope_x * slope_x + slope_y * slope_y + 1.0).sqrt();
    let cosine = (-slope_x * LIGHT[0] - slope_y * LIGHT[1] + LIGHT[2]) / length;
    let factor = 0.55 + 0.55 * cosine.max(0.0);
    rgb.map(|v| (f64::from(v) * factor).min(255.0) as u8)
}
