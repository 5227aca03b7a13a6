//! What a program that ends where it stands leaves behind, and what remains of its work all the same.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static LEFTOVERS: Mutex<Leftovers> = Mutex::new(Leftovers { files: Vec::new(), parents: Vec::new(), remains: None });

/// What an end at once has to do. Whoever holds it cannot be interrupted by one that asks for it first.
#[derive(Debug)]
pub struct Leftovers {
    /// Folders and files to remove.
    files: Vec<PathBuf>,
    /// Folders made for them, to remove where nothing else came in, the innermost first.
    parents: Vec<PathBuf>,
    /// What remains of the work all the same.
    remains: Option<String>,
}

/// Waits until nobody else holds what is left behind.
pub fn leftovers() -> MutexGuard<'static, Leftovers> {
    LEFTOVERS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Leftovers {
    /// What remains of the work, in words, if anything does.
    pub fn remains(&self) -> Option<&str> {
        self.remains.as_deref()
    }

    /// Removes them.
    pub fn clear(&self) {
        for leftover in &self.files {
            let removed = || std::fs::remove_dir_all(leftover).or_else(|_| std::fs::remove_file(leftover)).is_ok();
            // The work may add a file meanwhile: once again then. What stays is swept away by the next run of the
            // folder.
            let _ = removed() || removed();
        }
        for parent in &self.parents {
            let _ = std::fs::remove_dir(parent);
        }
    }

    /// Says what remains from now on, whatever happens.
    pub fn keep(&mut self, remains: String) {
        self.remains = Some(remains);
    }

    /// Folders and files that an end at once removes.
    pub(super) fn remove(&mut self, path: &Path) {
        self.files.push(path.into());
    }

    /// Folders made for them, which go where they are empty.
    pub(super) fn remove_empty(&mut self, parents: &[PathBuf]) {
        self.parents.extend_from_slice(parents);
    }

    /// Takes one off again.
    pub(super) fn spare(&mut self, path: &Path) {
        self.files.retain(|leftover| leftover != path);
    }
}
