//! What drivers say when there is no desktop.

use super::*;

/// As in a container, over ssh, in CI: Mesa's device selection then looks for a compositor and says that there is none.
#[test]
fn standard_error_is_empty_without_a_desktop() {
    let place = Place::new();
    place.write("scene.toml", &small("tsis-dent"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_tirtouch"));
    for name in ["XDG_RUNTIME_DIR", "NODEVICE_SELECT", "WAYLAND_DISPLAY"] {
        command.env_remove(name);
    }
    let arguments = ["render", "scene.toml", "--spp", "16", "--photons", "1000", "--quiet"];
    let output = command.args(arguments).current_dir(place.path()).output().unwrap();
    assert_eq!(code(&output), 0, "{output:?}");
    assert_eq!(text(&output.stderr), "");
}
