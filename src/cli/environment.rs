//! What is read from the environment: a limit of memory by this program, and more by drivers when they are loaded.
//!
//! Only a program that starts again can change it without unsafe code: another thread could be reading it. `exec`
//! replaces the program within its process, so that who started it sees one process, its signals and its exit code. It
//! is done first of all, and once: the new environment asks for nothing more. Where it fails, the program goes on as it
//! was started.

use super::Failure;
use crate::mechanics::memory::{VARIABLE, parsed};

/// Whether this program's own variables make sense.
///
/// # Errors
/// When one does not.
pub(super) fn check() -> Result<(), Failure> {
    match std::env::var_os(VARIABLE) {
        Some(value) if value.to_str().and_then(parsed).is_none() => {
            Err(Failure::usage(format!("{VARIABLE}={}: give a number of GiB above 0", value.to_string_lossy())))
        }
        _ => Ok(()),
    }
}

/// Starts the program again where its drivers would do worse in this environment; comes back where not.
pub(super) fn settle() {
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::process::CommandExt as _;
        let wanted = crate::trace::drivers::environment();
        let mut arguments = std::env::args_os();
        if let (false, Ok(program), Some(name)) = (wanted.is_empty(), std::env::current_exe(), arguments.next()) {
            drop(std::process::Command::new(program).arg0(name).args(arguments).envs(wanted).exec());
        }
    }
}
