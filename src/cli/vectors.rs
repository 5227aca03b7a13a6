//! Vectors as wide as the CPU's, for Mesa's software driver.
//!
//! llvmpipe works on 8 paths at once where a CPU with AVX-512 could on 16, unless an environment variable tells it to. It reads
//! that when it is loaded, so the program starts itself again with the variable set, in the same process. Images are the same
//! to the last bit, in 0.6 to 0.9 of the time (docs/ERROR.md). Other drivers do not read it.

/// Starts the program again with wide vectors, where that helps and nobody chose otherwise; comes back where not.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
pub(super) fn widen() {
    use std::os::unix::process::CommandExt as _;
    const WIDTH: &str = "LP_NATIVE_VECTOR_WIDTH";
    if std::env::var_os(WIDTH).is_some() || !std::arch::is_x86_feature_detected!("avx512f") {
        return;
    }
    let mut arguments = std::env::args_os();
    if let (Ok(program), Some(name)) = (std::env::current_exe(), arguments.next()) {
        // Comes back only where it fails, and then narrow vectors do.
        drop(std::process::Command::new(program).arg0(name).args(arguments).env(WIDTH, "512").exec());
    }
}

/// Nothing to widen here.
#[cfg(not(all(target_os = "linux", target_arch = "x86_64")))]
pub(super) fn widen() {}
