//! A grey image as the estimators see it.

use crate::camera::Frame;

/// Grey values with what the camera's limits did to them.
#[derive(Debug, Clone, PartialEq)]
pub struct GreyImage {
    width: usize,
    height: usize,
    grey: Vec<f64>,
    /// The camera's top grey level, where known.
    top_grey: Option<f64>,
    /// Of each pixel, before any subtraction.
    is_saturated: Vec<bool>,
}

/// Why there is no image to estimate from.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GreyImageError {
    /// Width times height is not the number of values, or there are none.
    #[error("an image of {width} x {height} pixels cannot have {values} values")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Number of values given.
        values: usize,
    },
    /// A value that is not a number.
    #[error("grey value of column {column}, row {row} is {value}: it must be finite")]
    NotFinite {
        /// Column.
        column: usize,
        /// Row.
        row: usize,
        /// The value.
        value: f64,
    },
    /// Image and reference differ in size.
    #[error("the reference has {reference_width} x {reference_height} pixels, the image {width} x {height}")]
    ReferenceSize {
        /// Columns of the image.
        width: usize,
        /// Rows of the image.
        height: usize,
        /// Columns of the reference.
        reference_width: usize,
        /// Rows of the reference.
        reference_height: usize,
    },
    /// Image and reference count grey levels to different ends, so that their difference means nothing.
    #[error("the reference's {}, the image's {}; both must be of one depth", ends(reference), ends(image))]
    ReferenceDepth {
        /// Top grey level of the image; none where its values are no grey levels.
        image: Option<f64>,
        /// Top grey level of the reference.
        reference: Option<f64>,
    },
}

fn ends(top_grey: &Option<f64>) -> String {
    top_grey.map_or_else(|| "values are no grey levels".into(), |top| format!("grey levels end at {top}"))
}

