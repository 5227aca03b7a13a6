//! Tables as CSV.

use super::PageError;

/// A table with its head.
///
/// # Errors
/// Rows of other lengths than the head.
pub fn table(
    file: &'static str,
    head: Vec<String>,
    rows: impl Iterator<Item = Vec<String>>,
) -> Result<String, PageError> {
    let failed = |error: csv::Error| PageError::Table { file, error: error.into() };
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(&head).map_err(failed)?;
    for row in rows {
        writer.write_record(&row).map_err(failed)?;
    }
    let bytes = writer.into_inner().map_err(|error| failed(error.into_error().into()))?;
    String::from_utf8(bytes).map_err(|error| failed(std::io::Error::other(error).into()))
}
