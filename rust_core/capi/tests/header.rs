//! The header of the C interface is up to date.
//!
//! With `RCS_WRITE_HEADER=1`, the header is written instead of compared.

#![expect(clippy::expect_used, reason = "what fails is the test")]

use std::fs;
use std::path::{Path, PathBuf};

use cbindgen::{Builder, Config, DocumentationStyle, EnumConfig, ExportConfig, Language, RenameRule, SortKey, Style};

/// The modules with exports, in the order of their functions in the header.
const MODULES: [&str; 10] =
    ["version", "fault", "guard", "encoding", "view", "camera", "pacing", "pixels", "statistics", "config_report"];

const HEADER: &str = "\
/* The Rust core's C interface for rviz's CameraPub plugin.
 *
 * Generated from rust_core/capi by cbindgen. To write it again:
 * RCS_WRITE_HEADER=1 cargo test --release -p rcs_capi --test header
 *
 * Handles. An RcsCamera is used by one thread at a time; different cameras by different threads at once. All other
 * functions may be called by any thread at any time.
 *
 * Pointers. The caller owns all memory except handles, and it is not used after a call. Each pointer may be NULL: if
 * it is required, the call fails with RCS_RESULT_NULL_POINTER (or returns 0, false or nothing if it has no result
 * code) and writes nothing. Static texts are never freed. Numbers have the machine's byte order.
 *
 * Errors. A call fails if it returns an RcsResult other than RCS_RESULT_OK. rcs_last_error has the error of the last
 * failed call on the same thread, also of calls without a result code. No call ends the process or throws, except that
 * a lack of memory ends the process.
 *
 * Linking. The library is librcs_capi.a, with -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc. A shared library that links
 * it should hide its symbols and drop unused code, which makes it 1 MB larger instead of 6:
 * -Wl,--exclude-libs,librcs_capi.a -Wl,--gc-sections.
 */";

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn header_path() -> PathBuf {
    crate_folder().join("../../ros_pkg/include/rviz_camera_stream/core.h")
}

fn config() -> Config {
    // Unchecked numbers, by their names in C.
    let renamed = [
        ("Flag", "bool"),
        ("ProjectionNumber", "enum RcsProjection"),
        ("EncodingNumber", "enum RcsEncoding"),
        ("PixelOrderNumber", "enum RcsPixelOrder"),
    ];
    Config {
        language: Language::C,
        cpp_compat: true,
        style: Style::Both,
        header: Some(HEADER.to_owned()),
        include_guard: Some("RVIZ_CAMERA_STREAM_CORE_H".to_owned()),
        documentation_style: DocumentationStyle::Doxy,
        no_includes: true,
        sys_includes: ["stdbool.h", "stddef.h", "stdint.h"].map(str::to_owned).to_vec(),
        line_length: 120,
        tab_width: 2,
        usize_is_size_t: true,
        sort_by: SortKey::None,
        export: ExportConfig {
            include: ["RcsProjection", "RcsPixelOrder"].map(str::to_owned).to_vec(),
            rename: renamed.map(|(from, to)| (from.to_owned(), to.to_owned())).into(),
            ..ExportConfig::default()
        },
        enumeration: EnumConfig { rename_variants: RenameRule::QualifiedScreamingSnakeCase, ..EnumConfig::default() },
        ..Config::default()
    }
}

/// The header of the sources.
fn generated() -> String {
    let sources = MODULES.iter().map(|module| crate_folder().join(format!("src/{module}.rs")));
    let builder = sources.fold(Builder::new().with_config(config()), Builder::with_src);
    let mut header = Vec::new();
    builder.generate().expect("cbindgen reads the sources").write(&mut header);
    let header = String::from_utf8(header).expect("the sources are text");
    for_c(&header)
}

/// Removes the sections on safety, which repeat the rules at the top.
fn for_c(header: &str) -> String {
    let mut lines = Vec::new();
    let mut is_safety = false;
    for line in header.lines() {
        let text = line.trim();
        if text == "* # Safety" {
            is_safety = true;
            // The empty line before it.
            lines.pop();
        } else if text.starts_with("*/") {
            is_safety = false;
        }
        if !is_safety {
            lines.push(line.trim_end());
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn the_header_is_up_to_date() {
    let generated = generated();
    if std::env::var_os("RCS_WRITE_HEADER").is_some() {
        fs::create_dir_all(header_path().parent().expect("it has a folder")).expect("the folder can be made");
        fs::write(header_path(), &generated).expect("the header can be written");
    }
    let present = fs::read_to_string(header_path()).unwrap_or_default();
    let first = generated.lines().zip(present.lines()).position(|(a, b)| a != b);
    assert!(
        generated == present,
        "{} is stale from line {:?} on; write it: RCS_WRITE_HEADER=1 cargo test --release -p rcs_capi --test header",
        header_path().display(),
        first.map_or(present.lines().count(), |line| line) + 1
    );
}

#[test]
fn every_exported_function_is_in_the_header_with_a_comment() {
    let header = generated();
    let mut functions = 0;
    for entry in fs::read_dir(crate_folder().join("src")).expect("the sources are there") {
        let text = fs::read_to_string(entry.expect("an entry").path()).expect("text");
        for exported in text.split("#[no_mangle]").skip(1) {
            let name =
                exported.split("extern \"C\" fn ").nth(1).and_then(|rest| rest.split('(').next()).expect("a name");
            let (before, _) =
                header.split_once(&format!("{name}(")).unwrap_or_else(|| panic!("no {name} in the header"));
            let declaration = before.rsplit("\n\n").next().unwrap_or_default();
            assert!(declaration.trim_start().starts_with("/*"), "{name} has no comment");
            functions += 1;
        }
    }
    assert_eq!(functions, 19, "each function that C sees");
}

#[test]
fn comments_fit_into_120_columns() {
    for line in generated().lines() {
        assert!(line.chars().count() <= 120, "{line}");
    }
}
