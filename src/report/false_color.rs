//! An image in false colour with scale bar and colour bar.
//!
//! The colours are matplotlib's inferno: even steps of lightness, black where it is dark, readable without colour
//! vision.

use super::marks::{self, Marks};
use super::raster::{Blocks, PictureError, Raster};
use super::svg::{Anchor, Svg, text_width};
use super::ticks;

/// How values become colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ColorScale {
    /// Logarithmic where the maximum is more than 100 times the 99th percentile of what is drawn, else linear.
    Auto,
    /// Linear from 0 (or the least value, where negative) to the maximum.
    Linear,
    /// Logarithmic from the least value above 0, at most four decades below the maximum; what is dimmer has the darkest
    /// colour.
    Log,
}

/// Decades of the logarithmic scale: about what an eye separates in 256 colours.
const LOG_DECADES: f64 = 4.0;
/// Longest side of the bitmap: what a screen shows of the picture.
const BITMAP_PX: usize = 900;

/// The rule from values to the share of the colour map, 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mapping {
    pub low: f64,
    pub high: f64,
    pub log: bool,
}

impl Mapping {
    pub fn choose(blocks: &Blocks, scale: ColorScale) -> Self {
        let mut sorted = blocks.values.clone();
        sorted.sort_by(f64::total_cmp);
        let high = sorted.last().copied().unwrap_or(0.0);
        let least = sorted.first().copied().unwrap_or(0.0);
        let percentile = sorted.get(sorted.len() * 99 / 100).copied().unwrap_or(0.0);
        let wants_log = match scale {
            ColorScale::Auto => percentile > 0.0 && high > 100.0 * percentile,
            ColorScale::Linear => false,
            ColorScale::Log => true,
        };
        if wants_log && high > 0.0 {
            let dimmest = sorted.iter().copied().find(|v| *v > 0.0).unwrap_or(high);
            // A decade at least: a uniform image is no gradient.
            let low = dimmest.clamp(high * 10f64.powf(-LOG_DECADES), 0.1 * high);
            Self { low, high, log: true }
        } else {
            Self { low: least.min(0.0), high: high.max(0.0), log: false }
        }
    }

    pub fn share(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.max(self.low) / self.low).log10() / (self.high / self.low).log10()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
    }
}

/// The colour at a share 0 to 1 of the map.
pub(crate) fn color(share: f64) -> [u8; 3] {
    let c = colorous::INFERNO.eval_continuous(share.clamp(0.0, 1.0));
    [c.r, c.g, c.b]
}

/// Draws an image in false colour as a self-contained SVG.
///
/// # Errors
/// Where the raster's size does not fit or a number is not finite.
pub fn false_color(title: &str, raster: &Raster, scale: ColorScale) -> Result<String, PictureError> {
    draw(title, raster, scale, None)
}

/// The same with what was measured drawn on it.
///
/// # Errors
/// As [`false_color`].
pub fn false_color_with(
    title: &str,
    raster: &Raster,
    scale: ColorScale,
    marks: &Marks,
) -> Result<String, PictureError> {
    draw(title, raster, scale, Some(marks))
}

