//! What the errors of the stages say, and who is to blame for them.

use super::Failure;
use crate::calibrate::CalibrateError;
use crate::camera::ProjectionError;
use crate::camera::exposure::ExposureError;
use crate::converge::light::LightError;
use crate::estimate::tissue::TissueError;
use crate::estimate::{CalibrationError, GreyImageError};
use crate::film::compare::CompareError;
use crate::image_io::ImageError;
use crate::mechanics::frames::scan::ScanError;
use crate::mechanics::press::PressError;
use crate::output::{OutputError, Remedy};
use crate::pages::PageError;
use crate::pages::frames::InputError;
use crate::pipeline::FrameFileError;
use crate::report::{PictureError, VtuError};
use crate::scene::{DataFileError, SceneError};
use crate::stability::StabilityError;
use crate::study::StudyError;
use crate::surface::SurfaceError;
use crate::sweep::{NoScene, SweepError, SweepFolderError, slurm};
use crate::trace::TraceError;
use crate::view::{TevError, ViewError};
use std::path::Path;

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
    GreyImageError => input,
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

impl From<FrameFileError> for Failure {
    fn from(error: FrameFileError) -> Self {
        let words = error.to_string();
        match error {
            FrameFileError::Image(error) => error.into(),
            FrameFileError::Unsuited { file, .. } => Self::input(words).in_file(&file),
        }
    }
}

impl From<PageError> for Failure {
    fn from(error: PageError) -> Self {
        match error {
            PageError::Study(error) => (*error).into(),
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

impl From<InputError> for Failure {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Scene(error) => error.into(),
            InputError::Table(error) => error.into(),
            InputError::Scan { file, error } => {
                let failure = Self::from(*error);
                match failure.names_a_file() {
                    true => failure,
                    false => failure.prefixed(&file.display().to_string()).in_file(&file),
                }
            }
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

impl From<CalibrateError> for Failure {
    fn from(error: CalibrateError) -> Self {
        match error {
            CalibrateError::Folder(error) => error.into(),
            CalibrateError::Image(error) => error.into(),
            CalibrateError::Output(error) => error.into(),
            CalibrateError::Fit(_) => Self::failed(error.to_string()),
            CalibrateError::Unsuited { ref folder, .. } => {
                let folder = folder.clone();
                Self::input(error.to_string()).in_file(&folder)
            }
            CalibrateError::File { ref file, .. } => {
                let file = file.clone();
                Self::input(error.to_string()).in_file(&file)
            }
        }
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        let words = error.to_string();
        match error {
            StudyError::Lacking { file } => Self::input(words).in_file(&file),
            StudyError::Damaged => Self::failed(words),
            StudyError::Depth { .. } => Self::input(words),
            StudyError::Calibration(error) => error.into(),
            StudyError::Sweep(error) => error.into(),
            StudyError::Exposure(error) => error.into(),
            StudyError::Frame(error) => error.into(),
            StudyError::Phantom(error) => error.into(),
            StudyError::Statistics(_) => Self::failed(words),
        }
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Output(error) => error.into(),
            SweepError::Device { .. } => Self::failed(error.to_string()),
            SweepError::Stopped => Self::cancelled(),
        }
    }
}

impl From<slurm::JobError> for Failure {
    fn from(error: slurm::JobError) -> Self {
        match error {
            slurm::JobError::Output(error) => error.into(),
            error => Self::failed(error.to_string()),
        }
    }
}

impl From<SweepFolderError> for Failure {
    fn from(error: SweepFolderError) -> Self {
        match error {
            SweepFolderError::Output(error) => error.into(),
            SweepFolderError::Scene(error) => error.into(),
            SweepFolderError::Strange(ref folder) => {
                let folder = folder.clone();
                Self::input(error.to_string()).in_file(&folder)
            }
        }
    }
}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Self {
        match error {
            ViewError::System(_) => Self::failed(error.to_string()),
            ViewError::Port { .. } | ViewError::Knob(_) => Self::usage(error.to_string()),
        }
    }
}

impl From<TevError> for Failure {
    fn from(error: TevError) -> Self {
        Self::usage(error.to_string())
    }
}

impl Failure {
    /// Why a point of a sweep, of a file or a folder, has no scene.
    #[must_use]
    pub fn of_point(error: &NoScene, file: &Path) -> Self {
        let words = format!("{}: {error}", file.display());
        let failure = match error {
            NoScene::Row { .. } => Self::usage(words),
            NoScene::Rejected { .. } => Self::input(words),
        };
        failure.in_file(file)
    }
}
