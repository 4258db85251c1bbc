//! Which files of a crate use each other in a circle.
//!
//! A file is tied to the file that *defines* an item it names, however many modules re-export it on the way; files that
//! only declare and re-export define nothing, so no circle passes through them. A file may use its own submodules, and
//! these what it defines: `Error` in `parse/mod.rs` is no circle with `parse/header.rs`. The code is read as rustfmt
//! lays it out.

use std::collections::{BTreeMap, BTreeSet};

/// The words of a path from the crate's root.
type Path = Vec<String>;

struct Module {
    /// The code without `use`.
    code: String,
    /// Names of the items that the file defines.
    items: BTreeSet<String>,
    imports: Vec<Import>,
}

/// A name that `use` brings in, `*` for all of a module.
struct Import {
    name: String,
    path: Path,
    is_public: bool,
}

/// The modules of a crate.
pub struct Modules(BTreeMap<Path, Module>);

impl Modules {
    /// From a crate's files: paths below `src`, texts without comments and tests.
    pub fn new(files: &[(String, String)]) -> Self {
        let mut modules = Self(files.iter().map(|(file, text)| (module_path(file), Module::new(text))).collect());
        for (file, text) in files {
            let path = module_path(file);
            let mut imports = Vec::new();
            for (is_public, tree) in uses(text) {
                expand(&tree, &[], &mut |name, words| {
                    imports.push(Import { name: name.to_owned(), path: from_root(&path, words), is_public });
                });
            }
            if let Some(module) = modules.0.get_mut(&path) {
                module.imports = imports;
            }
        }
        modules
    }

    /// The module whose file defines what a path names; none for a module itself. Globs may lead in circles: `depth`
    /// ends them.
    fn defining(&self, path: &[String], depth: usize) -> Option<&Path> {
        let longest = (0..=path.len()).rev().find(|length| self.0.contains_key(&path[..*length]))?;
        let (name, rest) = path[longest..].split_first()?;
        let (module_path, module) = self.0.get_key_value(&path[..longest])?;
        if module.items.contains(name) {
            return Some(module_path);
        }
        let through = |import: &Import| match import.name.as_str() {
            "*" => self.defining(&[&import.path, &path[longest..]].concat(), depth.checked_sub(1)?),
            imported if imported == name => self.defining(&[&import.path, rest].concat(), depth.checked_sub(1)?),
            _ => None,
        };
        module.imports.iter().find_map(through)
    }

    /// The modules that define what a module names, without those below it.
    fn used(&self, path: &Path, module: &Module) -> BTreeSet<&Path> {
        let named = paths(&module.code).map(|words| from_root(path, &words));
        // A trait may be named nowhere else.
        let imported = module.imports.iter().filter(|import| !import.is_public).map(|import| import.path.clone());
        let defining = named.chain(imported).filter_map(|words| self.defining(&words, 8));
        defining.filter(|other| !other.starts_with(path)).collect()
    }

    /// The groups of modules that use each other in a circle.
    pub fn circles(&self) -> BTreeSet<BTreeSet<String>> {
        let used: BTreeMap<&Path, BTreeSet<&Path>> =
            self.0.iter().map(|(path, module)| (path, self.used(path, module))).collect();
        let mut reached: BTreeMap<&Path, BTreeSet<&Path>> = BTreeMap::new();
        for from in self.0.keys() {
            let (mut found, mut next) = (BTreeSet::new(), vec![from]);
            while let Some(path) = next.pop() {
                next.extend(used[path].iter().filter(|path| found.insert(**path)));
            }
            reached.insert(from, found);
        }
        let in_circles = reached.iter().filter(|(path, reached)| reached.contains(*path));
        let circle = |(path, all): (&&Path, &BTreeSet<&Path>)| {
            all.iter().filter(|other| reached[*other].contains(path)).map(|path| path.join("::")).collect()
        };
        in_circles.map(circle).collect()
    }
}

