//! The layers of `docs/contributing/architecture.md`: dependencies between crates point downwards only, no crate uses
//! what is not its task, and the page explains each folder and dependency.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use rcs_tests::modules::Modules;
use rcs_tests::programs::repository;
use rcs_tests::sources::{missing, rust_files, sources, texts};

/// The crates from the bottom up, each with the crates from crates.io that would give it a task of another one.
const LAYERS: [(&str, &[&str]); 30] = [
    ("text", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit", "image"]),
    ("user_files", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit", "image"]),
    ("calibration", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit", "image", "serde"]),
    ("scan_simulator", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit", "image", "serde"]),
    ("process", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("scene", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("camera", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("transforms", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("robot", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("messages", &["rosbag", "wgpu", "winit"]),
    ("rviz_config", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("resources", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("displays", &["rosrust", "rosbag", "wgpu", "winit"]),
    ("render", &["rosrust", "rosrust_msg", "rosbag", "winit"]),
    ("confirm", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("files", &["rosrust", "rosbag", "wgpu", "winit"]),
    ("light", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("bag", &["rosrust", "wgpu", "winit"]),
    ("ros", &["rosbag", "wgpu", "winit"]),
    ("web", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit", "image"]),
    ("window", &["rosrust", "rosrust_msg", "rosbag", "wgpu"]),
    ("logging", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("node_support", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("samples", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("scan", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("projector_calibrate", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("setup", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("camera_stream", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("app", &["rosrust", "rosrust_msg", "wgpu", "winit", "rosbag"]),
    ("capi", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
];

/// The crates that may be part of the static library that rviz's plugin links, so that it is built in less than a
/// minute and without the definitions of messages.
const IN_THE_STATIC_LIBRARY: [&str; 8] =
    ["calibration", "camera", "capi", "process", "rviz_config", "scene", "text", "user_files"];

/// The crates that may have `unsafe`: neither C's pointers can be read nor the C library be called without it.
const UNSAFE: [&str; 2] = ["capi", "process"];

/// Lower crates that a crate must not use all the same: the renderers know no messages, the displays no renderers, and
/// so on. What is allowed across: an image encoding or an image of `scene`, which settings, topics and windows share.
const APART: [(&str, &[&str]); 13] = [
    ("robot", &["scene", "transforms"]),
    ("rviz_config", &["transforms", "messages"]),
    ("resources", &["transforms", "messages", "rviz_config"]),
    ("displays", &["bag", "files", "render", "ros", "window"]),
    ("render", &["transforms", "messages", "rviz_config", "resources", "displays"]),
    ("confirm", &["transforms", "messages", "rviz_config", "resources", "displays"]),
    ("files", &["transforms", "rviz_config", "resources", "displays", "render"]),
    ("bag", &["scene", "transforms", "rviz_config", "resources", "displays", "render", "files"]),
    ("ros", &["transforms", "rviz_config", "resources", "displays", "render", "files", "bag"]),
    ("setup", &["displays", "render", "bag", "scan", "projector_calibrate"]),
    ("scan", &["ros", "window", "render", "logging", "node_support", "samples"]),
    ("web", &["messages", "transforms", "rviz_config", "resources", "displays", "render", "files", "bag", "ros"]),
    ("window", &["messages", "transforms", "rviz_config", "resources", "displays", "render", "bag", "ros"]),
];

/// The folders of all crates, by the names that the tables give them.
fn crate_folders() -> BTreeMap<String, PathBuf> {
    let core = LAYERS.iter().map(|(name, _)| ((*name).to_owned(), repository().join("rust_core").join(name)));
    let tests = ["tests", "tests/support", "tests/fuzz_harness"];
    let tests = tests.map(|name| (name.to_owned(), repository().join(name)));
    core.chain(tests).collect()
}

/// What a manifest depends on.
#[derive(Default)]
struct Dependencies {
    of_crate: BTreeSet<String>,
    /// Those of its tests, benchmarks and examples.
    of_tests: BTreeSet<String>,
}

fn dependencies(folder: &Path) -> Dependencies {
    let manifest = folder.join("Cargo.toml");
    let text = fs::read_to_string(&manifest).unwrap_or_else(|error| panic!("{}: {error}", manifest.display()));
    let mut section = "";
    let mut found = Dependencies::default();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')) {
        if line.starts_with('[') {
            section = line;
        } else if let Some(kind) = section.strip_suffix("dependencies]") {
            let names = if kind.ends_with("dev-") { &mut found.of_tests } else { &mut found.of_crate };
            names.extend(line.split(['.', ' ', '=']).next().map(str::to_owned));
        }
    }
    assert!(!found.of_crate.is_empty(), "{} has no dependencies: is it read?", manifest.display());
    found
}

/// The name in the tables of a crate of this repository; none for one from crates.io.
fn own_name(dependency: &str) -> Option<String> {
    let name = dependency.strip_prefix("rcs_")?;
    Some(match name {
        "test_support" => "tests/support".to_owned(),
        "fuzz_harness" => "tests/fuzz_harness".to_owned(),
        _ => name.to_owned(),
    })
}

#[test]
fn dependencies_point_downwards_only() {
    for (level, (name, foreign)) in LAYERS.iter().enumerate() {
        let dependencies = dependencies(&crate_folders()[*name]).of_crate;
        let above = LAYERS[level..].iter().map(|(above, _)| format!("rcs_{above}"));
        for wrong in above.chain(foreign.iter().map(|name| (*name).to_owned())) {
            assert!(!dependencies.contains(&wrong), "{name} depends on {wrong}");
        }
    }
    for (name, apart) in APART {
        let dependencies = dependencies(&crate_folders()[name]).of_crate;
        for wrong in apart {
            assert!(!dependencies.contains(&format!("rcs_{wrong}")), "{name} depends on rcs_{wrong}");
        }
    }
}

#[test]
fn files_do_not_use_each_other_in_a_circle() {
    let mut crates: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (file, text) in texts() {
        let parts = file.strip_prefix("rust_core/").and_then(|file| file.split_once("/src/"));
        let (name, file) = parts.unwrap_or_else(|| panic!("{file} is in no crate"));
        crates.entry(name.to_owned()).or_default().push((file.to_owned(), text));
    }
    for (name, files) in crates {
        let circles = Modules::new(&files).circles();
        assert!(circles.is_empty(), "rust_core/{name}: files in circles: {circles:#?}");
    }
}

#[test]
fn circles_of_files_are_recognised() {
    let circles = |files: &[(&str, &str)]| {
        let files: Vec<_> = files.iter().map(|(file, text)| ((*file).to_owned(), (*text).to_owned())).collect();
        Modules::new(&files).circles().into_iter().flatten().collect::<Vec<_>>()
    };
    let root = ("lib.rs", "mod a;\nmod b;\npub use a::Ant;\npub use b::{\n    Bee,\n    Wasp as Hornet,\n};\n");
    let ant = ("a.rs", "use crate::Hornet;\n\npub struct Ant(Hornet);\n");
    assert_eq!(circles(&[root, ant, ("b.rs", "pub struct Bee;\npub struct Wasp(Vec<crate::Ant>);\n")]), ["a", "b"]);
    assert_eq!(circles(&[root, ant, ("b/mod.rs", "use super::*;\n\npub enum Wasp {\n    Of(Ant),\n}\n")]), ["a", "b"]);
    assert_eq!(circles(&[root, ant, ("b.rs", "pub struct Bee;\npub struct Wasp(Bee);\n")]), [""; 0]);
    // A module and what it consists of.
    let parent = ("a/mod.rs", "mod c;\n\npub const fn sting() {\n    c::sting(Ant);\n}\npub(crate) struct Ant;\n");
    assert_eq!(circles(&[root, parent, ("a/c.rs", "pub fn sting(_: super::Ant) {}\n")]), [""; 0]);
}

/// Whether a line has the keyword, or an attribute that allows it. Comments and names in quotes have neither.
fn allows_unsafe_code(line: &str) -> bool {
    let code = line.trim_start();
    let is_attribute = code.starts_with('#') || code.starts_with("unsafe_code");
    let is_forbidden = code.contains("forbid(unsafe_code)") || code.contains("deny(unsafe_code)");
    let is_part = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '"' | '`');
    let has_keyword = code.match_indices("unsafe").any(|(at, keyword)| {
        let (before, after) = (&code[..at], &code[at + keyword.len()..]);
        !before.ends_with(is_part) && !after.starts_with(is_part)
    });
    !code.starts_with("//") && (has_keyword || is_attribute && code.contains("unsafe_code") && !is_forbidden)
}

#[test]
fn unsafe_code_is_recognised() {
    // Put in here, so that this file does not have it.
    let with_keyword = |line: &str| line.replace("KEYWORD", "unsafe");
    for line in ["    let x = KEYWORD { y() };", "KEYWORD", "pub KEYWORD fn f() {}", "#[KEYWORD(no_mangle)]"] {
        assert!(allows_unsafe_code(&with_keyword(line)), "{line}");
    }
    for line in ["#![expect(unsafe_code, reason = \"\")]", "#[allow(dead_code, unsafe_code)]", "    unsafe_code,"] {
        assert!(allows_unsafe_code(line), "{line}");
    }
    for line in ["#![forbid(unsafe_code)]", "    // no KEYWORD code", "is(\"KEYWORD\")", "let KEYWORD_code = 1;"] {
        assert!(!allows_unsafe_code(&with_keyword(line)), "{line}");
    }
}

#[test]
fn the_static_library_is_small() {
    for name in IN_THE_STATIC_LIBRARY {
        for used in dependencies(&crate_folders()[name]).of_crate.iter().filter_map(|name| own_name(name)) {
            assert!(IN_THE_STATIC_LIBRARY.contains(&&*used), "{name} depends on {used}");
        }
    }
}

#[test]
fn the_crates_with_unsafe_code_must_explain_each_use() {
    let workspace = fs::read_to_string(repository().join("Cargo.toml")).expect("Cargo.toml can be read");
    let lints = workspace.split("[workspace.lints.").skip(1).flat_map(|table| table.lines().skip(1));
    let lints = lints.take_while(|line| !line.starts_with("[profile"));
    let lints: Vec<&str> = lints.filter(|line| line.contains(" = ") && !line.contains("unsafe_code")).collect();
    for name in UNSAFE {
        let manifest = crate_folders()[name].join("Cargo.toml");
        let text = fs::read_to_string(&manifest).unwrap_or_else(|error| panic!("{}: {error}", manifest.display()));
        // All others are those of the workspace, which it cannot take over in part.
        for lint in ["unsafe_op_in_unsafe_fn = \"deny\"", "undocumented_unsafe_blocks = \"warn\""].iter().chain(&lints)
        {
            assert!(text.contains(lint), "{}: no {lint}", manifest.display());
        }
    }
}

#[test]
fn no_other_file_contains_unsafe_code() {
    let with_unsafe = UNSAFE.map(|name| crate_folders()[name].clone());
    for folder in crate_folders().values().filter(|folder| !with_unsafe.contains(folder)) {
        let root = folder.join("src/lib.rs");
        let text = fs::read_to_string(&root).unwrap_or_else(|error| panic!("{}: {error}", root.display()));
        assert!(text.contains("#![forbid(unsafe_code)]"), "{} does not forbid it", root.display());
    }
    // Programs, tests, benchmarks and examples have roots of their own.
    let files = rust_files(&repository());
    assert!(
        files.iter().any(|file| file.ends_with("src/bin/camera_stream.rs")),
        "the programs are not among {files:?}"
    );
    // Of the lower crate, one file.
    let is_allowed = |file: &PathBuf| {
        file.starts_with(&with_unsafe[0]) || file.starts_with(&with_unsafe[1]) && file.ends_with("src/memory.rs")
    };
    for file in files.iter().filter(|file| !is_allowed(file)) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let found = text.lines().find(|line| allows_unsafe_code(line));
        assert_eq!(found, None, "{}", file.display());
    }
}

/// Their manifests say that there is nothing to compile for tests in them.
#[test]
fn programs_hold_no_tests() {
    let files = rust_files(&repository());
    let programs = files.iter().filter(|file| file.components().any(|part| part.as_os_str() == "bin"));
    let mut checked = 0;
    for file in programs {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        assert!(!text.contains("#[test]"), "{}: cargo does not run its tests", file.display());
        checked += 1;
    }
    assert!(checked > 10, "{checked} programs");
}

/// `thread::spawn` and the like are forbidden in clippy.toml.
#[test]
fn every_thread_is_started_with_a_name() {
    let mut started = 0;
    for (file, code) in sources() {
        for (builder, name) in [("thread::Builder::new()", ".name("), ("ThreadPoolBuilder::new()", ".thread_name(")] {
            for rest in code.split(builder).skip(1) {
                assert!(rest.starts_with(name), "{file} starts a thread without a name");
                started += 1;
            }
        }
    }
    assert!(started > 20, "{started} threads");
}

/// The pool of threads that share work has names if it is named before its first use: by each program that draws or
/// calculates, and by the C interface.
#[test]
fn the_pool_of_threads_is_named_by_all_that_use_it() {
    let naming = "rcs_process::name_threads();";
    let sources = sources();
    let found: BTreeSet<&str> =
        sources.iter().filter(|(_, code)| code.contains(naming)).map(|(file, _)| file.as_str()).collect();
    let expected = [
        "rust_core/app/src/projector_blend/mod.rs",
        "rust_core/projector_calibrate/src/lib.rs",
        "rust_core/camera_stream/src/check/session.rs",
        "rust_core/camera_stream/src/lib.rs",
        "rust_core/camera_stream/src/runtime/mod.rs",
        "rust_core/capi/src/camera.rs",
        "rust_core/samples/src/simulate_scan/mod.rs",
    ];
    assert_eq!(found, BTreeSet::from(expected));
}

/// What works for the images on a thread of its own is watched, or a hang of it is not named in the log.
#[test]
fn what_works_for_the_images_is_watched() {
    let registering = [
        ("runtime/mod.rs", "let_watchdog=Watchdog::start()"),
        ("runtime/shared.rs", "watchdog::watch(&activity);"),
        ("runtime/control_thread.rs", "Task::watched(\"answeringcalls\")"),
        ("outputs/compressed.rs", "Task::watched(format!(\"compressingapictureof{}\""),
        ("outputs/page.rs", "Task::watched(\"encodinganimageforthepage\")"),
        ("outputs/window.rs", "watchdog::watch(&worker);"),
    ];
    assert_eq!(missing("rust_core/camera_stream/src", &registering), [""; 0]);
}

#[test]
fn messages_use_no_connection_of_rosrust() {
    let types = ["Duration", "Message", "RosMsg", "ServicePair", "Time"];
    let sources = fs::read_dir(repository().join("rust_core/messages/src")).expect("the sources can be read");
    let mut checked = 0;
    for path in sources.map(|entry| entry.expect("its entries can be read").path()) {
        let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        for used in text.split("rosrust::").skip(1) {
            let list = used.strip_prefix('{').and_then(|list| list.split('}').next()).unwrap_or(used);
            let names = if used.starts_with('{') { list.split(',').collect() } else { vec![list] };
            for name in names {
                let word: String = name.trim().chars().take_while(|letter| letter.is_alphanumeric()).collect();
                assert!(types.contains(&&*word), "{} uses rosrust::{word}", path.display());
                checked += 1;
            }
        }
    }
    assert!(checked > 0, "no use of rosrust was found");
}

#[test]
fn every_folder_of_the_core_is_a_layer() {
    let folders: BTreeSet<String> = fs::read_dir(repository().join("rust_core"))
        .expect("rust_core is there")
        .filter_map(|entry| entry.ok().filter(|entry| entry.path().is_dir())?.file_name().into_string().ok())
        .collect();
    let layers: BTreeSet<String> = LAYERS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(folders, layers);
}

// --- the tables of docs/contributing/architecture.md -----------------------------------------------------------------

const PAGE: &str = "docs/contributing/architecture.md";

/// The rows of the table with these headings, cell by cell.
fn table(heading: &str) -> Vec<Vec<String>> {
    let page = repository().join(PAGE);
    let page = fs::read_to_string(&page).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
    let mut lines = page.lines().skip_while(|line| *line != heading).skip(2);
    let mut rows = Vec::new();
    while let Some(row) = lines.next().and_then(|line| line.strip_prefix('|')?.strip_suffix('|')) {
        rows.push(row.split('|').map(|cell| cell.trim().to_owned()).collect());
    }
    assert!(!rows.is_empty(), "{PAGE} has no table {heading}");
    rows
}

/// The names in the first column of a table, each once and with an explanation.
fn explained(heading: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for row in table(heading) {
        assert!(row.iter().all(|cell| !cell.is_empty()), "{row:?} explains nothing");
        for name in row[0].split(", ").map(|name| name.trim_matches('`').to_owned()) {
            assert!(names.insert(name), "{} stands there twice", row[0]);
        }
    }
    names
}

#[test]
fn every_crate_is_explained() {
    let explained = explained("|folder|contents|");
    for name in crate_folders().into_keys() {
        let folder = if name.starts_with("tests") { name } else { format!("rust_core/{name}") };
        assert!(explained.contains(&folder), "{PAGE} has no row for {folder}");
    }
    for folder in explained {
        assert!(repository().join(&folder).exists(), "{PAGE}: there is no {folder}");
    }
}

/// Where a manifest gives a dependency's version, a comment above says what it is for.
#[test]
fn every_direct_dependency_is_justified() {
    let manifests = crate_folders().into_values().map(|folder| folder.join("Cargo.toml"));
    let (mut checked, mut wrong) = (0, Vec::new());
    for manifest in manifests.chain([repository().join("Cargo.toml")]) {
        let text = fs::read_to_string(&manifest).unwrap_or_else(|error| panic!("{}: {error}", manifest.display()));
        let (mut is_dependency, mut above) = (false, "");
        for line in text.lines() {
            if line.starts_with('[') {
                is_dependency = line.trim_end_matches(']').ends_with("dependencies");
            } else if is_dependency && (line.contains("= \"") || line.contains("{ version =")) {
                checked += 1;
                if !above.starts_with("# ") && !line.contains("path = ") {
                    wrong.push(format!("{}: {line}", manifest.display()));
                }
            }
            above = line;
        }
    }
    assert!(checked > 50, "only {checked} dependencies were found");
    assert!(wrong.is_empty(), "nothing says what these are for:\n{}", wrong.join("\n"));
}

#[test]
fn the_workspace_lists_no_dependency_that_nobody_uses() {
    let text = fs::read_to_string(repository().join("Cargo.toml")).expect("Cargo.toml can be read");
    let section = text.split("[workspace.dependencies]").nth(1).expect("Cargo.toml has workspace.dependencies");
    let section = section.split("\n[").next().unwrap_or_default();
    let used: BTreeSet<String> = crate_folders()
        .values()
        .map(|folder| dependencies(folder))
        .flat_map(|found| found.of_crate.into_iter().chain(found.of_tests))
        .collect();
    for line in section.lines().filter(|line| !line.starts_with('#') && line.contains('=')) {
        let name = line.split([' ', '=']).next().unwrap_or_default();
        assert!(used.contains(name), "Cargo.toml lists {name}, which no crate uses");
    }
}
