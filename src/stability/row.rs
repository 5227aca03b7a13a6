//! A row of the table: a number, what it should be, and how far off it may be.

use serde::Serialize;

/// What a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The tracer.
    Light,
    /// The finite elements.
    Mechanics,
    /// What is read from images.
    Image,
}

/// One extreme case with its reference and its error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What it is about.
    pub part: Part,
    /// The case.
    pub case: String,
    /// What is compared, with its unit.
    pub quantity: String,
    /// What computed it.
    pub computed_by: String,
    /// What it should be.
    pub reference: f64,
    /// Where that comes from.
    pub reference_is: String,
    /// What it is; NaN where it could not be computed.
    pub found: f64,
    /// How far off it is, in the measure that `allowed` names.
    pub error: f64,
    /// Largest error that passes.
    pub allowed: f64,
    /// Whether `error` is a share of the reference.
    pub relative: bool,
    /// Why so much is allowed, or why there is no value.
    pub reason: String,
    /// The verdict.
    pub passed: bool,
}

/// What a check knows of a row beside its numbers.
#[derive(Debug, Clone)]
pub struct Subject {
    part: Part,
    case: String,
    computed_by: String,
}

impl Subject {
    /// Rows of one case, computed by one thing.
    pub fn new(part: Part, case: impl Into<String>, computed_by: impl Into<String>) -> Self {
        Self { part, case: case.into(), computed_by: computed_by.into() }
    }

    /// Another case of the same.
    pub fn case(&self, case: impl Into<String>) -> Self {
        Self { case: case.into(), ..self.clone() }
    }

    /// The difference of `found` to `reference` is at most `allowed`.
    pub fn absolute(
        &self,
        quantity: impl Into<String>,
        [found, reference]: [f64; 2],
        reference_is: impl Into<String>,
        allowed: f64,
        reason: impl Into<String>,
    ) -> Row {
        let error = (found - reference).abs();
        self.row(quantity, [found, reference, error, allowed], reference_is, reason)
    }

    /// The same as a share of the reference.
    pub fn relative(
        &self,
        quantity: impl Into<String>,
        [found, reference]: [f64; 2],
        reference_is: impl Into<String>,
        allowed: f64,
        reason: impl Into<String>,
    ) -> Row {
        let error = (found / reference - 1.0).abs();
        Row { relative: true, ..self.row(quantity, [found, reference, error, allowed], reference_is, reason) }
    }

    /// `found` is greater than `bound`.
    pub fn above(
        &self,
        quantity: impl Into<String>,
        [found, bound]: [f64; 2],
        reference_is: impl Into<String>,
        reason: impl Into<String>,
    ) -> Row {
        let error = if found > bound { 0.0 } else { (bound - found).max(f64::MIN_POSITIVE) };
        self.row(quantity, [found, bound, error, 0.0], format!("to be exceeded: {}", reference_is.into()), reason)
    }

    /// `found` counts what must not happen.
    pub fn none(&self, quantity: impl Into<String>, found: f64, reason: impl Into<String>) -> Row {
        self.absolute(quantity, [found, 0.0], "must not happen", 0.0, reason)
    }

    /// Something holds (1) or does not (0).
    pub fn holds(&self, quantity: impl Into<String>, holds: bool, reason: impl Into<String>) -> Row {
        self.absolute(quantity, [f64::from(u8::from(holds)), 1.0], "must hold", 0.0, reason)
    }

    /// It could not be computed.
    pub fn failed(&self, why: impl Into<String>) -> Row {
        self.row("the case", [f64::NAN, 0.0, f64::INFINITY, 0.0], "a value", why)
    }

    fn row(
        &self,
        quantity: impl Into<String>,
        [found, reference, error, allowed]: [f64; 4],
        reference_is: impl Into<String>,
        reason: impl Into<String>,
    ) -> Row {
        Row {
            part: self.part,
            case: self.case.clone(),
            quantity: quantity.into(),
            computed_by: self.computed_by.clone(),
            reference,
            reference_is: reference_is.into(),
            found,
            // An error that is not a number passes nothing.
            error: if error.is_nan() { f64::INFINITY } else { error },
            allowed,
            relative: false,
            reason: reason.into(),
            passed: error <= allowed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_is_no_number_fails() {
        let subject = Subject::new(Part::Light, "a case", "a test");
        assert!(!subject.absolute("x", [f64::NAN, 0.0], "0", 1.0, "").passed);
        assert!(!subject.relative("x", [f64::NAN, 1.0], "1", 1.0, "").passed);
        assert!(!subject.failed("it broke").passed && !subject.holds("it", false, "").passed);
        let half = subject.relative("x", [1.5, 1.0], "1", 0.5, "");
        assert!(half.passed && half.relative && !subject.none("rays lost", 1.0, "").passed);
    }
}
