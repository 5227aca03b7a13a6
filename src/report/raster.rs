//! The image that a picture shows.

/// Values on a pixel grid with what they mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Raster<'a> {
    /// Columns.
    pub width: usize,
    /// Rows; row 0 is drawn at the top (positive y).
    pub height: usize,
    /// Values, row-major.
    pub values: &'a [f64],
    /// What the values are, such as "radiance" or "grey level".
    pub quantity: &'a str,
    /// Their unit, such as "W/(m^2 sr)"; empty where there is none.
    pub unit: &'a str,
    /// Millimetres on the touched face per pixel, on the axis. Absent: lengths are in pixels.
    pub mm_per_pixel: Option<f64>,
}

/// Why there is no picture.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PictureError {
    /// Width times height is not the number of values, or there are none.
    #[error("a picture of {width} x {height} pixels cannot have {values} values")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Number of values given.
        values: usize,
    },
    /// A number that cannot be drawn.
    #[error("{what} is {value}: it must be {allowed}")]
    Number {
        /// What it is.
        what: &'static str,
        /// The number.
        value: f64,
        /// What would be right.
        allowed: &'static str,
    },
    /// The bitmap cannot be encoded.
    #[error("bitmap: {0}")]
    Bitmap(String),
}

/// Means over blocks of pixels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Blocks {
    pub width: usize,
    pub height: usize,
    pub values: Vec<f64>,
}

impl Raster<'_> {
    pub(super) fn check(&self) -> Result<(), PictureError> {
        if self.values.is_empty() || self.width.checked_mul(self.height) != Some(self.values.len()) {
            return Err(PictureError::Size { width: self.width, height: self.height, values: self.values.len() });
        }
        if let Some(&value) = self.values.iter().find(|v| !v.is_finite()) {
            return Err(PictureError::Number { what: "a value of the picture", value, allowed: "finite" });
        }
        match self.mm_per_pixel {
            Some(value) if !(value > 0.0 && value.is_finite()) => {
                Err(PictureError::Number { what: "mm per pixel", value, allowed: "finite and above 0" })
            }
            _ => Ok(()),
        }
    }

    /// Least and greatest value; 0 and 0 of an empty raster.
    pub(super) fn range(&self) -> (f64, f64) {
        let first = self.values.first().copied().unwrap_or(0.0);
        self.values.iter().fold((first, first), |(low, high), &v| (low.min(v), high.max(v)))
    }

    /// Length of a pixel's edge in the unit of length, and that unit.
    pub(super) fn pixel_length(&self) -> (f64, &'static str) {
        self.mm_per_pixel.map_or((1.0, "pixels"), |mm| (mm, "mm"))
    }

    /// The quantity with its unit in brackets behind a power of ten: "radiance (10⁻³ W/(m^2 sr))".
    pub(super) fn quantity_label(&self, exponent: i32) -> String {
        let power = if exponent == 0 { String::new() } else { super::ticks::power_of_ten(exponent) };
        let unit = [power.as_str(), self.unit].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join(" ");
        if unit.is_empty() { self.quantity.to_owned() } else { format!("{} ({unit})", self.quantity) }
    }

    /// Means over at most `most_columns` by `most_rows` blocks of equal size; pixels on a border count in shares, so
    /// that neither noise nor slopes show the pattern of the blocks.
    pub(super) fn blocks(&self, most_columns: usize, most_rows: usize) -> Blocks {
        let (width, height) = (self.width.min(most_columns).max(1), self.height.min(most_rows).max(1));
        let mut narrow = Vec::with_capacity(width * self.height);
        for row in self.values.chunks_exact(self.width) {
            narrow.extend((0..width).map(|block| mean_over(row, 1, block, width)));
        }
        let mut values = vec![0.0; width * height];
        for column in 0..width {
            let below = narrow.get(column..).unwrap_or_default();
            for (block, value) in values.iter_mut().skip(column).step_by(width).enumerate() {
                *value = mean_over(below, width, block, height);
            }
        }
        Blocks { width, height, values }
    }
}

/// Mean over one of `blocks` equal stretches of every `stride`-th value.
fn mean_over(values: &[f64], stride: usize, block: usize, blocks: usize) -> f64 {
    let size = values.len().div_ceil(stride) as f64 / blocks as f64;
    let (from, to) = (block as f64 * size, (block + 1) as f64 * size);
    let first = from.floor() as usize;
    let taken = values.iter().step_by(stride).enumerate().skip(first).take_while(|(i, _)| (*i as f64) < to);
    taken.map(|(i, v)| v * (to.min(i as f64 + 1.0) - from.max(i as f64)).max(0.0)).sum::<f64>() / size
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) mod tests {
    use super::*;

    /// A Gaussian of the given peak in the middle of a 96 x 72 image with a column of noise-free zeros around.
    pub fn blob(peak: f64) -> Vec<f64> {
        let value = |i: usize| {
            let (x, y) = ((i % 96) as f64 + 0.5 - 48.0, (i / 96) as f64 + 0.5 - 36.0);
            peak * (-(x * x + y * y) / (2.0 * 9.0 * 9.0)).exp()
        };
        (0..96 * 72).map(value).collect()
    }

    pub fn raster(values: &[f64]) -> Raster<'_> {
        Raster { width: 96, height: 72, values, quantity: "radiance", unit: "W/(m^2 sr)", mm_per_pixel: Some(0.3) }
    }

    #[test]
    fn blocks_keep_the_mean_and_the_place() {
        let values = [1.0, 3.0, 10.0, 5.0, 7.0, 20.0];
        let r = Raster { width: 3, height: 2, values: &values, ..raster(&values) };
        assert_eq!(r.blocks(3, 2).values, values);
        assert!((r.blocks(1, 1).values[0] - 46.0 / 6.0).abs() < 1e-12);
        let narrow = r.blocks(2, 2);
        // The middle pixel counts half on either side: (1 + 3/2) / 1.5 and (3/2 + 10) / 1.5, below (5 + 7/2) / 1.5.
        for (got, expected) in narrow.values.iter().zip([2.5, 11.5, 8.5, 23.5]) {
            assert!((got - expected / 1.5).abs() < 1e-12, "{:?}", narrow.values);
        }
    }

    #[test]
    fn bad_rasters_are_typed_errors() {
        let short = [0.0; 5];
        assert!(matches!(raster(&short).check(), Err(PictureError::Size { .. })));
        let mut values = blob(1.0);
        values[7] = f64::NAN;
        assert!(matches!(raster(&values).check(), Err(PictureError::Number { .. })));
        let good = blob(1.0);
        let scaled = Raster { mm_per_pixel: Some(0.0), ..raster(&good) };
        assert!(scaled.check().unwrap_err().to_string().contains("mm per pixel"));
    }

    #[test]
    fn label_carries_unit_and_power_of_ten() {
        let values = blob(1.0);
        assert_eq!(raster(&values).quantity_label(-3), "radiance (10⁻³ W/(m^2 sr))");
        let grey = Raster { quantity: "grey level", unit: "", ..raster(&values) };
        assert_eq!(grey.quantity_label(0), "grey level");
    }
}
