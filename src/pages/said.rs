//! What a study has to say, whatever it is of.

use super::PageError;
use crate::output::Records;
use crate::report::Report;

/// What is said of a study.
pub struct Said {
    /// Name of the table, and it.
    pub table: (&'static str, String),
    /// The page.
    pub report: Report,
    /// In words.
    pub text: String,
    /// For programs.
    pub summary: serde_json::Value,
}

impl Said {
    /// Writes the table and the page.
    ///
    /// # Errors
    /// When they cannot be written.
    pub fn write(&self, records: &Records) -> Result<(), PageError> {
        records.write(self.table.0, &self.table.1)?;
        Ok(records.write("report.html", &self.report.to_html())?)
    }
}
