//! The calibration file (TOML) that ties pixels and grey values to millimetres and newtons.
//!
//! ```toml
//! mm_per_pixel = 0.0215
//! bottom_area_mm2 = 900.0                                   # optional
//! force_n_from_sum_grey = [[1.0e5, 0.1], [8.0e5, 0.6]]      # optional: rows of (sum of grey values, force in N)
//! ```

use serde::Deserialize;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// What the camera's figures mean.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Millimetres on the touched face per pixel.
    pub mm_per_pixel: f64,
    /// Area C of the waveguide's bottom, mm^2. Absent: no pressure.
    pub bottom_area_mm2: Option<f64>,
    /// Force against the sum of grey values. Absent: no force.
    pub force_n_from_sum_grey: Option<ForceTable>,
}

/// Force against the sum of grey values, linear between rows.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceTable {
    rows: Vec<[f64; 2]>,
}

/// A force read from the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Force {
    /// The force, N.
    Inside(f64),
    /// The sum is outside the calibrated range.
    Outside {
        /// Least calibrated sum.
        least: f64,
        /// Greatest calibrated sum.
        most: f64,
    },
}

/// Why there is no calibration.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file cannot be read.
    #[error("{file}: {source}")]
    Read {
        /// The file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not a calibration: TOML syntax, an unknown or missing key, a wrong type.
    #[error("{file}:{line}: {message}")]
    Parse {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// A value outside its range.
    #[error("{file}:{line}: {key} {problem}")]
    Value {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// What is wrong and what would be right.
        problem: String,
    },
}

/// The file as written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    mm_per_pixel: Spanned<f64>,
    bottom_area_mm2: Option<Spanned<f64>>,
    force_n_from_sum_grey: Option<Spanned<Vec<[f64; 2]>>>,
}

impl Calibration {
    /// Reads a calibration file.
    ///
    /// # Errors
    /// Where the file cannot be read or is not a calibration; the error names file, line and key.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text, &file),
            Err(source) => Err(CalibrationError::Read { file, source }),
        }
    }

    /// Reads a calibration from text; `file` names it in errors.
    ///
    /// # Errors
    /// Where the text is not a calibration; the error names file, line and key.
    pub fn parse(text: &str, file: &str) -> Result<Self, CalibrationError> {
        let line_of = |span: Option<Range<usize>>| {
            let end = span.map_or(0, |s| s.start).min(text.len());
            1 + text.as_bytes().iter().take(end).filter(|&&b| b == b'\n').count()
        };
        if text.trim_start().starts_with('{') {
            let message = "is JSON, as what is learnt of frames is; the calibration of a sensor is TOML".to_owned();
            return Err(CalibrationError::Parse { file: file.to_owned(), line: 1, message });
        }
        let document: Document = toml::from_str(text).map_err(|error| CalibrationError::Parse {
            file: file.to_owned(),
            line: line_of(error.span()),
            message: error.message().to_owned(),
        })?;
        let wrong = |key: &'static str, span: Range<usize>, problem: String| CalibrationError::Value {
            file: file.to_owned(),
            line: line_of(Some(span)),
            key,
            problem,
        };
        let positive = |key: &'static str, value: &Spanned<f64>| {
            let v = *value.as_ref();
            if v > 0.0 && v.is_finite() {
                Ok(v)
            } else {
                Err(wrong(key, value.span(), format!("is {v}: it must be finite and above 0")))
            }
        };
        let table = document.force_n_from_sum_grey.map(|rows| {
            let span = rows.span();
            ForceTable::new(rows.into_inner()).map_err(|problem| wrong("force_n_from_sum_grey", span, problem))
        });
        Ok(Self {
            mm_per_pixel: positive("mm_per_pixel", &document.mm_per_pixel)?,
            bottom_area_mm2: document.bottom_area_mm2.as_ref().map(|v| positive("bottom_area_mm2", v)).transpose()?,
            force_n_from_sum_grey: table.transpose()?,
        })
    }
}

