//! Who writes an output folder: one run at a time.
//!
//! A claim is a locked file beside the folder. The system lets go of a lock when its program ends, however it ends, so
//! no lock can go stale; what a killed run left is swept away by the next one that writes the same folder. NFS passes
//! such locks on to its server, so that runs on two machines see each other. A file system that has none (some mounts
//! of Lustre) still creates a file once only: there a file that a killed run left has to be removed by hand, and the
//! message says so.

use super::leftovers::leftovers;
use super::{OutputError, Remedy};
use std::fs::{File, TryLockError};
use std::io::{Error, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

/// The right to write one folder. Dropping it removes all that is not in its place.
#[derive(Debug)]
pub struct Claim {
    /// Where the folder grows.
    pub(super) partial: PathBuf,
    /// Where an old folder waits while a new one takes its place.
    pub(super) replaced: PathBuf,
    lock: PathBuf,
    /// Locked; None where there are no locks.
    _held: Option<File>,
    /// Dropped last: the others lie in them.
    parents: NewParents,
}

impl Claim {
    /// Claims the folder `destination`, and makes the folders that it lies in.
    ///
    /// # Errors
    /// When another run has it, it is not a name for a folder, or its parent cannot be written.
    pub fn take(destination: &Path) -> Result<Self, OutputError> {
        let refused = |why: &str, remedy| OutputError::refused(destination, why, remedy);
        let Some(name) = destination.file_name() else {
            return Err(refused("not a name for a new folder", Remedy::Mend));
        };
        let parent = match destination.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let unwritable =
            |error: Error| OutputError::refused(parent, format!("no folder can be made there: {error}"), Remedy::Mend);
        let parents = NewParents::make(parent).map_err(unwritable)?;
        let beside = |kind: &str| parent.join(format!(".{}.tirtouch.{kind}", name.to_string_lossy()));
        let lock = beside("lock");
        let held = match hold(&lock).map_err(unwritable)? {
            Hold::Locked(file) => Some(file),
            Hold::Created => None,
            Hold::Taken => return Err(refused("another run is writing it", Remedy::Elsewhere)),
            Hold::Unknown => {
                let why = format!(
                    "another run is writing it, or was killed (this file system has no locks to tell by); where none \
                     is, remove {}",
                    lock.display()
                );
                return Err(refused(&why, Remedy::Mend));
            }
        };
        let claim = Self { partial: beside("partial"), replaced: beside("replaced"), lock, _held: held, parents };
        let mut left = leftovers();
        left.remove(&claim.partial);
        left.remove(&claim.lock);
        left.remove_empty(&claim.parents.0);
        drop(left);
        claim.sweep(destination).map_err(unwritable)?;
        Ok(claim)
    }

    /// Removes what a killed run left. A run killed between two renames had taken the old folder away: it comes back.
    fn sweep(&self, destination: &Path) -> std::io::Result<()> {
        let there = |path: &Path| path.symlink_metadata().is_ok();
        if there(&self.replaced) && !there(destination) {
            std::fs::rename(&self.replaced, destination)?;
        }
        for left in [&self.partial, &self.replaced] {
            if there(left) {
                std::fs::remove_dir_all(left)?;
            }
        }
        Ok(())
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // No end at once in between: it would remove the file of whoever comes next.
        let mut left = leftovers();
        let _ = std::fs::remove_dir_all(&self.partial);
        // While it is still locked: whoever waits for it sees that the name is gone.
        let _ = std::fs::remove_file(&self.lock);
        left.spare(&self.partial);
        left.spare(&self.lock);
    }
}

/// How a claim was met.
enum Hold {
    Locked(File),
    /// No locks here, but nobody else made the file.
    Created,
    Taken,
    /// No locks here, and the file is there.
    Unknown,
}

/// Makes and locks a file, or finds it locked.
fn hold(path: &Path) -> std::io::Result<Hold> {
    loop {
        let mut options = File::options();
        options.read(true).write(true);
        let (file, made) = match options.clone().create_new(true).open(path) {
            Ok(file) => (file, true),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => match options.open(path) {
                Ok(file) => (file, false),
                // Its owner has just removed it.
                Err(error) if error.kind() == ErrorKind::NotFound => continue,
                Err(error) => return Err(error),
            },
            Err(error) => return Err(error),
        };
        match file.try_lock() {
            Ok(()) if is_at(&file, path) => return Ok(Hold::Locked(signed(file))),
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Ok(Hold::Taken),
            Err(TryLockError::Error(_)) => return Ok(if made { Hold::Created } else { Hold::Unknown }),
        }
    }
}

/// Says in the file who holds it, for people, where the disk has room for that.
fn signed(mut file: File) -> File {
    let whose = format!("process {} writes the folder beside this file\n", std::process::id());
    let _ = file.set_len(0).and_then(|()| file.write_all(whose.as_bytes()));
    file
}

/// Whether a file is still the one of that name: its owner may have removed it before we locked it.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let same = |a: &std::fs::Metadata, b: &std::fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    matches!((file.metadata(), path.metadata()), (Ok(ours), Ok(named)) if same(&ours, &named))
}

/// Elsewhere a name stays taken while its file is open.
#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::fs;

    #[test]
    fn a_folder_has_one_writer_at_a_time() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("result");
        let first = Claim::take(&folder).unwrap();
        let second = Claim::take(&folder).unwrap_err();
        assert!(second.to_string().contains("another run"), "{second}");
        Claim::take(&place.path().join("other")).unwrap();
        drop(first);
        drop(Claim::take(&folder).unwrap());
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 0, "nothing is left");
    }

    /// Many threads, one right: at no time do two hold it, and at the end nothing is left.
    #[test]
    fn claims_that_come_and_go_never_overlap() {
        let place = tempfile::tempdir().unwrap();
        let (folder, inside) = (place.path().join("result"), place.path().join("inside"));
        let taken: usize = std::thread::scope(|scope| {
            let worker = || {
                let tries = (0..200).filter_map(|_| Claim::take(&folder).ok());
                tries.map(|_claim| File::create_new(&inside).and_then(|_| fs::remove_file(&inside)).unwrap()).count()
            };
            let workers: Vec<_> = (0..4).map(|_| scope.spawn(worker)).collect();
            workers.into_iter().map(|worker| worker.join().unwrap()).sum()
        });
        assert!(taken > 0 && fs::read_dir(place.path()).unwrap().count() == 0, "{taken}");
    }

    #[test]
    fn what_a_killed_run_left_is_swept_away_and_an_old_result_comes_back() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("result");
        fs::write(place.path().join(".result.tirtouch.lock"), "").unwrap();
        for left in [".result.tirtouch.partial", ".result.tirtouch.replaced"] {
            fs::create_dir(place.path().join(left)).unwrap();
            fs::write(place.path().join(left).join("a.txt"), left).unwrap();
        }
        drop(Claim::take(&folder).unwrap());
        assert_eq!(fs::read_to_string(folder.join("a.txt")).unwrap(), ".result.tirtouch.replaced");
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
