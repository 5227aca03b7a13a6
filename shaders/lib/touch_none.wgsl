// Nothing makes optical contact.
fn tissue_here(xy: vec2f) -> bool { return false; }
fn camera_touch(light: ptr<function, f32>) -> u32 { return END_ABSORBED; }
fn photon_touch() -> u32 { return END_ABSORBED; }
fn go_on_mirrored() -> bool { return false; }
