//! How a command ends.

use super::pressing::PressFailure;
use crate::camera::ProjectionError;
use crate::camera::exposure::ExposureError;
use crate::converge::light::LightError;
use crate::estimate::CalibrationError;
use crate::estimate::tissue::TissueError;
use crate::film::compare::CompareError;
use crate::image_io::ImageError;
use crate::mechanics::frames::scan::ScanError;
use crate::mechanics::press::PressError;
use crate::output::{OutputError, Remedy};
use crate::pages::PageError;
use crate::pipeline::PipelineError;
use crate::report::{PictureError, VtuError};
use crate::scene::{DataFileError, SceneError};
use crate::stability::StabilityError;
use crate::surface::SurfaceError;
use crate::trace::TraceError;
use serde_json::json;
use std::path::{Path, PathBuf};

/// How a command ended that did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done (exit code 0).
    Done,
    /// It ran, and the check it makes did not hold (exit code 1).
    CheckFailed,
}

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

/// Why a command failed: one line that says what, where, and what would be right.
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
        Self::stopped(super::cancel::line())
    }

    /// The same in given words.
    pub(super) fn stopped(line: String) -> Self {
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

    /// 2 or 3.
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

    /// Says it, on standard error and for `--json` as an object on standard output, and gives the exit code.
    pub(super) fn report(&self, json: bool) -> u8 {
        super::note(&self.message);
        if !self.others.is_empty() {
            super::note(&format!("and {} more:", self.others.len()));
        }
        self.others.iter().for_each(|other| super::note(&other.message));
        if json {
            // Standard error has said it already, so a closed standard output hides nothing.
            let _ = super::write_line(&self.json().to_string());
        }
        self.code()
    }
}

/// Errors of which each is of one kind.
macro_rules! plain {
    ($($error:ty => $kind:ident),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::$kind(error.to_string())
            }
        })*
    };
}

plain! {
    CompareError => input,
    ExposureError => input,
    ProjectionError => input,
    crate::estimate::GreyImageError => input,
    PictureError => failed,
    VtuError => failed,
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        let failure = match &error {
            ImageError::Write { .. } => Self::failed(error.to_string()),
            ImageError::Value { row, .. } => Self::input(error.to_string()).at_line(*row),
            _ => Self::input(error.to_string()),
        };
        failure.in_file(error.path())
    }
}

impl From<PageError> for Failure {
    fn from(error: PageError) -> Self {
        match error {
            PageError::Output(error) => error.into(),
            PageError::Image(error) => error.into(),
            PageError::Projection(error) => error.into(),
            PageError::Case(error) => error.into(),
            PageError::Picture(error) => error.into(),
            PageError::Vtu { .. } | PageError::Table { .. } => Self::failed(error.to_string()),
        }
    }
}

impl From<StabilityError> for Failure {
    fn from(error: StabilityError) -> Self {
        match error {
            StabilityError::Trace(error) => error.into(),
            error => Self::failed(error.to_string()),
        }
    }
}

impl From<LightError> for Failure {
    fn from(error: LightError) -> Self {
        match error {
            LightError::Surface(error) => error.into(),
            LightError::Trace(error) => error.into(),
            LightError::Size => Self::failed(error.to_string()),
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        let words = error.to_string();
        match error {
            OutputError::Refused { place, remedy, .. } => {
                let help = match remedy {
                    Remedy::Mend => "",
                    Remedy::Elsewhere => "; `--out` names another folder",
                    Remedy::Replace => "; `--force` replaces it, `--out` names another",
                    Remedy::GoOn => "; `--resume` goes on with it, `--force` replaces it, `--out` names another",
                };
                Self::input(words + help).in_file(&place)
            }
            OutputError::Failed { place, .. } => Self::failed(words).in_file(&place),
            OutputError::Image(error) => error.into(),
            OutputError::Stopped => Self::cancelled(),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        let failure = Self::input(error.to_string()).in_file(&error.file);
        let others = error.others.into_iter().map(Self::from).collect();
        Self { line: error.line, key: error.key, others, ..failure }
    }
}

impl From<SurfaceError> for Failure {
    fn from(error: SurfaceError) -> Self {
        let failure = Self::input(error.to_string());
        match error {
            SurfaceError::File { key, file, .. } => failure.in_file(&file).at_key(key),
            SurfaceError::Shape { key, .. } => failure.at_key(key),
        }
    }
}

impl From<TraceError> for Failure {
    fn from(error: TraceError) -> Self {
        match error {
            TraceError::Unsuited(_) => Self::usage(error.to_string()),
            TraceError::Stopped => Self::cancelled(),
            TraceError::NotFinite { .. } => Self::input(error.to_string()),
            TraceError::Overflow { .. }
            | TraceError::NoAdapter
            | TraceError::DeviceLost(_)
            | TraceError::Memory { .. }
            | TraceError::Driver(_)
            | TraceError::Lost { .. }
            | TraceError::Truncated { .. }
            | TraceError::CutShort { .. } => Self::failed(error.to_string()),
        }
    }
}

impl From<DataFileError> for Failure {
    fn from(error: DataFileError) -> Self {
        let failure = Self::input(error.to_string()).in_file(&error.file);
        Self { line: error.line, ..failure }
    }
}

impl From<PressError> for Failure {
    fn from(error: PressError) -> Self {
        match error {
            PressError::File(file) => file.into(),
            _ => Self::input(error.to_string()),
        }
    }
}

impl From<ScanError> for Failure {
    fn from(error: ScanError) -> Self {
        match error {
            ScanError::Mesh(_) | ScanError::Material(_) | ScanError::Truth(_) => Self::input(error.to_string()),
            ScanError::File(file) => file.into(),
            ScanError::Position { .. } | ScanError::Force { .. } | ScanError::Frames(_) => {
                Self::failed(error.to_string())
            }
            ScanError::Stopped => Self::cancelled(),
        }
    }
}

impl From<TissueError> for Failure {
    fn from(error: TissueError) -> Self {
        match error {
            TissueError::Scan(error) => error.into(),
            TissueError::Scene { key, .. } => Self::input(error.to_string()).at_key(key),
            TissueError::Unpressed(_) => Self::failed(error.to_string()),
            _ => Self::input(error.to_string()),
        }
    }
}

impl From<CalibrationError> for Failure {
    fn from(error: CalibrationError) -> Self {
        let failure = Self::input(error.to_string());
        match error {
            CalibrationError::Read { file, .. } => failure.in_file(Path::new(&file)),
            CalibrationError::Parse { file, line, .. } => failure.in_file(Path::new(&file)).at_line(line),
            CalibrationError::Value { file, line, key, .. } => {
                failure.in_file(Path::new(&file)).at_line(line).at_key(key)
            }
        }
    }
}
