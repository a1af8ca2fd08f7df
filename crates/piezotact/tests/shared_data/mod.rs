//! Measured files beside the checkout, which the tests of every crate look for in one way.

use std::path::{Path, PathBuf};

/// A file or folder beside the checkout; `None`, said plainly, when it is not there. In CI it must be.
#[allow(clippy::print_stderr, reason = "a test says what it skipped")]
pub(crate) fn shared(path: &str) -> Option<PathBuf> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared")
        .join(path);
    if file.exists() {
        return Some(file);
    }
    assert!(
        std::env::var_os("CI").is_none(),
        "{} is missing, and CI needs it",
        file.display()
    );
    eprintln!("skipped: {} is not there", file.display());
    None
}
