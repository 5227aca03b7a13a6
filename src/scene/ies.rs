//! Luminous intensity tables in the IES LM-63 format, type C.
//!
//! The editions of 1986, 1991, 1995, 2002 and 2019 differ in their label lines, which end at `TILT=`; the numbers after
//! it are the same. An own reader: the one maintained crate for the format is under the AGPL, which this crate cannot
//! take on. Departures from the standard: `TILT=` with a file name is refused, candela are multiplied by the
//! multiplier and the ballast factor only (the third factor became a file-generation code in 2019), and a horizontal
//! range of 90 to 270 degrees is refused.

use super::data_file::{DataFileError, Defect};
use super::inputs::Input;

/// Largest file, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Most angles in each direction: half a degree over the full circle, both ends included.
const MAX_ANGLES: usize = 721;
/// Most label lines before `TILT=`.
const MAX_LABEL_LINES: usize = 1000;

/// Intensity against direction, expanded over its symmetry planes to the full circle.
#[derive(Debug, Clone, PartialEq)]
pub struct IesTable {
    /// Angles from the axis (the disc's normal), degrees, ascending within 0 to 180.
    pub vertical_deg: Vec<f64>,
    /// Angles around the axis, degrees, ascending from 0 to 360.
    pub horizontal_deg: Vec<f64>,
    /// Intensity, candela: one row for each horizontal angle, one value in it for each vertical angle.
    pub candela: Vec<Vec<f64>>,
}

impl IesTable {
    /// Intensity in candela at an angle from the axis and one around it, in degrees; bilinear, zero outside the
    /// vertical range of the table.
    pub fn intensity(&self, theta_deg: f64, phi_deg: f64) -> f64 {
        let vertical = cell(&self.vertical_deg, theta_deg);
        let horizontal = cell(&self.horizontal_deg, phi_deg.rem_euclid(360.0));
        let (Some((column, across)), Some((row, along))) = (vertical, horizontal) else {
            return 0.0;
        };
        let at = |row: usize, column: usize| self.candela.get(row).and_then(|r| r.get(column)).copied().unwrap_or(0.0);
        let in_row = |row| at(row, column) * (1.0 - across) + at(row, column + 1) * across;
        in_row(row) * (1.0 - along) + in_row(row + 1) * along
    }
}

/// The interval of an ascending list that holds a value, and the share of the way through it.
fn cell(angles: &[f64], value: f64) -> Option<(usize, f64)> {
    let (first, last) = (*angles.first()?, *angles.last()?);
    if !(first..=last).contains(&value) {
        return None;
    }
    let low = angles.partition_point(|&angle| angle <= value).saturating_sub(1).min(angles.len().saturating_sub(2));
    let (from, to) = (*angles.get(low)?, *angles.get(low + 1)?);
    Some((low, (value - from) / (to - from)))
}

/// Reads an IES file.
///
/// # Errors
/// When the file is too large, breaks the format, or emits nothing in front of the lamp.
pub fn read_ies(input: &Input) -> Result<IesTable, DataFileError> {
    // Labels may be in any encoding; the numbers are ASCII.
    parse(&String::from_utf8_lossy(input.at_most(MAX_BYTES)?)).map_err(|defect| defect.in_file(&input.path))
}

fn parse(text: &str) -> Result<IesTable, Defect> {
    let tilt = text.lines().take(MAX_LABEL_LINES).position(|line| line.trim_start().starts_with("TILT="));
    let Some(tilt_line) = tilt else {
        return Err(Defect::new(None, "has no TILT= line; is it an IES LM-63 file?"));
    };
    let tilt = text.lines().nth(tilt_line).unwrap_or("").trim().trim_start_matches("TILT=").trim();
    let mut numbers = Numbers::after_line(text, tilt_line + 1);
    match tilt {
        "NONE" => {}
        "INCLUDE" => {
            numbers.next("the lamp's geometry")?;
            let pairs = numbers.count("the number of tilt angles")?;
            for _ in 0..2 * pairs {
                numbers.next("a tilt angle or factor")?;
            }
        }
        other => {
            let message = format!("TILT must be NONE or INCLUDE, is {other:?}");
            return Err(Defect::new(tilt_line + 1, message));
        }
    }
    numbers.next("the number of lamps")?;
    numbers.next("the lumens per lamp")?;
    let multiplier = numbers.positive("the candela multiplier")?;
    let verticals = numbers.count("the number of vertical angles")?;
    let horizontals = numbers.count("the number of horizontal angles")?;
    let photometry = numbers.next("the photometric type")?;
    if photometry != 1.0 {
        return Err(numbers.defect(format!("the photometric type must be 1 (type C), is {photometry}")));
    }
    for what in ["the unit", "the width", "the length", "the height"] {
        numbers.next(what)?;
    }
    let ballast = numbers.positive("the ballast factor")?;
    numbers.next("the ballast-lamp factor")?;
    numbers.next("the input watts")?;

    let vertical_deg = numbers.angles(verticals, "vertical", 180.0)?;
    if vertical_deg.len() < 2 {
        return Err(numbers.defect("must have at least 2 vertical angles"));
    }
    let horizontal_deg = numbers.angles(horizontals, "horizontal", 360.0)?;
    let mut candela = Vec::with_capacity(horizontals);
    for _ in 0..horizontals {
        let row: Result<Vec<f64>, Defect> = (0..verticals)
            .map(|_| {
                let value = numbers.next("an intensity")?;
                if value < 0.0 {
                    return Err(numbers.defect(format!("an intensity must not be negative, is {value}")));
                }
                Ok(value * multiplier * ballast)
            })
            .collect();
        candela.push(row?);
    }
    let (horizontal_deg, candela) = over_full_circle(horizontal_deg, candela).map_err(|m| numbers.defect(m))?;
    let lit = |row: &Vec<f64>| row.iter().zip(&vertical_deg).any(|(&value, &angle)| value > 0.0 && angle < 90.0);
    if !candela.iter().any(lit) {
        return Err(numbers.defect("must have a positive intensity below 90 degrees, in front of the lamp"));
    }
    if candela.iter().flatten().any(|value| !value.is_finite()) {
        return Err(numbers.defect("the intensities times their factors must be finite"));
    }
    Ok(IesTable { vertical_deg, horizontal_deg, candela })
}

