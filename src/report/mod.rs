//! Pictures, statistics and the report.