fn draw(title: &str, raster: &Raster, scale: ColorScale, marks: Option<&Marks>) -> Result<String, PictureError> {
    raster.check()?;
    let (least, most) = raster.range();
    let dark = least == 0.0 && most == 0.0;
    let shrink = raster.width.max(raster.height).div_ceil(BITMAP_PX);
    let blocks = raster.blocks(raster.width.div_ceil(shrink), raster.height.div_ceil(shrink));
    let mapping = Mapping::choose(&blocks, scale);

    let aspect = raster.height as f64 / raster.width as f64;
    let image_width = 600f64.min(560.0 / aspect).max(4.0);
    let image_height = (image_width * aspect).max(4.0);
    let [x, y] = [24.0, 72.0];
    let bar_height = image_height.max(140.0);
    let legend = marks.map_or(0.0, |_| marks::LEGEND_PX);
    let (width, height) = ((image_width + 170.0).max(420.0), y + bar_height + 56.0 + legend);
    let mut svg = Svg::new(width, height, title, &subtitle(raster, most));

    let rgb: Vec<u8> = blocks.values.iter().flat_map(|&v| color(mapping.share(v))).collect();
    svg.bitmap([x, y, image_width, image_height], blocks.width, blocks.height, &rgb)?;
    svg.rect([x, y, image_width, image_height], r#"class="tt-hair""#);
    if dark {
        let middle = [x + 0.5 * image_width, y + 0.5 * image_height + 5.0];
        svg.text_with(middle, Anchor::Middle, r##"fill="#f0f0f0" font-size="15""##, "dark: maximum 0");
    } else {
        let bar = [x + image_width + 18.0, y, 18.0, bar_height];
        color_bar(&mut svg, bar, raster, &mapping)?;
    }
    scale_bar(&mut svg, [x, y + image_height + 26.0], image_width, raster);
    if let Some(marks) = marks {
        let legend_y = y + image_height + 26.0 + marks::LEGEND_PX;
        marks::draw(&mut svg, [x, y, image_width, image_height], raster, marks, legend_y);
    }
    Ok(svg.finish())
}

fn subtitle(raster: &Raster, most: f64) -> String {
    let unit = if raster.unit.is_empty() { String::new() } else { format!(" {}", raster.unit) };
    format!("{} × {} pixels · maximum {}{unit}", raster.width, raster.height, ticks::short(most))
}

fn color_bar(svg: &mut Svg, [x, y, w, h]: [f64; 4], raster: &Raster, mapping: &Mapping) -> Result<(), PictureError> {
    let steps = 256;
    let rgb: Vec<u8> = (0..steps).rev().flat_map(|i| color(i as f64 / (steps - 1) as f64)).collect();
    let (marks, exponent) = if mapping.log {
        (ticks::logarithmic(mapping.low, mapping.high), 0)
    } else {
        let ticks = ticks::linear(mapping.low, mapping.high, (h / 60.0) as usize);
        (ticks.marks, ticks.exponent)
    };
    svg.bitmap([x, y, w, h], 1, steps, &rgb)?;
    svg.rect([x, y, w, h], r#"class="tt-hair""#);
    let mut widest = 0.0f64;
    for (value, label) in marks {
        let at = y + h * (1.0 - mapping.share(value));
        svg.line([x + w, at], [x + w + 5.0, at], r#"class="tt-line""#);
        svg.text([x + w + 9.0, at + 4.5], Anchor::Start, "tt-ink", &label);
        widest = widest.max(text_width(&label));
    }
    let label = raster.quantity_label(exponent);
    let label = if mapping.log { format!("{label}, logarithmic") } else { label };
    svg.text_upward([x + w + 26.0 + widest, y + 0.5 * h], "tt-muted", &label);
    Ok(())
}

fn scale_bar(svg: &mut Svg, [x, y]: [f64; 2], image_width: f64, raster: &Raster) {
    let (pixel, unit) = raster.pixel_length();
    let across = pixel * raster.width as f64;
    let length = ticks::round_length(0.25 * across);
    let drawn = length / across * image_width;
    let unit = if length == 1.0 { unit.trim_end_matches('s') } else { unit };
    let label = format!("{} {unit}", ticks::short(length));
    svg.scale_bar([x, y], drawn, &label);
    if raster.mm_per_pixel.is_some() {
        let note = format!("touched face, on the axis: {} mm per pixel", ticks::short(pixel));
        if drawn + text_width(&label) + text_width(&note) + 30.0 < image_width {
            svg.text([x + image_width, y + 4.5], Anchor::End, "tt-muted", &note);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::raster::tests::{blob, raster};
    use super::super::svg::assert_well_formed;
    use super::*;

    #[test]
    fn picture_has_scale_bar_unit_and_an_inlined_bitmap() {
        let values = blob(0.42);
        let svg = false_color("Radiance", &raster(&values), ColorScale::Auto).unwrap();
        assert_well_formed(&svg);
        // 96 pixels of 0.3 mm are 28.8 mm; a quarter, rounded down.
        assert!(svg.contains(">5 mm<"), "scale bar");
        assert!(svg.contains("radiance (W/(m^2 sr))") && svg.contains("data:image/png;base64,"));
    }

    #[test]
    fn marks_stand_where_they_were_measured() {
        let values = blob(100.0);
        let grey = Raster { quantity: "grey level", unit: "", ..raster(&values) };
        let marks = Marks { threshold: 5.0, centroid_px: Some([48.0, 36.0]) };
        let svg = false_color_with("Frame", &grey, ColorScale::Linear, &marks).unwrap();
        assert_well_formed(&svg);
        // 96 pixels are 600 wide from 24, 72 are 450 high from 72: the middle is at 324, 297.
        assert!(svg.contains("M316 297l16 0") && svg.contains(">above grey level 5<"), "{svg}");
        let none = Marks { centroid_px: None, ..marks };
        assert!(!false_color_with("Frame", &grey, ColorScale::Linear, &none).unwrap().contains("centroid"));
    }

    #[test]
    fn dark_image_says_so() {
        let values = blob(0.0);
        let svg = false_color("Radiance", &raster(&values), ColorScale::Auto).unwrap();
        assert_well_formed(&svg);
        assert!(svg.contains("dark: maximum 0"));
        let lit = blob(1.0);
        assert!(!false_color("Radiance", &raster(&lit), ColorScale::Auto).unwrap().contains("dark:"));
    }

    #[test]
    fn automatic_scale_is_logarithmic_only_where_little_is_very_bright() {
        let mut values = blob(1.0);
        assert!(!false_color("a", &raster(&values), ColorScale::Auto).unwrap().contains("logarithmic"));
        values[0] = 1e4;
        assert!(false_color("a", &raster(&values), ColorScale::Auto).unwrap().contains("logarithmic"));
    }

    #[test]
    fn logarithmic_scale_gives_each_decade_an_equal_share() {
        let mapping = Mapping { low: 1e-4, high: 1.0, log: true };
        for (value, share) in [(1.0, 1.0), (1e-1, 0.75), (1e-3, 0.25), (0.0, 0.0), (-3.0, 0.0)] {
            assert!((mapping.share(value) - share).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn one_pixel_and_long_strips_are_drawn() {
        let values = [3.0; 50];
        for (width, height) in [(1, 1), (50, 1), (1, 50)] {
            let strip = Raster { width, height, values: &values[..width * height], ..raster(&values) };
            assert_well_formed(&false_color("strip", &strip, ColorScale::Auto).unwrap());
        }
    }
}
