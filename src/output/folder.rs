//! An output folder that is there in whole or not at all.

use super::contents::{self, RESULT, SCENE, check_own, described};
use super::leftovers::leftovers;
use super::{Claim, OutputError, Remedy};
use crate::image_io::ImageError;
use serde_json::Value;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder in the making: a hidden sibling of its destination, renamed by [`OutputFolder::commit`] and removed when
/// dropped before.
#[derive(Debug)]
pub struct OutputFolder {
    destination: PathBuf,
    claim: Claim,
    force: bool,
}

/// A folder in its place.
#[derive(Debug)]
pub struct Finished {
    /// Where it is.
    pub out: String,
    /// The result with what was added to it, as JSON.
    pub json: String,
}

impl OutputFolder {
    /// Begins the folder `destination`. To be called before the work, so that what is wrong with it costs nothing.
    ///
    /// # Errors
    /// When another run writes it; it exists and `force` is not set, or holds anything that this program did not write;
    /// or its parent cannot be written.
    pub fn create(destination: &Path, force: bool) -> Result<Self, OutputError> {
        let claim = Claim::take(destination)?;
        if let Ok(existing) = destination.symlink_metadata() {
            refuse_to_replace(destination, &existing, force)?;
        }
        // With the rights of any new folder: the umask applies.
        std::fs::create_dir(&claim.partial).map_err(|error| {
            OutputError::refused(destination, format!("no folder can be made there: {error}"), Remedy::Mend)
        })?;
        Ok(Self { destination: destination.into(), claim, force })
    }

    /// Where to write the file `name` for now.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.claim.partial.join(name)
    }

    /// Writes a text file into it, down to the disk.
    ///
    /// # Errors
    /// When it cannot be written, as on a full disk.
    pub fn write(&self, name: &str, text: &str) -> Result<(), OutputError> {
        self.write_bytes(name, text.as_bytes())
    }

    /// Writes a file into it, down to the disk.
    ///
    /// # Errors
    /// As of `write`.
    pub fn write_bytes(&self, name: &str, bytes: &[u8]) -> Result<(), OutputError> {
        let path = self.path(name);
        let write = || {
            let mut file = File::create(&path)?;
            file.write_all(bytes)?;
            file.sync_all()
        };
        write()
            .map_err(|error| OutputError::failed(&self.destination.join(name), format!("cannot be written: {error}")))
    }

    /// Has `write` write an image into it.
    ///
    /// # Errors
    /// As of `write`, with the place that the image would have had.
    pub fn write_image(
        &self,
        name: &str,
        write: impl FnOnce(&Path) -> Result<(), ImageError>,
    ) -> Result<(), OutputError> {
        write(&self.path(name)).map_err(|error| OutputError::of_image(error, &self.destination.join(name)))
    }

    /// Adds the scene's text, if there is one, and the result, puts the folder in its place and says where that is.
    ///
    /// # Errors
    /// When `go_on` says no, the place was taken meanwhile, or it cannot be renamed. An old folder stays
    /// then.
    pub fn commit(self, scene: Option<&str>, result: Value, go_on: &dyn Fn() -> bool) -> Result<Finished, OutputError> {
        let result = described(result, Some(&self.destination));
        if let Some(text) = scene {
            self.write(SCENE, text)?;
        }
        self.write(RESULT, &format!("{result:#}\n"))?;
        let (name, sums) = contents::sums(&self.claim.partial).map_err(|error| self.misplaced(error))?;
        self.write(name, &sums)?;
        if !go_on() {
            return Err(OutputError::Stopped);
        }
        let mut left = leftovers();
        self.put_in_place()?;
        let out = self.destination.display().to_string();
        left.keep(format!("{out} is written"));
        drop(left);
        // The new folder is in place; what cannot be removed of the old one is swept away by the next run.
        let _ = std::fs::remove_dir_all(&self.claim.replaced);
        Ok(Finished { out, json: result.to_string() })
    }

    fn misplaced(&self, error: impl std::fmt::Display) -> OutputError {
        OutputError::failed(&self.destination, format!("cannot be put in place: {error}"))
    }

    fn put_in_place(&self) -> Result<(), OutputError> {
        let (partial, aside, place) = (&self.claim.partial, &self.claim.replaced, &self.destination);
        let exists = place.symlink_metadata().is_ok();
        if exists && !self.force {
            return Err(self.misplaced(std::io::Error::from(std::io::ErrorKind::AlreadyExists)));
        }
        if exists {
            // What was put into it while this ran counts too.
            check_own(place).map_err(|changed| self.misplaced(changed))?;
            std::fs::rename(place, aside).map_err(|error| self.misplaced(error))?;
        }
        std::fs::rename(partial, place).map_err(|error| match exists.then(|| std::fs::rename(aside, place)) {
            None | Some(Ok(())) => self.misplaced(error),
            Some(Err(_)) => {
                OutputError::failed(place, format!("could not be replaced; the old folder is {}", aside.display()))
            }
        })
    }
}

