//! Frames as tables: `position_mm,x_mm,pressure_kpa`, one row a sample, frame after frame.

use super::{Features, Frame, Frames};
use crate::scene::DataFileError;
use std::fs::File;
use std::io::{Read, Take};
use std::path::Path;

/// Largest table, bytes: half a million samples.
const MAX_BYTES: u64 = 32 << 20;
/// Most frames.
const MAX_FRAMES: usize = 10_000;
/// The columns, in order.
const HEADER: [&str; 3] = ["position_mm", "x_mm", "pressure_kpa"];

/// A broken rule and its line.
struct Defect {
    kind: &'static str,
    line: Option<usize>,
    message: String,
}

/// Reads measured or computed frames from a CSV of `position_mm,x_mm,pressure_kpa`, frame after frame by ascending
/// position, places ascending within a frame and the same in all. Lines that begin with # are comments.
///
/// # Errors
/// When the file cannot be read, is too large, or breaks one of these rules; the error names the line.
pub fn read_frames(path: &Path) -> Result<Frames, DataFileError> {
    let in_file =
        |d: Defect| DataFileError { kind: d.kind, file: path.to_path_buf(), line: d.line, message: d.message };
    let file = File::open(path).map_err(|e| in_file(unreadable(&e)))?;
    parse(file.take(MAX_BYTES + 1)).map_err(in_file)
}

fn unreadable(cause: &std::io::Error) -> Defect {
    Defect { kind: "io", line: None, message: format!("cannot be read: {cause}") }
}

fn bad(line: impl Into<Option<usize>>, message: impl Into<String>) -> Defect {
    Defect { kind: "bad_file", line: line.into(), message: message.into() }
}

fn parse<R: Read>(mut limited: Take<R>) -> Result<Frames, Defect> {
    let mut bytes = Vec::new();
    limited.read_to_end(&mut bytes).map_err(|e| unreadable(&e))?;
    if bytes.len() as u64 > MAX_BYTES {
        let message = format!("is larger than the limit of {MAX_BYTES} bytes");
        return Err(Defect { kind: "too_large", line: None, message });
    }
    let csv_error = |error: csv::Error| {
        let message = "must be UTF-8 text with three columns, position_mm,x_mm,pressure_kpa, in every row";
        bad(error.position().map(line_of), message)
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(&bytes[..]);
    if reader.headers().map_err(csv_error)?.iter().ne(HEADER) {
        return Err(bad(1, format!("must start with the line {}", HEADER.join(","))));
    }
    let mut frames: Vec<Frame> = Vec::new();
    let mut last_line = None;
    for record in reader.records() {
        let record = record.map_err(csv_error)?;
        last_line = record.position().map(line_of);
        add_row(&mut frames, numbers(&record, last_line)?, last_line)?;
    }
    check_length(&frames, last_line)?;
    // What is left for this check is a frame of one place.
    Frames::new(frames).map_err(|error| bad(last_line, error.to_string()))
}

fn numbers(record: &csv::StringRecord, line: Option<usize>) -> Result<[f64; 3], Defect> {
    let mut row = [0.0; 3];
    for ((value, name), text) in row.iter_mut().zip(HEADER).zip(record.iter()) {
        *value = match text.parse::<f64>() {
            Ok(number) if number.is_finite() => number,
            _ => return Err(bad(line, format!("{name} must be a finite number, is {text:?}"))),
        };
    }
    Ok(row)
}

/// Adds a row to the frame that it belongs to, or begins the next.
fn add_row(frames: &mut Vec<Frame>, [position_mm, x, pressure]: [f64; 3], line: Option<usize>) -> Result<(), Defect> {
    let before = frames.last().map(|frame| frame.position_mm);
    if before != Some(position_mm) {
        if let Some(before) = before
            && position_mm < before
        {
            return Err(bad(line, format!("position_mm must not fall, is {position_mm} after {before}")));
        }
        check_length(frames, line)?;
        if frames.len() == MAX_FRAMES {
            return Err(bad(line, format!("must have at most {MAX_FRAMES} positions")));
        }
        frames.push(Frame { position_mm, x_mm: Vec::new(), pressure_kpa: Vec::new() });
    }
    let place = frames.last().map_or(0, |frame| frame.x_mm.len());
    let expected = if frames.len() > 1 { frames.first().map(|first| first.x_mm.get(place).copied()) } else { None };
    match expected {
        Some(Some(first)) if first == x => {}
        Some(Some(first)) => {
            return Err(bad(line, format!("x_mm must be {first} as in the first frame, is {x}")));
        }
        Some(None) => return Err(bad(line, "must not have more places than the first frame")),
        None => {}
    }
    let Some(frame) = frames.last_mut() else {
        return Ok(());
    };
    if let Some(&before) = frame.x_mm.last()
        && x <= before
    {
        return Err(bad(line, format!("x_mm must ascend, is {x} after {before}")));
    }
    frame.x_mm.push(x);
    frame.pressure_kpa.push(pressure);
    Ok(())
}

/// The last frame must have as many places as the first.
fn check_length(frames: &[Frame], line: Option<usize>) -> Result<(), Defect> {
    match (frames.first(), frames.last()) {
        (Some(first), Some(last)) if last.x_mm.len() < first.x_mm.len() => {
            let (has, needed) = (last.x_mm.len(), first.x_mm.len());
            let position = last.position_mm;
            Err(bad(line, format!("the frame at {position} mm has {has} places, the first frame {needed}")))
        }
        _ => Ok(()),
    }
}

fn line_of(position: &csv::Position) -> usize {
    usize::try_from(position.line()).unwrap_or(usize::MAX)
}

/// The frames as a CSV that [`read_frames`] reads back exactly.
pub fn frames_csv(frames: &Frames) -> String {
    let mut csv = HEADER.join(",") + "\n";
    for frame in frames.as_slice() {
        for (x, p) in frame.x_mm.iter().zip(&frame.pressure_kpa) {
            csv.push_str(&format!("{},{x},{p}\n", frame.position_mm));
        }
    }
    csv
}

/// The features as a CSV: an undefined one is an empty cell, and the last column says why.
pub fn features_csv(features: &[Features]) -> String {
    let mut csv = "position_mm,peak_kpa,base_kpa,center_mm,fwhm_mm,eccentricity,undefined\n".to_owned();
    for f in features {
        let cells = [&f.peak_kpa, &f.base_kpa, &f.center_mm, &f.fwhm_mm, &f.eccentricity];
        let mut reasons: Vec<&str> = cells.iter().filter_map(|cell| cell.reason()).collect();
        reasons.dedup();
        let cells = cells.map(|cell| cell.value().map_or(String::new(), |v| v.to_string()));
        // The reasons are ours and hold no quotation marks.
        csv.push_str(&format!("{},{},\"{}\"\n", f.position_mm, cells.join(","), reasons.join("; ")));
    }
    csv
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
