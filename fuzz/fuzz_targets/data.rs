//! Any bytes as one of the files that a scene names: a mesh, a lamp, a pressure table, an indenter's shape. A typed
//! error or a value, never a panic.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tirtouch::scene::{Input, read_ies, read_indenter_table, read_mesh, read_pressure_table};

fuzz_target!(|bytes: &[u8]| {
    for name in ["a.obj", "a.stl", "a.ply"] {
        let _ = read_mesh(&Input::new(name, bytes));
    }
    let _ = read_ies(&Input::new("a.ies", bytes));
    let table = Input::new("a.csv", bytes);
    let _ = read_pressure_table(&table);
    let _ = read_indenter_table(&table);
});