impl GreyImage {
    /// An image of row-major grey values; pixels at `top_grey` and above count as saturated (`None`: unknown, none do).
    ///
    /// # Errors
    /// Where the size does not fit or a value is not finite.
    pub fn new(width: usize, height: usize, grey: &[f64], top_grey: Option<f64>) -> Result<Self, GreyImageError> {
        if grey.is_empty() || width.checked_mul(height) != Some(grey.len()) {
            return Err(GreyImageError::Size { width, height, values: grey.len() });
        }
        if let Some((i, &value)) = grey.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return Err(GreyImageError::NotFinite { column: i % width, row: i / width, value });
        }
        let is_saturated = grey.iter().map(|&v| top_grey.is_some_and(|top| v >= top)).collect();
        Ok(Self { width, height, grey: grey.to_vec(), top_grey, is_saturated })
    }

    /// The image of a camera frame.
    ///
    /// # Errors
    /// Where the frame's size does not fit its values.
    pub fn from_frame(frame: &Frame) -> Result<Self, GreyImageError> {
        let grey: Vec<f64> = frame.grey.iter().copied().map(f64::from).collect();
        Self::new(frame.width as usize, frame.height as usize, &grey, Some(f64::from(frame.top_grey())))
    }

    /// This image less a reference frame (no inclusion, or no press). Thresholds then apply to the difference.
    ///
    /// Negative differences are kept: clamping them at 0 would turn noise of standard deviation sigma into a background
    /// of 0.4 sigma per pixel, which adds to the sum of grey values and pulls the centroid to the middle of the image.
    ///
    /// # Errors
    /// Where the sizes or the top grey levels differ.
    pub fn minus(&self, reference: &GreyImage) -> Result<Self, GreyImageError> {
        if (self.width, self.height) != (reference.width, reference.height) {
            return Err(GreyImageError::ReferenceSize {
                width: self.width,
                height: self.height,
                reference_width: reference.width,
                reference_height: reference.height,
            });
        }
        if self.top_grey != reference.top_grey {
            return Err(GreyImageError::ReferenceDepth { image: self.top_grey, reference: reference.top_grey });
        }
        let grey = self.grey.iter().zip(&reference.grey).map(|(a, b)| a - b).collect();
        Ok(Self { grey, is_saturated: self.is_saturated.clone(), ..*self })
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Grey values, row-major.
    pub fn grey(&self) -> &[f64] {
        &self.grey
    }

    /// The camera's top grey level, where known.
    pub fn top_grey(&self) -> Option<f64> {
        self.top_grey
    }

    /// Pixels at the top grey level of the camera, before any subtraction.
    pub fn saturated_pixels(&self) -> usize {
        self.is_saturated.iter().filter(|is| **is).count()
    }

    /// Number of pixels brighter than `threshold` grey levels.
    pub fn brighter_than(&self, threshold: f64) -> usize {
        self.grey.iter().filter(|&&v| v > threshold).count()
    }

    /// Whether a pixel, row-major, is at the top grey level.
    pub fn is_saturated(&self, pixel: usize) -> bool {
        self.is_saturated.get(pixel).is_some_and(|is| *is)
    }

    /// Whether a pixel that tells of the grey value at a point (column, row) is saturated.
    pub fn is_saturated_at(&self, place: [f64; 2]) -> bool {
        let around = Self::around(place, [self.width, self.height]);
        around.into_iter().any(|(pixel, weight)| weight > 0.0 && self.is_saturated(pixel))
    }

    /// Grey value at a point (column, row) of the image, bilinear between pixel centres, constant beyond the outermost.
    pub fn at(&self, place: [f64; 2]) -> f64 {
        let value = |(pixel, weight): (usize, f64)| weight * self.grey.get(pixel).copied().unwrap_or(0.0);
        Self::around(place, [self.width, self.height]).into_iter().map(value).sum()
    }

    /// The four pixels about a point of an image of so many columns and rows, with their bilinear weights.
    pub(super) fn around([column, row]: [f64; 2], [width, height]: [usize; 2]) -> [(usize, f64); 4] {
        let split = |x: f64, count: usize| {
            let last = count.saturating_sub(1);
            let x = (x - 0.5).clamp(0.0, last as f64);
            let first = x.floor();
            (first as usize, (first as usize + 1).min(last), x - first)
        };
        let (c0, c1, u) = split(column, width);
        let (r0, r1, v) = split(row, height);
        let upper = [(r0 * width + c0, (1.0 - u) * (1.0 - v)), (r0 * width + c1, u * (1.0 - v))];
        let lower = [(r1 * width + c0, (1.0 - u) * v), (r1 * width + c1, u * v)];
        [upper[0], upper[1], lower[0], lower[1]]
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn bilinear_value_meets_the_pixels_at_their_centres_and_the_plane_between() {
        let plane: Vec<f64> = (0..12).map(|i| f64::from(i % 4) + 10.0 * f64::from(i / 4)).collect();
        let image = GreyImage::new(4, 3, &plane, None).unwrap();
        assert_eq!(image.at([0.5, 0.5]), 0.0);
        assert_eq!(image.at([3.5, 2.5]), 23.0);
        assert!((image.at([1.75, 1.25]) - (1.25 + 7.5)).abs() < 1e-12);
        assert_eq!(image.at([-9.0, 99.0]), 20.0);
    }

    #[test]
    fn subtraction_keeps_negative_differences_and_the_count_of_saturated_pixels() {
        let image = GreyImage::new(2, 1, &[255.0, 3.0], Some(255.0)).unwrap();
        let reference = GreyImage::new(2, 1, &[5.0, 4.0], Some(255.0)).unwrap();
        let difference = image.minus(&reference).unwrap();
        assert_eq!(difference.grey(), [250.0, -1.0]);
        assert_eq!(difference.saturated_pixels(), 1);
        // At the middle of the second pixel the first has no weight.
        assert!(difference.is_saturated_at([0.5, 0.5]) && difference.is_saturated_at([1.2, 0.5]));
        assert!(!difference.is_saturated_at([1.5, 0.5]));
    }

    #[test]
    fn a_reference_of_another_depth_is_refused() {
        let image = |top| GreyImage::new(1, 1, &[1.0], top).unwrap();
        let refused = image(Some(255.0)).minus(&image(Some(65535.0))).unwrap_err();
        assert_eq!(refused, GreyImageError::ReferenceDepth { image: Some(255.0), reference: Some(65535.0) });
        assert!(image(Some(255.0)).minus(&image(None)).is_err(), "grey levels less radiances");
        assert!(image(None).minus(&image(None)).is_ok());
    }

    #[test]
    fn wrong_sizes_and_values_are_typed_errors() {
        assert!(matches!(GreyImage::new(0, 0, &[], None), Err(GreyImageError::Size { .. })));
        assert!(matches!(GreyImage::new(2, 2, &[0.0; 3], None), Err(GreyImageError::Size { .. })));
        assert!(matches!(GreyImage::new(usize::MAX, 2, &[0.0; 3], None), Err(GreyImageError::Size { .. })));
        let nan = GreyImage::new(2, 1, &[0.0, f64::NAN], None);
        assert!(matches!(nan, Err(GreyImageError::NotFinite { column: 1, row: 0, .. })));
        let a = GreyImage::new(2, 1, &[0.0, 1.0], None).unwrap();
        let b = GreyImage::new(1, 2, &[0.0, 1.0], None).unwrap();
        assert!(matches!(a.minus(&b), Err(GreyImageError::ReferenceSize { .. })));
    }
}
