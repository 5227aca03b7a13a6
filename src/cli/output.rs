//! An output folder that is there in whole or not at all.

use super::{Failure, cancel};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A folder in the making: a temporary sibling of its destination, renamed by [`OutputFolder::commit`] and removed when
/// dropped before.
#[derive(Debug)]
pub struct OutputFolder {
    destination: PathBuf,
    staging: TempDir,
    force: bool,
    /// Dropped after `staging`, which lies in them.
    _parents: NewParents,
}

/// Folders made for the destination, the innermost first. Those that stay empty are removed.
#[derive(Debug)]
struct NewParents(Vec<PathBuf>);

impl NewParents {
    fn make(parent: &Path) -> std::io::Result<Self> {
        let missing = |folder: &&Path| *folder != Path::new("") && !folder.exists();
        let made = Self(parent.ancestors().take_while(missing).map(Path::to_path_buf).collect());
        std::fs::create_dir_all(parent)?;
        Ok(made)
    }
}

impl Drop for NewParents {
    fn drop(&mut self) {
        for folder in &self.0 {
            // Refused where it holds anything.
            let _ = std::fs::remove_dir(folder);
        }
    }
}

impl OutputFolder {
    /// Begins the folder `destination`. To be called before the work, so that what is wrong with it costs nothing.
    ///
    /// # Errors
    /// When it exists and `force` is not set, is no folder, holds the working directory, or its parent cannot be written.
    pub fn create(destination: &Path, force: bool) -> Result<Self, Failure> {
        let input = |message: String| Failure::input(message).in_file(destination);
        let shown = destination.display();
        let Some(name) = destination.file_name() else {
            return Err(input(format!("{shown}: not a name for a new folder")));
        };
        if let Ok(existing) = destination.symlink_metadata() {
            if !force {
                return Err(input(format!("{shown}: exists; `--force` replaces it, `--out` names another")));
            }
            if !existing.is_dir() {
                return Err(input(format!("{shown}: is no folder and is not replaced")));
            }
            refuse_to_replace_home(destination)?;
        }
        let parent = match destination.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let unwritable = |error: std::io::Error| {
            Failure::input(format!("{}: no folder can be made there: {error}", parent.display())).in_file(parent)
        };
        let parents = NewParents::make(parent).map_err(unwritable)?;
        let prefix = format!(".{}.", name.to_string_lossy());
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".partial");
        // Readable like any new folder (the umask still applies), not private like a temporary one.
        #[cfg(unix)]
        let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o777);
        #[cfg(unix)]
        builder.permissions(permissions);
        let staging = builder.tempdir_in(parent).map_err(unwritable)?;
        cancel::guard(staging.path());
        Ok(Self { destination: destination.into(), staging, force, _parents: parents })
    }

    /// Where to write the file `name` for now.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.staging.path().join(name)
    }

    /// Writes a text file into it, down to the disk.
    ///
    /// # Errors
    /// When it cannot be written, as on a full disk.
    pub fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        self.write_bytes(name, text.as_bytes())
    }

    /// Writes a file into it, down to the disk.
    ///
    /// # Errors
    /// As of `write`.
    pub fn write_bytes(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let path = self.path(name);
        let write = || {
            let mut file = File::create(&path)?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        write().map_err(|error| {
            let place = self.destination.join(name);
            Failure::failed(format!("{}: cannot be written: {error}", place.display())).in_file(&place)
        })
    }

    /// Puts the folder in its place and says where that is.
    ///
    /// # Errors
    /// When the user has asked to stop, the place was taken meanwhile, or it cannot be renamed. An old folder stays then.
    pub fn commit(mut self) -> Result<PathBuf, Failure> {
        cancel::check()?;
        let failed = |error: std::io::Error| {
            let place = self.destination.display();
            Failure::failed(format!("{place}: cannot be put in place: {error}")).in_file(&self.destination)
        };
        let aside = self.staging.path().with_extension("replaced");
        let exists = self.destination.symlink_metadata().is_ok();
        if exists && !self.force {
            let taken = std::io::Error::from(std::io::ErrorKind::AlreadyExists);
            return Err(failed(taken));
        }
        if exists {
            std::fs::rename(&self.destination, &aside).map_err(failed)?;
        }
        if let Err(error) = std::fs::rename(self.staging.path(), &self.destination) {
            let restored = if exists { std::fs::rename(&aside, &self.destination) } else { Ok(()) };
            return Err(match restored {
                Ok(()) => failed(error),
                Err(_) => Failure::failed(format!(
                    "{}: could not be replaced; the old folder is {}",
                    self.destination.display(),
                    aside.display()
                )),
            });
        }
        self.staging.disable_cleanup(true);
        if exists {
            // The new folder is in place; what cannot be removed of the old one lies beside it.
            let _ = std::fs::remove_dir_all(&aside);
        }
        Ok(self.destination.clone())
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        cancel::release(self.staging.path());
    }
}

