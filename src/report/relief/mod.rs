//! A 3-D relief of an image, as in figure 6c of the TSIS paper: height and colour show the value.
//!
//! Orthographic, painted from the back; the colour map is that of the false-colour picture, shaded by the angle to a
//! light from the upper left.

mod surface;

use super::false_color::{ColorScale, Mapping};
use super::raster::{Blocks, PictureError, Raster};
use super::svg::{Anchor, Svg, text_width};
use super::ticks::{self, Ticks};

/// Most cells along and across: fine enough for the eye, small enough for a report.
const CELLS: [usize; 2] = [100, 75];
/// Turn of the surface about the vertical, and elevation of the viewer, degrees.
const AZIMUTH_DEG: f64 = 32.0;
const ELEVATION_DEG: f64 = 32.0;
/// Height of the box over its longer side.
const BOX_HEIGHT: f64 = 0.48;

/// Draws the relief as a self-contained SVG.
///
/// # Errors
/// Where the raster's size does not fit or a number is not finite.
pub fn relief(title: &str, raster: &Raster, scale: ColorScale) -> Result<String, PictureError> {
    raster.check()?;
    let blocks = raster.blocks(CELLS[0] + 1, CELLS[1] + 1);
    let most = blocks.values.iter().copied().fold(0.0, f64::max);
    let mapping = Mapping::choose(&blocks, scale);
    let heights = match mapping.log {
        true => Ticks { marks: ticks::logarithmic(mapping.low, mapping.high), exponent: 0 },
        false => ticks::linear(mapping.low, mapping.high, 5),
    };
    let stage = Stage::new(raster, mapping);
    let mut svg = Svg::new(stage.size[0], stage.size[1], title, &subtitle(raster, &blocks, most));
    walls(&mut svg, &stage, &heights);
    surface::draw(&mut svg, &stage, &blocks);
    axes(&mut svg, &stage, raster, &heights);
    Ok(svg.finish())
}

fn subtitle(raster: &Raster, blocks: &Blocks, most: f64) -> String {
    if raster.values.iter().all(|&v| v == 0.0) {
        return "dark: maximum 0".to_owned();
    }
    let unit = if raster.unit.is_empty() { String::new() } else { format!(" {}", raster.unit) };
    format!("means over {} × {} blocks of pixels · highest {}{unit}", blocks.width, blocks.height, ticks::short(most))
}

/// The box that holds the surface, and its projection to the picture.
struct Stage {
    /// Half extents along x and y, in the longer side's half.
    half: [f64; 2],
    /// Half extents in the unit of length.
    half_length: [f64; 2],
    mapping: Mapping,
    scale: f64,
    center: [f64; 2],
    size: [f64; 2],
}

impl Stage {
    fn new(raster: &Raster, mapping: Mapping) -> Self {
        let (pixel, _) = raster.pixel_length();
        let half_length = [0.5 * pixel * raster.width as f64, 0.5 * pixel * raster.height as f64];
        let longer = half_length[0].max(half_length[1]);
        let mut stage = Self {
            half: half_length.map(|l| l / longer),
            half_length,
            mapping,
            scale: 1.0,
            center: [0.0, 0.0],
            size: [0.0, 0.0],
        };
        let corners = [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| [0.0, 1.0].map(|z| stage.project(x, y, z))));
        let corners = corners.as_flattened().as_flattened();
        let extent = |axis: usize| {
            corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[axis]), h.max(c[axis])))
        };
        let ((left, right), (top, bottom)) = (extent(0), extent(1));
        // Room for the ticks and names around the box; a square or tall raster is drawn smaller.
        stage.scale = (560.0 / (right - left)).min(470.0 / (bottom - top));
        let (w, h) = ((right - left) * stage.scale, (bottom - top) * stage.scale);
        stage.size = [(w + 180.0).max(460.0), h + 84.0 + 52.0];
        stage.center = [0.5 * stage.size[0] - 0.5 * (left + right) * stage.scale + 24.0, 84.0 - top * stage.scale];
        stage
    }

    /// Picture coordinates of a point of the box: x and y from -1 to 1 over the extents, z from 0 to 1.
    fn project(&self, x: f64, y: f64, z: f64) -> [f64; 2] {
        let (sin_a, cos_a) = AZIMUTH_DEG.to_radians().sin_cos();
        let (sin_e, cos_e) = ELEVATION_DEG.to_radians().sin_cos();
        let (x, y) = (x * self.half[0], y * self.half[1]);
        let across = x * cos_a + y * sin_a;
        let away = -x * sin_a + y * cos_a;
        let up = 2.0 * BOX_HEIGHT * z * cos_e + away * sin_e;
        [self.center[0] + across * self.scale, self.center[1] - up * self.scale]
    }

    fn height(&self, value: f64) -> f64 {
        self.mapping.share(value)
    }
}

