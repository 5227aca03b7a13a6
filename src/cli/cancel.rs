//! Ctrl-C: the first asks the work to stop, the second ends the program.

use super::Failure;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

static REQUESTED: AtomicBool = AtomicBool::new(false);
static STAGING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Whether the user has asked to stop. Long loops poll it.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::Relaxed)
}

/// Fails where the user has asked to stop.
///
/// # Errors
/// [`Failure::cancelled`].
pub fn check() -> Result<(), Failure> {
    match requested() {
        true => Err(Failure::cancelled()),
        false => Ok(()),
    }
}

/// Listens for the signals that ask to stop. Called once, at the start.
pub(super) fn install() -> Result<(), Failure> {
    let handler = || {
        if REQUESTED.swap(true, Ordering::Relaxed) {
            for folder in staging().iter() {
                // The program ends here; what cannot be removed stays.
                let _ = std::fs::remove_dir_all(folder);
            }
            std::process::exit(3);
        }
    };
    ctrlc::set_handler(handler).map_err(|error| Failure::failed(format!("cannot listen for Ctrl-C: {error}")))
}

/// Folders to remove when the program ends at once.
fn staging() -> MutexGuard<'static, Vec<PathBuf>> {
    STAGING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Adds a folder that a second Ctrl-C removes.
pub(super) fn guard(folder: &Path) {
    staging().push(folder.into());
}

/// Takes it off again.
pub(super) fn release(folder: &Path) {
    staging().retain(|guarded| guarded != folder);
}