/// `--force` on the wrong name must not cost more than a folder of results.
fn refuse_to_replace_home(destination: &Path) -> Result<(), Failure> {
    let Ok(place) = destination.canonicalize() else {
        return Ok(());
    };
    let home = std::env::var_os("HOME").map(PathBuf::from);
    let mut kept = std::env::current_dir().ok().into_iter().chain(home).filter_map(|folder| folder.canonicalize().ok());
    match kept.any(|folder| folder.starts_with(&place)) {
        true => Err(Failure::input(format!(
            "{}: holds the working or home directory and is not replaced",
            destination.display()
        ))
        .in_file(destination)),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::fs;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_committed_folder_is_whole_and_alone() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("deep/er/result");
        let folder = OutputFolder::create(&destination, false).unwrap();
        fs::write(folder.path("a.txt"), "a").unwrap();
        assert!(!destination.exists());
        assert_eq!(folder.commit().unwrap(), destination);
        assert_eq!(names(&destination), ["a.txt"]);
        assert_eq!(names(destination.parent().unwrap()), ["result"]);
    }

    #[test]
    fn a_dropped_folder_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(&place.path().join("result"), false).unwrap();
        fs::write(folder.path("a.txt"), "a").unwrap();
        drop(folder);
        assert!(names(place.path()).is_empty());
    }

    #[test]
    fn an_existing_folder_is_replaced_by_force_only() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("result");
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("old.txt"), "old").unwrap();
        let refused = OutputFolder::create(&destination, false).unwrap_err();
        assert_eq!(refused.code(), 2);
        assert!(refused.message().contains("--force"), "{}", refused.message());
        let folder = OutputFolder::create(&destination, true).unwrap();
        fs::write(folder.path("new.txt"), "new").unwrap();
        assert_eq!(names(&destination), ["old.txt"], "kept until the new one is whole");
        folder.commit().unwrap();
        assert_eq!(names(&destination), ["new.txt"]);
        assert_eq!(names(place.path()), ["result"]);
    }

    #[test]
    fn a_place_taken_meanwhile_is_not_overwritten() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("result");
        let folder = OutputFolder::create(&destination, false).unwrap();
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("theirs.txt"), "theirs").unwrap();
        assert_eq!(folder.commit().unwrap_err().code(), 3);
        assert_eq!(names(&destination), ["theirs.txt"]);
        assert_eq!(names(place.path()), ["result"]);
    }

    #[test]
    fn what_is_no_place_for_a_folder_is_refused_before_the_work() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        for (destination, force) in [
            (file.join("result"), false),
            (file.clone(), true),
            (PathBuf::from("/"), true),
            (PathBuf::from(".."), true),
            (std::env::current_dir().unwrap(), true),
        ] {
            let refused = OutputFolder::create(&destination, force).unwrap_err();
            assert_eq!(refused.code(), 2, "{}", destination.display());
        }
        let below = OutputFolder::create(&file.join("result"), false).unwrap_err();
        assert!(below.message().contains(&*file.to_string_lossy()), "it names the parent: {}", below.message());
    }
}
