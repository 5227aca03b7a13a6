//! Variables of the environment by which drivers do better, read when they are loaded: set before a session is opened.

/// Name and value of those that are missing in this process's environment.
#[must_use]
pub fn environment() -> Vec<(&'static str, &'static str)> {
    #[cfg(target_os = "linux")]
    return [wide_vectors(), no_compositor()].into_iter().flatten().collect();
    #[cfg(not(target_os = "linux"))]
    Vec::new()
}

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
