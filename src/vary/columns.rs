//! Tables of points: a column a variable.

use super::{MOST_POINTS, Scalar};

/// A design's table.
pub(super) struct Columns {
    /// Names of its columns.
    pub names: Vec<String>,
    /// Its rows, a cell for each.
    rows: Vec<Vec<Option<Scalar>>>,
}

impl Columns {
    /// Reads a table; says why it is none. Its head may begin with `#`, as numpy writes it.
    pub fn read(text: &str) -> Result<Self, String> {
        let text = text.trim_start_matches('\u{feff}');
        let text = text.strip_prefix('#').unwrap_or(text);
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let error = |error: csv::Error| format!("is no table: {error}");
        let names: Vec<String> = reader.headers().map_err(error)?.iter().map(str::to_owned).collect();
        if names.iter().any(String::is_empty) {
            return Err("has a column without a name".into());
        }
        if let Some((_, name)) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
            return Err(format!("has two columns {name}"));
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(error)?;
            if let Some(cell) = record.iter().find(|cell| cell.parse::<f64>().is_ok_and(|value| !value.is_finite())) {
                return Err(format!("holds {cell} in row {}, which is no value of a key", rows.len()));
            }
            rows.push(record.iter().map(|cell| (!cell.is_empty()).then(|| Scalar::of_cell(cell))).collect());
            if rows.len() as u64 > MOST_POINTS {
                return Err(format!("has more than {MOST_POINTS} points"));
            }
        }
        match rows.is_empty() {
            true => Err("has no points".into()),
            false => Ok(Self { names, rows }),
        }
    }

    /// Its rows with a cell for each variable, empty where it has no column.
    pub fn of<'a>(self, variables: impl Iterator<Item = &'a str>) -> Vec<Vec<Option<Scalar>>> {
        let places: Vec<_> = variables.map(|one| self.names.iter().position(|name| name == one)).collect();
        let row = |cells: Vec<Option<Scalar>>| places.iter().map(|place| cells.get((*place)?)?.clone()).collect();
        self.rows.into_iter().map(row).collect()
    }
}