impl Module {
    fn new(text: &str) -> Self {
        let mut code = String::new();
        let mut is_in_use = false;
        for line in text.lines() {
            is_in_use |= is_use(line);
            if !is_in_use {
                code.push_str(line);
                code.push('\n');
            }
            is_in_use &= !line.ends_with(';');
        }
        Self { items: code.lines().filter_map(item).collect(), code, imports: Vec::new() }
    }
}

/// The path of a file's module.
fn module_path(file: &str) -> Path {
    let path = file.trim_end_matches(".rs");
    let path = path.strip_suffix("lib").or_else(|| path.strip_suffix("mod")).unwrap_or(path);
    path.split('/').filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// The path from the root that words in a module stand for.
fn from_root(module: &[String], words: &[String]) -> Path {
    let supers = words.iter().take_while(|word| *word == "super").count();
    match words[0].as_str() {
        "crate" => words[1..].to_vec(),
        "self" => [module, &words[1..]].concat(),
        _ => [&module[..module.len().saturating_sub(supers)], &words[supers..]].concat(),
    }
}

/// Whether a line begins a `use` at a file's outermost level.
fn is_use(line: &str) -> bool {
    line.starts_with("use ") || line.starts_with("pub use ") || line.starts_with("pub(") && line.contains(") use ")
}

/// The trees of all `use`, each with whether it is public to any degree.
fn uses(text: &str) -> Vec<(bool, String)> {
    let mut found = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if is_use(line) {
            let mut whole = line.to_owned();
            while !whole.ends_with(';') {
                let Some(line) = lines.next() else { break };
                whole.push_str(line);
            }
            let tree = whole.split_once("use ").map_or("", |(_, tree)| tree.trim_end_matches(';'));
            found.push((line.starts_with("pub"), tree.to_owned()));
        }
    }
    found
}

/// Calls `found` with each name that a tree of `use` brings in, and with its path.
fn expand(tree: &str, before: &[String], found: &mut impl FnMut(&str, &[String])) {
    let tree = tree.trim();
    let path = |part: &str| {
        let words = part.split("::").map(|word| word.trim().to_owned());
        before.iter().cloned().chain(words).collect::<Path>()
    };
    if let Some((start, inner)) = tree.strip_suffix('}').and_then(|tree| tree.split_once('{')) {
        let start = path(start.trim_end_matches("::"));
        let mut depth = 0;
        let separates = |letter| {
            depth += i32::from(letter == '{') - i32::from(letter == '}');
            letter == ',' && depth == 0
        };
        inner
            .split(separates)
            .filter(|part| !part.trim().is_empty())
            .for_each(|part| expand(part, &start, &mut *found));
        return;
    }
    let (whole, name) = tree.split_once(" as ").map_or((tree, None), |(whole, name)| (whole, Some(name)));
    let mut words = path(whole);
    let last = words.pop_if(|last| ["*", "self"].contains(&last.as_str()));
    let name = name.or(last.as_deref().filter(|last| *last == "*")).or(words.last().map(String::as_str));
    found(name.unwrap_or_default(), &words);
}

fn is_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// The name of the item that a line begins at a file's outermost level.
fn item(line: &str) -> Option<String> {
    let kinds = ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "macro_rules!"];
    let line = line.strip_prefix("pub").map_or(line, |rest| rest.split_once(' ').map_or(rest, |(_, rest)| rest));
    let mut words = line.split(' ').skip_while(|word| ["unsafe", "extern", "\"C\""].contains(word));
    let kind = words.next().filter(|word| kinds.contains(word))?;
    let name = words.find(|word| kind != "const" || *word != "fn")?;
    Some(name.chars().take_while(|letter| is_word(*letter)).collect())
}

/// All paths in code, of one word or more.
fn paths(code: &str) -> impl Iterator<Item = Path> + '_ {
    let tokens = code.split(|letter| !is_word(letter) && letter != ':').map(|token| token.trim_matches(':'));
    tokens.filter(|token| !token.is_empty()).map(|token| token.split("::").map(str::to_owned).collect())
}