/// The floor and the two walls behind the surface, with lines at the ticks.
fn walls(svg: &mut Svg, stage: &Stage, heights: &Ticks) {
    let at = |x, y, z| stage.project(x, y, z);
    let faces = [
        [at(-1., -1., 0.), at(1., -1., 0.), at(1., 1., 0.), at(-1., 1., 0.)],
        [at(-1., -1., 0.), at(-1., 1., 0.), at(-1., 1., 1.), at(-1., -1., 1.)],
        [at(-1., 1., 0.), at(1., 1., 0.), at(1., 1., 1.), at(-1., 1., 1.)],
    ];
    for face in faces {
        svg.path(&face, true, r#"class="tt-wall""#);
    }
    for (value, _) in &heights.marks {
        let z = stage.height(*value);
        svg.path(&[at(-1., -1., z), at(-1., 1., z), at(1., 1., z)], false, r#"class="tt-hair""#);
    }
    for axis in [0, 1] {
        let length = stage.half_length[axis];
        for (value, _) in ticks::linear(-length, length, 6).marks {
            let t = value / length;
            let line = if axis == 0 {
                [at(t, -1., 0.), at(t, 1., 0.), at(t, 1., 1.)]
            } else {
                [at(1., t, 0.), at(-1., t, 0.), at(-1., t, 1.)]
            };
            svg.path(&line, false, r#"class="tt-hair""#);
        }
    }
}

fn axes(svg: &mut Svg, stage: &Stage, raster: &Raster, heights: &Ticks) {
    let at = |x, y, z| stage.project(x, y, z);
    let (_, unit) = raster.pixel_length();
    svg.path(
        &[at(-1., -1., 1.), at(-1., -1., 0.), at(1., -1., 0.), at(1., 1., 0.)],
        false,
        r#"class="tt-line" stroke-width="1.2""#,
    );
    for axis in [0, 1] {
        let length = stage.half_length[axis];
        let scale = ticks::linear(-length, length, 6);
        // The ticks point away from the box along the other axis.
        let [near, outward] =
            if axis == 0 { [at(0., -1., 0.), at(0., -1.05, 0.)] } else { [at(1., 0., 0.), at(1.05, 0., 0.)] };
        let direction = unit_vector(near, outward);
        let anchor = if axis == 0 { Anchor::End } else { Anchor::Start };
        for (value, label) in &scale.marks {
            let t = value / length;
            // The left corner belongs to the vertical axis.
            if axis == 0 && t < -0.95 {
                continue;
            }
            let foot = if axis == 0 { at(t, -1., 0.) } else { at(1., t, 0.) };
            svg.line(foot, along(foot, direction, 6.0), r#"class="tt-line""#);
            let [x, y] = along(foot, direction, 10.0);
            svg.text([x, y + 8.0], anchor, "tt-ink", label);
        }
        let name = format!("{} ({}{unit})", if axis == 0 { "x" } else { "y" }, power_prefix(scale.exponent));
        let [x, y] = along(near, direction, 46.0);
        svg.text([x, y + 10.0], anchor, "tt-muted", &name);
    }
    for (value, label) in &heights.marks {
        let [x, y] = at(-1., -1., stage.height(*value));
        svg.line([x, y], [x - 6.0, y], r#"class="tt-line""#);
        svg.text([x - 10.0, y + 4.5], Anchor::End, "tt-ink", label);
    }
    let [x, y] = at(-1., -1., 0.5);
    let widest = heights.marks.iter().map(|(_, l)| text_width(l)).fold(0.0, f64::max);
    let label = raster.quantity_label(heights.exponent);
    let label = if stage.mapping.log { format!("{label}, logarithmic") } else { label };
    svg.text_upward([x - 22.0 - widest, y], "tt-muted", &label);
}

fn power_prefix(exponent: i32) -> String {
    if exponent == 0 { String::new() } else { format!("{} ", ticks::power_of_ten(exponent)) }
}

fn unit_vector(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy).max(f64::MIN_POSITIVE);
    [dx / length, dy / length]
}

fn along(from: [f64; 2], direction: [f64; 2], length: f64) -> [f64; 2] {
    [from[0] + direction[0] * length, from[1] + direction[1] * length]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::raster::tests::{blob, raster};
    use super::super::svg::assert_well_formed;
    use super::*;

    #[test]
    fn relief_names_axes_and_units_and_stays_small() {
        let values = blob(180.0);
        let grey = Raster { quantity: "grey level", unit: "", ..raster(&values) };
        let svg = relief("Relief", &grey, ColorScale::Linear).unwrap();
        assert_well_formed(&svg);
        assert!(svg.contains("x (mm)") && svg.contains("y (mm)") && svg.contains("grey level"));
        // 95 x 71 quads of some 40 bytes and as many for their paint.
        assert!(svg.len() < 600_000, "{}", svg.len());
    }

    #[test]
    fn without_a_scale_the_axes_are_in_pixels() {
        let values = blob(1.0);
        let svg = relief("Relief", &Raster { mm_per_pixel: None, ..raster(&values) }, ColorScale::Linear).unwrap();
        assert!(svg.contains("x (pixels)"));
    }

    #[test]
    fn dark_flat_and_single_pixel_images_are_drawn() {
        let dark = blob(0.0);
        let svg = relief("Relief", &raster(&dark), ColorScale::Linear).unwrap();
        assert_well_formed(&svg);
        assert!(svg.contains("dark: maximum 0"));
        assert!(svg.len() < 20_000, "a flat surface is a few strips: {}", svg.len());
        let one = [2.0];
        assert_well_formed(
            &relief("Relief", &Raster { width: 1, height: 1, values: &one, ..raster(&one) }, ColorScale::Linear)
                .unwrap(),
        );
    }

    #[test]
    fn a_logarithmic_relief_gives_each_decade_an_equal_height() {
        let values = blob(1.0);
        let linear = relief("Relief", &raster(&values), ColorScale::Linear).unwrap();
        let log = relief("Relief", &raster(&values), ColorScale::Log).unwrap();
        assert!(log.contains("logarithmic") && !linear.contains("logarithmic"));
        let stage = Stage::new(&raster(&values), Mapping { low: 1e-3, high: 1.0, log: true });
        for (value, height) in [(1.0, 1.0), (1e-1, 2.0 / 3.0), (1e-3, 0.0), (0.0, 0.0)] {
            assert!((stage.height(value) - height).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn higher_values_are_drawn_higher() {
        let values = blob(1.0);
        let stage = Stage::new(&raster(&values), Mapping { low: 0.0, high: 1.0, log: false });
        assert!(stage.project(0.0, 0.0, 1.0)[1] < stage.project(0.0, 0.0, 0.0)[1]);
        // Nearer points are lower in the picture.
        assert!(stage.project(1.0, -1.0, 0.0)[1] > stage.project(-1.0, 1.0, 0.0)[1]);
    }
}
