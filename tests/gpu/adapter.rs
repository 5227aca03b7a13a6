//! The adapter that the tests run on, or a loud absence.

use tirtouch::trace::TraceError;
use tirtouch::trace::gpu::Gpu;

/// Makes a missing adapter a failure when it is `1`.
const REQUIRE: &str = "TIRTOUCH_REQUIRE_GPU";

/// An open device; `None` where no adapter is there and none is required.
pub fn require_gpu() -> Option<Gpu> {
    match Gpu::open() {
        Ok(gpu) => Some(gpu),
        Err(TraceError::NoAdapter) => {
            assert!(std::env::var(REQUIRE).as_deref() != Ok("1"), "{REQUIRE}=1, but there is no GPU adapter");
            // Not `eprintln!`: the harness would keep that to itself while the test passes.
            let name = std::thread::current().name().unwrap_or("a test").to_owned();
            let line = format!("SKIPPED {name}: no GPU adapter; {REQUIRE}=1 makes this a failure\n");
            let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
            None
        }
        Err(e) => panic!("{e}"),
    }
}
