//! Asking the program to stop: Ctrl-C, SIGTERM or SIGHUP.
//!
//! The first signal asks the work to stop at its next pause. Some work has none for minutes (a factorisation, a driver
//! that compiles): a second later, or at a second signal, the program ends where it stands. Both ways remove what is
//! half written, say the same line and end with exit code 3.

use super::Failure;
use crate::output::leftovers::leftovers;
use std::io::{IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::Duration;

/// Time that the work has to pause. All that is cut into pieces pauses several times a second.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time for the last line: a terminal that takes none (Ctrl-S) does not hold up the end.
const LAST_WORD: Duration = Duration::from_millis(300);

static REQUESTED: AtomicBool = AtomicBool::new(false);
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

/// No end at once from now on: the program is ending, and says why itself.
pub(super) fn last_word() {
    std::mem::forget(leftovers());
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
    let left = leftovers();
    left.clear();
    let failure = Failure::left(&left);
    let (done, wait) = mpsc::channel();
    let spoken = std::thread::Builder::new().spawn(move || {
        let mut terminal = std::io::stderr();
        if terminal.is_terminal() {
            // A bar that still stands there.
            let _ = write!(terminal, "\r\x1b[2K");
        }
        super::report(&failure, json);
        let _ = done.send(());
    });
    if spoken.is_ok() {
        let _ = wait.recv_timeout(LAST_WORD);
    }
    std::process::exit(3)
}