/// Mirrors a table given over a half or a quarter circle, and copies one that has a single plane.
fn over_full_circle(mut angles: Vec<f64>, mut rows: Vec<Vec<f64>>) -> Result<(Vec<f64>, Vec<Vec<f64>>), &'static str> {
    let wrong = "the horizontal angles must run from 0 to 0, 90, 180 or 360";
    if angles.first() != Some(&0.0) {
        return Err(wrong);
    }
    loop {
        let last = *angles.last().ok_or(wrong)?;
        if last == 360.0 {
            return Ok((angles, rows));
        } else if angles.len() == 1 {
            angles.push(360.0);
            rows.extend_from_within(..);
        } else if last == 90.0 || last == 180.0 {
            let mirrored = angles.iter().rev().skip(1).map(|angle| 2.0 * last - angle).collect::<Vec<_>>();
            let reversed = rows.iter().rev().skip(1).cloned().collect::<Vec<_>>();
            angles.extend(mirrored);
            rows.extend(reversed);
        } else {
            return Err(wrong);
        }
    }
}

/// The numbers of the file with the lines they stand on.
struct Numbers<'t> {
    tokens: Box<dyn Iterator<Item = (usize, &'t str)> + 't>,
    line: usize,
}

impl<'t> Numbers<'t> {
    fn after_line(text: &'t str, line: usize) -> Self {
        let tokens = text.lines().enumerate().skip(line).flat_map(|(index, content)| {
            let separated = content.split(|c: char| c.is_whitespace() || c == ',');
            separated.filter(|token| !token.is_empty()).map(move |token| (index + 1, token))
        });
        Self { tokens: Box::new(tokens), line }
    }

    fn defect(&self, message: impl Into<String>) -> Defect {
        Defect::new(self.line, message)
    }

    fn next(&mut self, what: &str) -> Result<f64, Defect> {
        let Some((line, token)) = self.tokens.next() else {
            return Err(self.defect(format!("ends before {what}")));
        };
        self.line = line;
        match token.parse() {
            Ok(value) if f64::is_finite(value) => Ok(value),
            _ => Err(self.defect(format!("{what} must be a finite number, is {token:?}"))),
        }
    }

    fn positive(&mut self, what: &str) -> Result<f64, Defect> {
        let value = self.next(what)?;
        if value > 0.0 { Ok(value) } else { Err(self.defect(format!("{what} must be positive, is {value}"))) }
    }

    fn count(&mut self, what: &str) -> Result<usize, Defect> {
        let value = self.next(what)?;
        if value.fract() != 0.0 || !(1.0..=MAX_ANGLES as f64).contains(&value) {
            return Err(self.defect(format!("{what} must be a whole number from 1 to {MAX_ANGLES}, is {value}")));
        }
        Ok(value as usize)
    }

    fn angles(&mut self, count: usize, which: &str, most: f64) -> Result<Vec<f64>, Defect> {
        let mut angles: Vec<f64> = Vec::with_capacity(count);
        for _ in 0..count {
            let angle = self.next("an angle")?;
            if !(0.0..=most).contains(&angle) || angles.last().is_some_and(|&before| angle <= before) {
                return Err(
                    self.defect(format!("the {which} angles must ascend from 0 to {most} degrees, one is {angle}"))
                );
            }
            angles.push(angle);
        }
        Ok(angles)
    }
}

#[cfg(test)]
#[path = "ies_tests.rs"]
mod tests;
