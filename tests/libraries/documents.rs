//! The links of the repository's pages lead somewhere: to a file or folder, and to a heading where they name one.
//! Source files that the pages name exist, and the pages are no longer than they may be.

use std::fs;
use std::path::{Path, PathBuf};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The pages at the root, below `docs` and in `tests/golden`.
fn pages() -> Vec<PathBuf> {
    let mut folders = vec![repository(), repository().join("tests/golden")];
    let mut pages = Vec::new();
    while let Some(folder) = folders.pop() {
        let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for path in entries.flatten().map(|entry| entry.path()) {
            if path.is_dir() && path.starts_with(repository().join("docs")) {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                pages.push(path);
            }
        }
    }
    pages
}

/// A page's text.
fn text(page: &Path) -> String {
    fs::read_to_string(page).unwrap_or_else(|error| panic!("{}: {error}", page.display()))
}

/// A page's lines outside of code blocks.
fn prose(page: &Path) -> String {
    let text = text(page);
    let outside = text.split("\n```").step_by(2);
    outside.flat_map(str::lines).filter(|line| !line.starts_with("    ")).flat_map(|line| [line, "\n"]).collect()
}

/// What Markdown links to: `[text](TARGET)` and `[text]: TARGET`.
fn targets(prose: &str) -> Vec<String> {
    let inline = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let below = prose.lines().filter_map(|line| line.strip_prefix('[')?.split_once("]: ").map(|(_, target)| target));
    inline.chain(below).map(str::to_owned).collect()
}

/// The anchor that GitHub gives a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter));
    kept.flat_map(char::to_lowercase).map(|letter| if letter == ' ' { '-' } else { letter }).collect()
}

fn anchors(page: &Path) -> Vec<String> {
    let headings = prose(page);
    headings.lines().filter(|line| line.starts_with('#')).map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn links_lead_to_files_and_headings() {
    let mut wrong = Vec::new();
    let mut checked = 0;
    for page in pages() {
        for target in targets(&prose(&page)).iter().filter(|target| !target.contains("://")) {
            let (file, heading) = target.split_once('#').unwrap_or((target, ""));
            let linked = match file {
                "" => page.clone(),
                _ => page.parent().expect("a page is in a folder").join(file),
            };
            let is_there = linked.exists() && (heading.is_empty() || anchors(&linked).iter().any(|has| has == heading));
            if !is_there {
                wrong.push(format!("{}: {target}", page.display()));
            }
            checked += 1;
        }
    }
    assert!(wrong.is_empty(), "links that lead nowhere:\n{}", wrong.join("\n"));
    assert!(checked > 40, "only {checked} links were found");
}

/// Most words of the README, and of all pages below `docs`.
const MOST_WORDS: [(&str, usize); 2] = [("README.md", 1200), ("docs/", 29_500)];

/// Words of a page, as `wc -w` counts them.
fn words(page: &Path) -> usize {
    text(page).split_whitespace().count()
}

#[test]
fn pages_are_no_longer_than_they_may_be() {
    let pages = pages();
    let counted = |start: &str| -> usize {
        pages.iter().filter(|page| page.starts_with(repository().join(start))).map(|page| words(page)).sum()
    };
    let too_long = |(name, most): &(&str, usize)| {
        let count = counted(name);
        println!("{name}: {count} of {most} words");
        (count == 0 || count > *most).then(|| format!("{name} has {count} words, not 1 to {most}"))
    };
    let too_long: Vec<String> = MOST_WORDS.iter().filter_map(too_long).collect();
    assert!(too_long.is_empty(), "{}", too_long.join("\n"));
}

/// All functions of the tests.
fn functions(folder: &Path) -> String {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let text = |path: PathBuf| {
        if path.is_dir() {
            functions(&path)
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        } else {
            String::new()
        }
    };
    entries.flatten().map(|entry| text(entry.path())).collect()
}

#[test]
fn each_fault_has_a_test_of_the_name_that_is_given() {
    let page = prose(&repository().join("docs/explanation/reliability.md"));
    let functions = functions(&repository().join("tests")) + &functions(&repository().join("rust_core"));
    let rows = page.lines().filter(|line| line.starts_with('|') && line.ends_with("`|"));
    let names: Vec<&str> = rows.filter_map(|row| row.trim_end_matches("`|").rsplit('`').next()).collect();
    assert!(names.len() > 10, "only {names:?} were found");
    let missing: Vec<_> = names.iter().filter(|name| !functions.contains(&format!("fn {name}("))).collect();
    assert!(missing.is_empty(), "there is no test {missing:?}");
}

/// `CRATE/src/…` or such a path from the root, and behind it in the same line `FILE.rs` in the same folder. Those of
/// THIRD_PARTY.md are files of others; `CLASS.rs` stands for many.
#[test]
fn source_files_that_pages_name_exist() {
    let rust_core = repository().join("rust_core");
    let (mut wrong, mut checked) = (Vec::new(), 0);
    for page in pages().iter().filter(|page| !page.ends_with("THIRD_PARTY.md")) {
        let prose = prose(page);
        for line in prose.lines() {
            let mut folder: Option<PathBuf> = None;
            for code in line.split('`').skip(1).step_by(2) {
                let is_path =
                    code.chars().all(|c| c.is_ascii_alphanumeric() || "_/.".contains(c)) && !code.contains("CLASS");
                let path = match &folder {
                    _ if is_path && code.contains("/src") && repository().join(code).exists() => {
                        repository().join(code)
                    }
                    _ if is_path && code.contains("/src") => rust_core.join(code),
                    Some(folder) if is_path && code.ends_with(".rs") && !code.contains('/') => folder.join(code),
                    _ => continue,
                };
                if !path.exists() {
                    wrong.push(format!("{}: {code}", page.display()));
                }
                folder = path.parent().map(Path::to_path_buf);
                checked += 1;
            }
        }
    }
    assert!(wrong.is_empty(), "files that do not exist:\n{}", wrong.join("\n"));
    assert!(checked > 5, "only {checked} files were found");
}

/// Of the paths in THIRD_PARTY.md, those below this project's own folders; the others are in other projects.
#[test]
fn places_that_follow_third_parties_exist() {
    let page = prose(&repository().join("THIRD_PARTY.md"));
    let is_own = |code: &&str| ["rust_core/", "ros_pkg/", "patches/"].iter().any(|folder| code.starts_with(folder));
    let own: Vec<&str> = page.split('`').skip(1).step_by(2).filter(is_own).collect();
    assert!(own.len() > 20, "only {} places were found", own.len());
    let missing: Vec<_> = own.iter().filter(|path| !repository().join(path).exists()).collect();
    assert!(missing.is_empty(), "places that do not exist: {missing:?}");
}

#[test]
fn headings_have_the_anchors_that_links_use() {
    assert_eq!(anchor(" How late is the picture?"), "how-late-is-the-picture");
    assert_eq!(anchor("`camera_stream -d FILE.rviz`"), "camera_stream--d-filerviz");
}
