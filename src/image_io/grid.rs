//! Grids of numbers: height fields, pressures, phase patterns, from EXR, PNG, TIFF or CSV.

use super::exr_chunks::ExrFile;
use super::grey::{from_exr, has_extension, is_exr, levels_of};
use super::{ImageError, limits};
use std::path::Path;

/// A rectangle of finite numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Columns.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
    /// Row-major, row 0 first in the file.
    pub values: Vec<f64>,
}

/// The grid of a file, from its bytes: the first channel of an EXR, the grey of a PNG or TIFF with full scale as 1, or
/// a CSV of numbers without a heading. The format is told by the extension of `path`.
///
/// # Errors
/// When the file is damaged, too large, of unequal rows, or holds what is not a finite number.
pub fn grid_of(path: &Path, bytes: &[u8]) -> Result<Grid, ImageError> {
    if has_extension(path, "csv") {
        return grid_of_csv(path, bytes);
    }
    let grey = match is_exr(path) {
        true => {
            let file = ExrFile::open(path, bytes)?;
            from_exr(path, [file.header.width, file.header.height], &file.channel(0)?)?
        }
        false => levels_of(path, bytes)?,
    };
    let scale = grey.full_scale.unwrap_or(1.0);
    let values = grey.values.iter().map(|value| value / scale).collect();
    Ok(Grid { columns: grey.width, rows: grey.height, values })
}

fn grid_of_csv(path: &Path, bytes: &[u8]) -> Result<Grid, ImageError> {
    let damaged = |reason: String| ImageError::Damaged { path: path.into(), reason };
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let (mut values, mut columns, mut rows) = (Vec::new(), 0, 0);
    for record in reader.records() {
        let record = record.map_err(|error| damaged(error.to_string()))?;
        rows += 1;
        if rows == 1 {
            columns = record.len();
        }
        if record.len() != columns {
            let reason = format!("row {rows} has {} numbers, the first row {columns}", record.len());
            return Err(damaged(reason));
        }
        limits::check_size(path, columns as u64, rows as u64)?;
        for (column, field) in record.iter().enumerate() {
            values.push(number(path, rows, column + 1, field)?);
        }
    }
    if values.is_empty() {
        return Err(damaged("it has no numbers".into()));
    }
    Ok(Grid { columns: columns as u32, rows: rows as u32, values })
}

fn number(path: &Path, row: usize, column: usize, field: &str) -> Result<f64, ImageError> {
    let number = field.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| ImageError::Value {
        path: path.into(),
        row,
        column,
        // A cell can be as long as the file; enough of it to be found is kept.
        found: format!("`{}`", field.chars().take(40).collect::<String>()),
        right: "a finite number",
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::write_png_grey;
    use super::*;

    fn csv(text: &str) -> Result<Grid, ImageError> {
        grid_of(Path::new("grid.CSV"), text.as_bytes())
    }

    #[test]
    fn a_csv_is_read_row_by_row() {
        let grid = csv("1, 2,3\n-4e2,5,.5\n").unwrap();
        assert_eq!((grid.columns, grid.rows), (3, 2));
        assert_eq!(grid.values, [1.0, 2.0, 3.0, -400.0, 5.0, 0.5]);
    }

    #[test]
    fn what_is_no_finite_number_is_named_by_row_and_column() {
        for bad in ["nan", "inf", "-inf", "1e999", "x", ""] {
            let error = csv(&format!("1,2\n3,{bad}\n")).unwrap_err();
            assert!(matches!(error, ImageError::Value { row: 2, column: 2, .. }), "{bad}: {error}");
        }
    }

    #[test]
    fn unequal_rows_and_empty_files_are_refused() {
        let error = csv("1,2\n3\n").unwrap_err().to_string();
        assert!(error.contains("row 2 has 1 numbers, the first row 2"), "{error}");
        assert!(csv("").is_err());
    }

    #[test]
    fn a_picture_is_read_with_full_scale_as_one() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("grid.png");
        write_png_grey(&path, 2, 1, &[65535, 13107], 16).unwrap();
        assert_eq!(grid_of(&path, &std::fs::read(&path).unwrap()).unwrap().values, [1.0, 0.2]);
    }
}
