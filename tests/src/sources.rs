//! The project's own sources, for tests that look through them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::programs::repository;

/// The folders of the repository that are generated.
const GENERATED: [&str; 2] = ["target", "test_output"];

/// All Rust files below a folder, without what is generated or hidden.
///
/// # Panics
/// When a folder cannot be read.
#[expect(clippy::panic, reason = "a test cannot go on")]
pub fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let unreadable = |error: std::io::Error| -> ! { panic!("{}: {error}", folder.display()) };
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap_or_else(|error| unreadable(error)) {
        let entry = entry.unwrap_or_else(|error| unreadable(error));
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            // Beside a manifest; elsewhere it is a module of that name.
            let is_generated = GENERATED.contains(&&*name) && folder.join("Cargo.toml").exists();
            if !name.starts_with('.') && !is_generated {
                files.extend(rust_files(&path));
            }
        } else if name.ends_with(".rs") {
            files.push(path);
        }
    }
    files
}

/// A source file without comments, up to its tests.
fn without_comments(text: &str) -> String {
    let mut lines = text.lines();
    let mut code = String::new();
    while let Some(line) = lines.next() {
        if line == "#[cfg(test)]" {
            let item = lines.find(|line| !line.starts_with("#[")).unwrap_or_default();
            // A module of tests in a file of its own is no end, nor is a helper for tests.
            if item.starts_with("mod ") && item.ends_with('{') {
                break;
            }
        } else if !line.trim_start().starts_with("//") {
            code.push_str(line);
            code.push('\n');
        }
    }
    code
}

/// The programs' sources by their paths in the repository, without comments and tests.
///
/// # Panics
/// When a file cannot be read.
#[expect(clippy::panic, reason = "a test cannot go on")]
pub fn texts() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for file in rust_files(&repository().join("rust_core")) {
        // Of the whole path, this crate's folder is a part.
        let name = file.strip_prefix(repository()).unwrap_or(&file);
        let has = |folder: &str| name.components().any(|part| part.as_os_str() == folder);
        if has("src") && !has("tests") && !has("tests.rs") && !has("test_world.rs") {
            let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            found.push((name.display().to_string(), without_comments(&text)));
        }
    }
    found
}

/// What of these is missing: pieces of code, without blanks, in files of a folder.
pub fn missing(folder: &str, pieces: &[(&str, &str)]) -> Vec<String> {
    let without_blanks = |(name, text): (String, String)| (name, text.split_whitespace().collect::<String>());
    let sources: Vec<(String, String)> = texts().into_iter().map(without_blanks).collect();
    let has = |file: &str, piece: &str| sources.iter().any(|(name, code)| name == file && code.contains(piece));
    let all = pieces.iter().map(|(file, piece)| (format!("{folder}/{file}"), piece));
    all.filter(|(file, piece)| !has(file, piece)).map(|(file, piece)| format!("{file} no longer has {piece}")).collect()
}
