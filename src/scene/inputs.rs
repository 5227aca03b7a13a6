//! The files that a scene names: each is read once, and known by its hash.

use super::data_file::{DataFileError, read_limited};
use crate::image_io::limits::FILE_BYTES;
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file as it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Input {
    /// Where it lies; its extension tells its format.
    pub path: PathBuf,
    /// Its bytes.
    pub bytes: Arc<[u8]>,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl Input {
    /// Bytes as the file at `path`.
    pub fn new(path: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) -> Self {
        let (path, bytes) = (path.into(), bytes.into());
        Self { sha256: sha256(&bytes), path, bytes }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read, or has more than 1 GiB.
    pub fn read(path: impl Into<PathBuf>) -> Result<Self, DataFileError> {
        let path = path.into();
        // A pipe may never end.
        if path.metadata().is_ok_and(|data| !data.is_file() && !data.is_dir()) {
            let message = "is no regular file".to_owned();
            return Err(DataFileError { kind: "io", file: path, line: None, message });
        }
        let bytes = read_limited(&path, FILE_BYTES)?;
        Ok(Self::new(path, bytes))
    }

    /// The bytes, of which there may be `max_bytes`.
    pub(super) fn at_most(&self, max_bytes: u64) -> Result<&[u8], DataFileError> {
        match self.bytes.len() as u64 <= max_bytes {
            true => Ok(&self.bytes),
            false => Err(DataFileError::too_large(&self.path, max_bytes)),
        }
    }
}

/// A SHA-256 in hexadecimal.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The files beside a scene, by the names that the scene gives them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Inputs {
    folder: PathBuf,
    kept: BTreeMap<PathBuf, Input>,
}

impl Inputs {
    /// Files of a folder, none of them read yet.
    pub fn of_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into(), kept: BTreeMap::new() }
    }

    /// Where a file lies.
    pub fn resolve(&self, file: &Path) -> PathBuf {
        self.folder.join(file)
    }

    /// Keeps bytes as a file, so that a scene made in memory needs no disk.
    pub fn insert(&mut self, file: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) {
        let file = file.into();
        let input = Input::new(self.resolve(&file), bytes);
        self.kept.insert(file, input);
    }

    /// Reads a file and keeps it. One that cannot be read is not kept: who needs it is told why.
    pub(crate) fn keep(&mut self, file: &Path) {
        if !self.kept.contains_key(file)
            && let Ok(input) = self.open(file)
        {
            self.kept.insert(file.to_path_buf(), input);
        }
    }

    /// A file as it was kept; one that was not is read now.
    ///
    /// # Errors
    /// As [`Input::read`].
    pub fn open(&self, file: &Path) -> Result<Input, DataFileError> {
        self.kept.get(file).map_or_else(|| Input::read(self.resolve(file)), |input| Ok(input.clone()))
    }

    /// SHA-256 of each of these files, in hexadecimal; those that cannot be read are left out.
    pub(crate) fn hashes<'a>(&self, files: impl IntoIterator<Item = &'a Path>) -> BTreeMap<PathBuf, String> {
        files.into_iter().filter_map(|file| Some((file.to_path_buf(), self.open(file).ok()?.sha256))).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_kept_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let write = |text: &str| std::fs::write(folder.path().join("a.csv"), text).unwrap();
        let file = Path::new("a.csv");
        let mut inputs = Inputs::of_folder(folder.path());
        write("one");
        let hash = |inputs: &Inputs| inputs.hashes([file]);
        let before = hash(&inputs);
        inputs.keep(file);
        write("two");
        assert_eq!(&*inputs.open(file).unwrap().bytes, b"one");
        assert_eq!(hash(&inputs), before);
        assert_ne!(hash(&Inputs::of_folder(folder.path())), before);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_not_waited_for() {
        let error = Inputs::of_folder("/dev").open(Path::new("zero")).unwrap_err();
        assert_eq!((error.kind, error.to_string().as_str()), ("io", "/dev/zero: is no regular file"));
    }

    #[test]
    fn a_scene_made_in_memory_needs_no_disk() {
        let mut inputs = Inputs::of_folder("nowhere");
        inputs.keep(Path::new("a.csv"));
        assert_eq!(inputs.open(Path::new("a.csv")).unwrap_err().kind, "io");
        inputs.insert("a.csv", *b"one");
        let input = inputs.open(Path::new("a.csv")).unwrap();
        assert_eq!((input.path.as_path(), &*input.bytes), (Path::new("nowhere/a.csv"), &b"one"[..]));
        assert_eq!(input.at_most(2).unwrap_err().kind, "too_large");
    }
}
