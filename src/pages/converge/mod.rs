//! Ladders of error against run time.

pub mod pictures;
pub mod table;

use super::PageError;
use crate::converge::Ladders;
use crate::output::Records;

/// Writes the rungs as a table, and a picture of each family of ladders.
///
/// # Errors
/// When they cannot be written or drawn.
pub fn write(name: &str, found: &Ladders, records: &Records) -> Result<(), PageError> {
    records.write("converge.csv", &table::csv(&found.rungs)?)?;
    for (file, svg) in pictures::draw(name, &found.rungs)? {
        records.write(&file, &svg)?;
    }
    Ok(())
}
