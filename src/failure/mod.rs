//! What goes wrong, as its user reads it: one line that says what, where and what would be right, and who is to blame.
//!
//! Stages have errors of their own; the command line and the package for Python say them in these words.

mod of;

use crate::converge::ClimbError;
use crate::mechanics::path::PathError;
use crate::mechanics::press::{PressError, Pressed};
use crate::output::leftovers::{Leftovers, leftovers};
use crate::pipeline::PipelineError;
use crate::surface::SurfaceError;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Who is to blame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Wrong use of the command line.
    Usage,
    /// Bad input.
    Input,
    /// Nobody who asked for it.
    Failed,
    /// Who stopped it.
    Cancelled,
}

/// What went wrong: one line that says what, where, and what would be right.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    kind: Kind,
    message: String,
    file: Option<PathBuf>,
    line: Option<usize>,
    key: Option<String>,
    /// The other mistakes of a file that has several.
    others: Box<[Failure]>,
}

impl Failure {
    fn new(kind: Kind, message: impl Into<String>) -> Self {
        // One line, whatever was quoted in it.
        let message = message.into().split_whitespace().collect::<Vec<_>>().join(" ");
        Self { kind, message, file: None, line: None, key: None, others: Box::default() }
    }

    /// Wrong use of the command line (exit code 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, message)
    }

    /// Bad input (exit code 2). The message names its file itself.
    pub fn input(message: impl Into<String>) -> Self {
        Self::new(Kind::Input, message)
    }

    /// It failed for no fault of the user's (exit code 3).
    pub fn failed(message: impl Into<String>) -> Self {
        Self::new(Kind::Failed, message)
    }

    /// Stopped on request (exit code 3).
    #[must_use]
    pub fn cancelled() -> Self {
        Self::left(&leftovers())
    }

    /// The same, with what remains of the work.
    pub(crate) fn left(left: &Leftovers) -> Self {
        let line = format!("stopped on request; {}", left.remains().unwrap_or("nothing was written"));
        Self::new(Kind::Cancelled, line)
    }

    /// The file it is about.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        Self { file: Some(file.into()), ..self }
    }

    /// The line of that file, counted from 1.
    #[must_use]
    pub fn at_line(self, line: usize) -> Self {
        Self { line: Some(line), ..self }
    }

    /// The key in that file.
    #[must_use]
    pub fn at_key(self, key: impl Into<String>) -> Self {
        Self { key: Some(key.into()), ..self }
    }

    /// What the pipeline says of a scene, with the scene's file where that is to blame.
    #[must_use]
    pub fn of_scene(error: PipelineError, file: &Path) -> Self {
        let words = format!("{}: {error}", file.display());
        match error {
            PipelineError::Press(error) => PressFailure::of(error, file).failure,
            // A shape that does not fit its stack is a mistake of the scene file.
            PipelineError::Surface(SurfaceError::Shape { key, .. }) => Self::input(words).in_file(file).at_key(key),
            PipelineError::NoLight => Self::input(words).in_file(file).at_key("press.indenter"),
            PipelineError::NoBaseline => Self::usage(words).in_file(file),
            PipelineError::Surface(error) => error.into(),
            PipelineError::Trace(error) => error.into(),
            PipelineError::Exposure(error) => error.into(),
            PipelineError::Projection(error) => error.into(),
            PipelineError::Image(_) => Self::input(words).in_file(file),
            PipelineError::NoLoad { .. } => Self::failed(words).in_file(file),
        }
    }

    /// What stops a climb of a scene's ladders, with the scene's file where that is to blame.
    #[must_use]
    pub fn of_climb(error: ClimbError, file: &Path) -> Self {
        match error {
            ClimbError::Pipeline(error) => Self::of_scene(error, file),
            ClimbError::Light(error) => error.into(),
            ClimbError::Output(error) => error.into(),
        }
    }

    /// Who is to blame.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// File, line and key that it is about, as far as it says.
    #[must_use]
    pub fn place(&self) -> (Option<&Path>, Option<usize>, Option<&str>) {
        (self.file.as_deref(), self.line, self.key.as_deref())
    }

    /// Whether it says which file it is about.
    #[must_use]
    pub fn names_a_file(&self) -> bool {
        self.file.is_some()
    }

    /// The same with something before the message.
    #[must_use]
    pub fn prefixed(self, place: &str) -> Self {
        Self { message: format!("{place}: {}", self.message), ..self }
    }

    /// The line without the program's name.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The other mistakes of its file.
    #[must_use]
    pub fn others(&self) -> &[Self] {
        &self.others
    }

    /// The exit code that a command ends with: 2 or 3.
    #[must_use]
    pub fn code(&self) -> u8 {
        match self.kind {
            Kind::Usage | Kind::Input => 2,
            Kind::Failed | Kind::Cancelled => 3,
        }
    }

    /// The object that `--json` prints: the mistake, and with it all mistakes.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        let errors: Vec<_> = std::iter::once(self).chain(&self.others).map(Self::one_json).collect();
        json!({"error": self.one_json(), "errors": errors})
    }

    fn one_json(&self) -> serde_json::Value {
        let kind = match self.kind {
            Kind::Usage => "usage",
            Kind::Input => "input",
            Kind::Failed => "failed",
            Kind::Cancelled => "cancelled",
        };
        let file = self.file.as_ref().map(|file| file.display().to_string());
        json!({"kind": kind, "message": self.message, "file": file, "line": self.line, "key": self.key})
    }
}

/// A press that failed, and what it reached.
pub(crate) struct PressFailure {
    pub failure: Failure,
    pub reached: Option<Box<Pressed>>,
}

impl PressFailure {
    /// What a scene's press says, with the scene's file.
    pub fn of(error: PressError, file: &Path) -> Self {
        let words = format!("{}: {error}", file.display());
        let (failure, reached) = match error {
            PressError::Stopped { cause: PathError::Stopped, .. } => {
                return Self { failure: Failure::cancelled(), reached: None };
            }
            PressError::Stopped { reached, .. } => (Failure::failed(words), Some(reached)),
            _ => (Failure::input(words), None),
        };
        Self { failure: failure.in_file(file), reached }
    }
}
