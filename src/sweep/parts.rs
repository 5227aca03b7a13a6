//! The sweeps of a larger work.

use super::{Status, Sweep, SweepFolderError};
use std::path::{Path, PathBuf};

/// The sweeps of a larger work, in folders of its own.
pub struct Parts<'a, E> {
    out: &'a Path,
    compute: &'a mut dyn FnMut(&Sweep, &Path) -> Result<Status, E>,
    /// Whether all points of all parts have ended.
    pub is_whole: bool,
}

impl<'a, E: From<SweepFolderError>> Parts<'a, E> {
    /// In folders of `out`. `compute` is given a sweep and its folder, does there what is to be done, and says how far
    /// the sweep is then.
    pub fn new(out: &'a Path, compute: &'a mut dyn FnMut(&Sweep, &Path) -> Result<Status, E>) -> Self {
        Self { out, compute, is_whole: true }
    }

    /// The folder of a part: one of a sweep that is there, or one of this name in which the sweep file is computed.
    ///
    /// # Errors
    /// A folder or a file that is none of a sweep; what computing says.
    pub fn part(&mut self, part: &Path, name: &str) -> Result<PathBuf, E> {
        let (folder, status) = match part.is_dir() {
            true => {
                let (sweep, records) = Sweep::of_folder(part)?;
                (part.to_path_buf(), Status::of(&sweep, &records))
            }
            false => {
                let (sweep, folder) = (Sweep::load(part).map_err(SweepFolderError::from)?, self.out.join(name));
                let status = (self.compute)(&sweep, &folder)?;
                (folder, status)
            }
        };
        self.is_whole &= status.ended() >= status.points;
        Ok(folder)
    }
}
