//! Files that are there whole or not at all.

use super::leftovers::leftovers;
use super::{OutputError, Remedy};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Writes a file that is there whole or not at all; its folder is made.
///
/// # Errors
/// When it cannot be written.
pub fn write_whole(path: &Path, text: &str) -> Result<(), OutputError> {
    let folder = folder_of(path);
    std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
    write_by(folder, path, text.as_bytes())
}

/// The same by way of a file in a folder of the same file system.
pub(super) fn write_by(folder: &Path, path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let _whole = leftovers();
    let write = || {
        let file = passing_file(folder)?;
        file.as_file().write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)
    };
    write().map(|_| ()).map_err(|error| unwritable(path, &error))
}

/// Writes such a file where there is none: one that has come to be there since stays. Its folder is there already.
///
/// # Errors
/// When something is there, or it cannot be written.
pub fn write_new(path: &Path, text: &str) -> Result<(), OutputError> {
    let _whole = leftovers();
    let write = || {
        let file = passing_file(folder_of(path))?;
        file.as_file().write_all(text.as_bytes())?;
        file.as_file().sync_all()?;
        file.persist_noclobber(path).map_err(|error| error.error)
    };
    match write() {
        Ok(_) => Ok(()),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(taken(path)),
        Err(error) => Err(unwritable(path, &error)),
    }
}

/// Fills a folder, which is made where it is not there, with the files that `write` leaves at a place: all of them or,
/// where the disk is full, none.
///
/// # Errors
/// When they cannot be written.
pub fn fill_whole(folder: &Path, write: impl FnOnce(&Path) -> std::io::Result<()>) -> Result<(), OutputError> {
    let fill = || {
        std::fs::create_dir_all(folder)?;
        let place = tempfile::Builder::new().prefix(".tirtouch").tempdir_in(folder).map_err(unnamed)?;
        write(place.path())?;
        for file in std::fs::read_dir(place.path())? {
            let file = file?;
            std::fs::rename(file.path(), folder.join(file.file_name()))?;
        }
        Ok(())
    };
    fill().map_err(|error: std::io::Error| unwritable(folder, &error))
}

/// Refuses a place where something is.
///
/// # Errors
/// That.
pub fn must_be_free(path: &Path) -> Result<(), OutputError> {
    if path.symlink_metadata().is_ok() { Err(taken(path)) } else { Ok(()) }
}

fn taken(path: &Path) -> OutputError {
    OutputError::refused(path, "is there already", Remedy::Mend)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file that grows in the folder of its place. Others may read it as they may any file of this user: workers of a
/// cluster do.
pub(super) fn passing_file(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(unnamed)
}

/// The error without the name of a passing file, which is gone when it is read.
fn unnamed(error: std::io::Error) -> std::io::Error {
    error.kind().into()
}

pub(super) fn unwritable(path: &Path, error: &std::io::Error) -> OutputError {
    OutputError::failed(path, format!("cannot be written: {error}"))
}
