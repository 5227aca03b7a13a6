//! Any text as a scene file: a typed error or a scene, never a panic.

#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|text: &str| {
    let _ = tirtouch::scene::parse(text, Path::new("scene.toml"));
    let _ = tirtouch::scene::parse_scan(text, Path::new("scene.toml"));
});
