//! Paths that tests need: the project's programs as built, the repository.

use std::path::{Path, PathBuf};

/// The repository's folder.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(Path::to_path_buf).unwrap_or_default()
}

/// One of the project's programs, in the profile of the running test.
///
/// # Panics
/// When it is not built.
#[expect(clippy::panic, reason = "a test cannot go on")]
pub fn program(name: &str) -> PathBuf {
    // The test's program is target/PROFILE/deps/TEST.
    let exe = std::env::current_exe().unwrap_or_default();
    let path = exe.ancestors().nth(2).map(|profile| profile.join(name)).unwrap_or_default();
    if !path.is_file() {
        panic!("{} is not built: cargo build --release -p rcs_app --bins", path.display());
    }
    path
}