/// A wrong name must not cost more than a folder of results.
fn refuse_to_replace(destination: &Path, existing: &std::fs::Metadata, force: bool) -> Result<(), OutputError> {
    let refused = |why: &str, remedy| Err(OutputError::refused(destination, why, remedy));
    if !existing.is_dir() {
        return refused("exists and is no folder; it is not replaced", Remedy::Elsewhere);
    }
    let holds = |folder: PathBuf| {
        let (folder, place) = (folder.canonicalize().ok()?, destination.canonicalize().ok()?);
        Some(folder.starts_with(place))
    };
    if std::env::current_dir().ok().and_then(holds) == Some(true) {
        return refused("holds the working directory and is not replaced", Remedy::Mend);
    }
    check_own(destination)?;
    if force { Ok(()) } else { refused("exists", Remedy::Replace) }
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

    fn is_refused(error: &OutputError) -> bool {
        matches!(error, OutputError::Refused { .. })
    }

    fn has_failed(error: &OutputError) -> bool {
        matches!(error, OutputError::Failed { .. })
    }

    /// What every committed folder holds beside the files of its command.
    const OWN: [&str; 2] = ["SHA256SUMS", "result.json"];

    /// Writes a folder with one file.
    fn result(destination: &Path, name: &str) {
        let folder = OutputFolder::create(destination, true).unwrap();
        folder.write(name, name).unwrap();
        folder.commit(None, Value::Null, &|| true).unwrap();
    }

    #[test]
    fn a_committed_folder_is_whole_and_alone_and_says_what_it_is() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("deep/er/result");
        let folder = OutputFolder::create(&destination, false).unwrap();
        folder.write("a.txt", "a").unwrap();
        assert!(!destination.exists());
        let done = folder.commit(Some("name = 1\r\n"), Value::Null, &|| true).unwrap();
        assert_eq!(done.out, destination.display().to_string());
        assert_eq!(names(&destination), [OWN[0], "a.txt", OWN[1], SCENE]);
        assert_eq!(names(destination.parent().unwrap()), ["result"]);
        assert_eq!(fs::read(destination.join(SCENE)).unwrap(), b"name = 1\r\n");
        let kept: Value = serde_json::from_slice(&fs::read(destination.join(RESULT)).unwrap()).unwrap();
        assert_eq!(kept, serde_json::from_str::<Value>(&done.json).unwrap());
        assert_eq!(kept["out"], done.out);
        assert!(kept["version"].is_string());
    }

    #[test]
    fn a_dropped_folder_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(&place.path().join("new/result"), false).unwrap();
        folder.write("a.txt", "a").unwrap();
        drop(folder);
        assert!(names(place.path()).is_empty());
    }

    #[test]
    fn an_existing_folder_is_replaced_by_force_only() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("result");
        result(&destination, "old.txt");
        let refused = OutputFolder::create(&destination, false).unwrap_err();
        assert!(matches!(refused, OutputError::Refused { remedy: Remedy::Replace, .. }), "{refused}");
        let folder = OutputFolder::create(&destination, true).unwrap();
        folder.write("new.txt", "new").unwrap();
        assert_eq!(names(&destination), [OWN[0], "old.txt", OWN[1]], "kept until the new one is whole");
        folder.commit(None, Value::Null, &|| true).unwrap();
        assert_eq!(names(&destination), [OWN[0], "new.txt", OWN[1]]);
        assert_eq!(names(place.path()), ["result"]);
    }

    /// Not even with --force: a folder of the user's, files put into a result, a result that was edited or holds a
    /// folder.
    #[test]
    fn a_folder_with_anything_that_was_not_written_here_is_never_replaced() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("result");
        let spoil: [(&str, &dyn Fn()); 4] = [
            ("thesis.tex", &|| {
                fs::create_dir(&destination).unwrap();
                fs::write(destination.join("thesis.tex"), "years").unwrap();
            }),
            ("notes.txt", &|| {
                result(&destination, "a.txt");
                fs::write(destination.join("notes.txt"), "mine").unwrap();
            }),
            ("a.txt", &|| {
                result(&destination, "a.txt");
                fs::write(destination.join("a.txt"), "with a remark").unwrap();
            }),
            ("deeper", &|| {
                result(&destination, "a.txt");
                fs::create_dir(destination.join("deeper")).unwrap();
            }),
        ];
        for (what, make) in spoil {
            make();
            let before = names(&destination);
            let refused = OutputFolder::create(&destination, true).unwrap_err();
            assert!(is_refused(&refused) && refused.to_string().contains(what), "{refused}");
            assert_eq!(names(&destination), before);
            assert_eq!(names(place.path()), ["result"]);
            fs::remove_dir_all(&destination).unwrap();
        }
        // What was put into it while the work ran counts too; what a viewer of folders left does not.
        result(&destination, "a.txt");
        fs::write(destination.join(".DS_Store"), "").unwrap();
        let folder = OutputFolder::create(&destination, true).unwrap();
        fs::write(destination.join("notes.txt"), "mine").unwrap();
        assert!(has_failed(&folder.commit(None, Value::Null, &|| true).unwrap_err()));
        assert_eq!(fs::read_to_string(destination.join("notes.txt")).unwrap(), "mine");
        fs::remove_file(destination.join("notes.txt")).unwrap();
        result(&destination, "b.txt");
        assert_eq!(names(&destination), [OWN[0], "b.txt", OWN[1]]);
    }

    #[test]
    fn a_place_taken_meanwhile_is_not_overwritten() {
        let place = tempfile::tempdir().unwrap();
        let destination = place.path().join("result");
        let folder = OutputFolder::create(&destination, false).unwrap();
        fs::create_dir(&destination).unwrap();
        fs::write(destination.join("theirs.txt"), "theirs").unwrap();
        assert!(has_failed(&folder.commit(None, Value::Null, &|| true).unwrap_err()));
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
            assert!(is_refused(&refused), "{refused}");
        }
        let below = OutputFolder::create(&file.join("result"), false).unwrap_err();
        assert!(below.to_string().contains(&*file.to_string_lossy()), "it names the parent: {below}");
    }
}
