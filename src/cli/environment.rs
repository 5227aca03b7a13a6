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
#[cfg(target_os = "linux")]
pub(super) fn settle() {
    use std::os::unix::process::CommandExt as _;
    let wanted: Vec<(&str, &str)> = [wide_vectors(), no_compositor()].into_iter().flatten().collect();
    if wanted.is_empty() {
        return;
    }
    let mut arguments = std::env::args_os();
    if let (Ok(program), Some(name)) = (std::env::current_exe(), arguments.next()) {
        drop(std::process::Command::new(program).arg0(name).args(arguments).envs(wanted).exec());
    }
}

/// Nothing to settle here.
#[cfg(not(target_os = "linux"))]
pub(super) fn settle() {}

/// Mesa's llvmpipe works on 8 paths at once where a CPU with AVX-512 could on 16, unless it is told to. Images are the
/// same to the last bit, in 0.6 to 0.9 of the time (docs/ERROR.md). Other drivers do not read it; what the user chose
/// stays.
#[cfg(target_os = "linux")]
fn wide_vectors() -> Option<(&'static str, &'static str)> {
    const WIDTH: &str = "LP_NATIVE_VECTOR_WIDTH";
    #[cfg(target_arch = "x86_64")]
    let wide = std::arch::is_x86_feature_detected!("avx512f");
    #[cfg(not(target_arch = "x86_64"))]
    let wide = false;
    (wide && std::env::var_os(WIDTH).is_none()).then_some((WIDTH, "512"))
}

/// Mesa's layer that selects devices asks a Wayland compositor for its GPU at every start of Vulkan. Without a folder
/// for sockets (containers, ssh, CI) libwayland writes an error each time; by an absolute name it finds no compositor
/// in silence. (`NODEVICE_SELECT` would silence it too, and with it the user's own `MESA_VK_DEVICE_SELECT`.)
#[cfg(target_os = "linux")]
fn no_compositor() -> Option<(&'static str, &'static str)> {
    let absolute = |name: &str| std::env::var_os(name).is_some_and(|value| value.as_encoded_bytes().starts_with(b"/"));
    (!absolute("XDG_RUNTIME_DIR") && !absolute("WAYLAND_DISPLAY")).then_some(("WAYLAND_DISPLAY", "/dev/null"))
}
