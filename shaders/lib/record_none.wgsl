// No event histories.
fn record(code: u32, margin: f32) {}
fn record_start(row: u32) {}
fn record_end(end: u32) {}
