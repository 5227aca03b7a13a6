//! Tables of two columns from CSV: pressure against radius, an indenter's shape against the distance from its axis.

use super::data_file::{DataFileError, Defect};
use super::inputs::Input;

/// Largest table, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Most rows of a table.
const MAX_ROWS: usize = 10_000;
/// Columns of a pressure table.
const PRESSURE: [&str; 2] = ["r_mm", "pressure_kpa"];
/// Columns of an indenter's shape.
const INDENTER: [&str; 2] = ["x_mm", "below_mm"];
/// Reads a table of `r_mm,pressure_kpa`: radii ascending from 0 or more, pressures not negative, at least two rows.
///
/// # Errors
/// When the file is too large or breaks one of these rules.
pub fn read_pressure_table(input: &Input) -> Result<Vec<[f64; 2]>, DataFileError> {
    rows(input.at_most(MAX_BYTES)?, PRESSURE).map_err(|defect| defect.in_file(&input.path))
}

/// Reads a table of `x_mm,below_mm`: distances from an indenter's axis, ascending from 0, and how far its face lies
/// behind its tip there, not negative, 0 on the axis; at least two rows.
///
/// # Errors
/// When the file is too large or breaks one of these rules.
pub fn read_indenter_table(input: &Input) -> Result<Vec<[f64; 2]>, DataFileError> {
    indenter_rows(input.at_most(MAX_BYTES)?).map_err(|defect| defect.in_file(&input.path))
}

fn indenter_rows(bytes: &[u8]) -> Result<Vec<[f64; 2]>, Defect> {
    let rows = rows(bytes, INDENTER)?;
    match rows.first() {
        Some([0.0, 0.0]) => Ok(rows),
        first => {
            let [x, below] = first.copied().unwrap_or_default();
            Err(Defect::new(None, format!("the first row must be the tip, 0,0, is {x},{below}")))
        }
    }
}

fn rows(bytes: &[u8], header: [&str; 2]) -> Result<Vec<[f64; 2]>, Defect> {
    let [first, second] = header;
    let csv_error = |error: csv::Error| {
        let message = format!("must be UTF-8 text with two columns, {first},{second}, in every row");
        Defect::new(error.position().map(line_of), message)
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    if reader.headers().map_err(csv_error)?.iter().ne(header) {
        return Err(Defect::new(1, format!("must start with the line {first},{second}")));
    }
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for record in reader.records() {
        let record = record.map_err(csv_error)?;
        let line = record.position().map(line_of);
        let cell = |column: usize, name: &str| {
            let text = record.get(column).unwrap_or("");
            match text.parse::<f64>() {
                Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
                _ => Err(Defect::new(line, format!("{name} must be a finite number, zero or more, is {text:?}"))),
            }
        };
        let row = [cell(0, first)?, cell(1, second)?];
        if let Some(before) = rows.last()
            && row[0] <= before[0]
        {
            return Err(Defect::new(line, format!("{first} must ascend, is {} after {}", row[0], before[0])));
        }
        if rows.len() == MAX_ROWS {
            return Err(Defect::new(line, format!("must have at most {MAX_ROWS} rows")));
        }
        rows.push(row);
    }
    if rows.len() < 2 {
        let message = format!("must have at least 2 rows of {first},{second}, has {}", rows.len());
        return Err(Defect::new(None, message));
    }
    Ok(rows)
}

fn line_of(position: &csv::Position) -> usize {
    usize::try_from(position.line()).unwrap_or(usize::MAX)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::path::Path;

    fn read(text: &str) -> Result<Vec<[f64; 2]>, DataFileError> {
        rows(text.as_bytes(), PRESSURE).map_err(|defect| defect.in_file(Path::new("p.csv")))
    }

    #[test]
    fn a_table_is_read_in_order() {
        let table = read("r_mm, pressure_kpa\n# a comment\n0, 4.5\n1.5, 2\n3,0\n").unwrap();
        assert_eq!(table, [[0.0, 4.5], [1.5, 2.0], [3.0, 0.0]]);
    }

    #[test]
    fn a_bad_table_says_line_and_rule() {
        for (text, said) in [
            ("", "p.csv:1: must start with the line r_mm,pressure_kpa"),
            ("r,p\n0,1\n1,2\n", "p.csv:1: must start with the line r_mm,pressure_kpa"),
            ("r_mm,pressure_kpa\n0,1\n", "p.csv: must have at least 2 rows of r_mm,pressure_kpa, has 1"),
            ("r_mm,pressure_kpa\n0,1\n0,2\n", "p.csv:3: r_mm must ascend, is 0 after 0"),
            (
                "r_mm,pressure_kpa\n0,nan\n1,2\n",
                "p.csv:2: pressure_kpa must be a finite number, zero or more, is \"nan\"",
            ),
            ("r_mm,pressure_kpa\n-1,0\n1,2\n", "p.csv:2: r_mm must be a finite number, zero or more, is \"-1\""),
            (
                "r_mm,pressure_kpa\n0,1\n1\n",
                "p.csv:3: must be UTF-8 text with two columns, r_mm,pressure_kpa, in every row",
            ),
        ] {
            assert_eq!(read(text).unwrap_err().to_string(), said);
        }
    }

    #[test]
    fn an_indenter_starts_at_its_tip() {
        let said = |text: &str| indenter_rows(text.as_bytes()).map_err(|defect| defect.message);
        assert_eq!(said("x_mm,below_mm\n0,0\n2,0.1\n").unwrap(), [[0.0, 0.0], [2.0, 0.1]]);
        assert_eq!(said("x_mm,below_mm\n0,1\n2,2\n").unwrap_err(), "the first row must be the tip, 0,0, is 0,1");
        assert_eq!(said("r_mm,pressure_kpa\n0,0\n2,1\n").unwrap_err(), "must start with the line x_mm,below_mm");
    }

    proptest! {
        #[test]
        fn no_bytes_make_the_table_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut table = b"r_mm,pressure_kpa\n".to_vec();
            table.extend(bytes);
            let _ = rows(&table, PRESSURE);
        }
    }
}