impl ForceTable {
    /// A table of (sum of grey values, force in N); both must be finite, sums rising, forces 0 or more and never
    /// falling.
    ///
    /// # Errors
    /// Says what is wrong with the rows.
    pub fn new(rows: Vec<[f64; 2]>) -> Result<Self, String> {
        if rows.len() < 2 {
            return Err(format!("has {} rows: it must have 2 or more of [sum of grey values, force in N]", rows.len()));
        }
        if let Some([m, f]) = rows.iter().find(|[m, f]| !(m.is_finite() && f.is_finite() && *f >= 0.0)) {
            return Err(format!("has the row [{m}, {f}]: both must be finite and the force 0 or more"));
        }
        for pair in rows.windows(2) {
            if let [[m0, f0], [m1, f1]] = pair
                && (m1 <= m0 || f1 < f0)
            {
                return Err(format!(
                    "has [{m1}, {f1}] after [{m0}, {f0}]: sums must rise and forces must not fall from row to row"
                ));
            }
        }
        Ok(Self { rows })
    }

    /// The force in N for a sum of grey values, inside the calibrated range.
    pub fn at(&self, sum: f64) -> Force {
        match (self.rows.first(), self.rows.last()) {
            (Some(&[least, _]), Some(&[most, _])) if !(least..=most).contains(&sum) => Force::Outside { least, most },
            _ => Force::Inside(self.extended(sum)),
        }
    }

    /// As [`ForceTable::at`], the first and last pieces running on beyond the range (for the ends of intervals), in N.
    pub fn extended(&self, sum: f64) -> f64 {
        let last_piece = self.rows.len().saturating_sub(2);
        let piece = self.rows.partition_point(|[m, _]| *m <= sum).saturating_sub(1).min(last_piece);
        match self.rows.get(piece..piece + 2) {
            Some(&[[m0, f0], [m1, f1]]) => f0 + (sum - m0) * ((f1 - f0) / (m1 - m0)),
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        Calibration::parse(text, "c.toml").unwrap_err().to_string()
    }

    #[test]
    fn force_is_linear_between_rows_and_refused_outside() {
        let table = ForceTable::new(vec![[10.0, 1.0], [20.0, 2.0], [40.0, 2.5]]).unwrap();
        assert_eq!(table.at(10.0), Force::Inside(1.0));
        assert_eq!(table.at(15.0), Force::Inside(1.5));
        assert_eq!(table.at(30.0), Force::Inside(2.25));
        assert_eq!(table.at(40.0), Force::Inside(2.5));
        assert_eq!(table.at(9.9), Force::Outside { least: 10.0, most: 40.0 });
        assert_eq!(table.at(40.1), Force::Outside { least: 10.0, most: 40.0 });
        assert_eq!(table.extended(0.0), 0.0);
        assert_eq!(table.extended(80.0), 3.5);
    }

    #[test]
    fn scale_alone_is_a_calibration() {
        let c = Calibration::parse("mm_per_pixel = 0.02\n", "c.toml").unwrap();
        assert_eq!((c.mm_per_pixel, c.bottom_area_mm2), (0.02, None));
    }

    #[test]
    fn errors_name_file_line_and_key() {
        assert_eq!(
            error("# scale\n\nmm_per_pixel = -1.0\n"),
            "c.toml:3: mm_per_pixel is -1: it must be finite and above 0"
        );
        assert!(error("mm_per_pixel = 1.0\nwidth = 3\n").starts_with("c.toml:2: unknown field `width`"));
        assert!(error("bottom_area_mm2 = 1.0\n").contains("mm_per_pixel"));
        assert!(error("mm_per_pixel = \n").starts_with("c.toml:1:"));
        assert!(error("{\"version\": 1}").contains("is JSON"));
        let table = |rows: &str| error(&format!("mm_per_pixel = 1.0\nforce_n_from_sum_grey = {rows}\n"));
        assert!(table("[[1.0, 2.0]]").starts_with("c.toml:2: force_n_from_sum_grey has 1 rows"));
        assert!(table("[[1.0, 2.0], [1.0, 3.0]]").contains("sums must rise"));
        assert!(table("[[1.0, 2.0], [2.0, 1.0]]").contains("must not fall"));
        assert!(table("[[1.0, nan], [2.0, 1.0]]").contains("finite"));
    }

    #[test]
    fn missing_file_is_an_error_with_its_name() {
        let error = Calibration::load(Path::new("no/such/calibration.toml")).unwrap_err().to_string();
        assert!(error.starts_with("no/such/calibration.toml: "), "{error}");
    }
}
