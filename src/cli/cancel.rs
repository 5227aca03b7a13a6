//! Asking the program to stop: Ctrl-C, SIGTERM or SIGHUP.
//!
//! The first signal asks the work to stop at its next pause. Some work has none for minutes (a factorisation, a driver
//! that compiles): a second later, or at a second signal, the program ends where it stands. Both ways remove what is
//! half written, say the same line and end with exit code 3.

use super::Failure;
use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;

/// Time that the work has to pause. All that is cut into pieces pauses several times a second.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time for the last line: a terminal that takes none (Ctrl-S) does not hold up the end.
const LAST_WORD: Duration = Duration::from_millis(300);

static REQUESTED: AtomicBool = AtomicBool::new(false);
static ENDING: Mutex<Ending> = Mutex::new(Ending { leftovers: Vec::new(), parents: Vec::new(), remains: None });

/// What an end at once has to do. Whoever holds it cannot be interrupted.
pub(super) struct Ending {
    /// Folders and files to remove.
    leftovers: Vec<PathBuf>,
    /// Folders made for them, to remove where nothing else came in, the innermost first.
    parents: Vec<PathBuf>,
    /// What remains of the work all the same.
    remains: Option<String>,
}

impl Ending {
    /// Says what remains from now on, whatever happens.
    pub fn keep(&mut self, remains: String) {
        self.remains = Some(remains);
    }

    /// Folders and files that an end at once removes.
    pub fn remove(&mut self, path: &Path) {
        self.leftovers.push(path.into());
    }

    /// Folders made for them, which go where they are empty.
    pub fn remove_empty(&mut self, parents: &[PathBuf]) {
        self.parents.extend_from_slice(parents);
    }

    /// Takes one off again.
    pub fn spare(&mut self, path: &Path) {
        self.leftovers.retain(|leftover| leftover != path);
    }
}

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

/// What a stop says.
pub(super) fn line() -> String {
    said(&ending())
}

fn said(ending: &Ending) -> String {
    format!("stopped on request; {}", ending.remains.as_deref().unwrap_or("nothing was written"))
}

/// Waits until nothing ends the program, and keeps it so while it is held.
pub(super) fn ending() -> MutexGuard<'static, Ending> {
    ENDING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// No end at once from now on: the program is ending, and says why itself.
pub(super) fn last_word() {
    std::mem::forget(ending());
}

/// Listens for the signals that ask to stop. Called once, at the start; `json` is how errors go out.
pub(super) fn install(json: bool) -> Result<(), Failure> {
    let handler = move || {
        let end_later = move || {
            std::thread::sleep(PATIENCE);
            end(json);
        };
        if REQUESTED.swap(true, Ordering::Relaxed) || std::thread::Builder::new().spawn(end_later).is_err() {
            end(json);
        }
    };
    ctrlc::set_handler(handler).map_err(|error| Failure::failed(format!("cannot listen for signals: {error}")))
}

/// Ends the program where it stands.
fn end(json: bool) -> ! {
    let ending = ending();
    for leftover in &ending.leftovers {
        let removed = || std::fs::remove_dir_all(leftover).or_else(|_| std::fs::remove_file(leftover)).is_ok();
        // The work may add a file meanwhile: once again then. What stays is swept away by the next run of the folder.
        let _ = removed() || removed();
    }
    for parent in &ending.parents {
        let _ = std::fs::remove_dir(parent);
    }
    let failure = Failure::stopped(said(&ending));
    let (done, wait) = mpsc::channel();
    let spoken = std::thread::Builder::new().spawn(move || {
        let mut terminal = std::io::stderr();
        if terminal.is_terminal() {
            // A bar that still stands there.
            let _ = write!(terminal, "\r\x1b[2K");
        }
        failure.report(json);
        let _ = done.send(());
    });
    if spoken.is_ok() {
        let _ = wait.recv_timeout(LAST_WORD);
    }
    std::process::exit(3)
}
