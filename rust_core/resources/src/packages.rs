//! `package://NAME/path` and `file://` addresses into file paths.
//!
//! Packages are found by rospack's rules. The folders of `ROS_PACKAGE_PATH` are searched in order, and the first match
//! wins; a folder with a `package.xml` or a `manifest.xml` is a package and is not searched further; a folder with a
//! file `CATKIN_IGNORE` is skipped with all in it, one with `rospack_nosubdirs` is not searched further; folders that
//! begin with a dot are skipped; links are followed. A package's name is the `<name>` in its `package.xml`; with a
//! `manifest.xml` (rosbuild) it is the folder's. Among siblings of one name rospack takes the first in the file
//! system's order; here it is the alphabetically first. A folder that links back into its own path, at which rospack
//! gives up after a thousand levels, is searched once.
//!
//! A package directly in a search folder under its own name, as in an installed `share` folder, is found without a
//! search. A package that was not found may be installed later, so its folder is searched again, at most a twentieth of
//! the time.

use std::{
    collections::{HashMap, HashSet},
    env, fs,
    path::{Component, Path, PathBuf},
    sync::{
        atomic::{AtomicBool, Ordering},
        Mutex,
    },
    time::{Duration, Instant},
};

use percent_encoding::percent_decode_str;
use rcs_process::lock;
use rcs_text::xml;

use crate::{files::read_small_text, ResourceError};

/// Deepest search. rospack's `MAX_CRAWL_DEPTH` is 1000, but no real tree is as deep as this.
const MAX_DEPTH: usize = 100;
/// Most folders that are searched below a search folder.
const MAX_FOLDERS: usize = 1_000_000;
/// Most bytes of a manifest.
const MAX_MANIFEST_BYTES: u64 = 1 << 20;
/// Shortest time between two searches of a folder, and its smallest ratio to the duration of a search.
const SEARCH_INTERVAL: Duration = Duration::from_secs(10);
const SEARCH_INTERVAL_FACTOR: u32 = 20;

/// Finds packages by name, and files by their `package://` and `file://` addresses.
///
/// ```
/// use std::path::{Path, PathBuf};
///
/// use rcs_resources::PackageIndex;
///
/// let packages = PackageIndex::new([PathBuf::from("/opt/ros/noetic/share")]);
/// let path = packages.resolve("file:///tmp/left%20arm.stl")?;
/// assert_eq!(path, Path::new("/tmp/left arm.stl"));
/// assert!(packages.resolve("http://example.org/arm.stl").is_err());
/// # Ok::<(), rcs_resources::ResourceError>(())
/// ```
#[derive(Debug)]
pub struct PackageIndex {
    roots: Vec<SearchFolder>,
}

/// A folder of the search path.
#[derive(Debug)]
struct SearchFolder {
    path: PathBuf,
    /// Results so far.
    known: Mutex<KnownPackages>,
    /// `true` if the next request for a package that was not found searches again at once.
    is_outdated: AtomicBool,
}

#[derive(Debug, Default)]
struct KnownPackages {
    /// Packages by name.
    packages: HashMap<String, PathBuf>,
    /// Earliest time of the next search; `None` before the first one.
    next_crawl: Option<Instant>,
}

impl PackageIndex {
    /// An index of the folders of `extra`, then of the environment's `ROS_PACKAGE_PATH`. Reads no files.
    pub fn from_env(extra: &[PathBuf]) -> Self {
        let from_env = env::var_os("ROS_PACKAGE_PATH").unwrap_or_default();
        Self::new(extra.iter().cloned().chain(env::split_paths(&from_env)))
    }

    /// An index of folders, in the order of search. Reads no files.
    pub fn new(roots: impl IntoIterator<Item = PathBuf>) -> Self {
        let roots = roots
            .into_iter()
            .filter(|path| !path.as_os_str().is_empty())
            .map(|path| SearchFolder { path, known: Mutex::default(), is_outdated: AtomicBool::new(false) })
            .collect();
        Self { roots }
    }

    /// The folder of a package; `None` for an unknown name.
    pub fn package(&self, name: &str) -> Option<PathBuf> {
        self.roots.iter().find_map(|root| root.find(name))
    }

    /// Lets the next request for a package that was not found search again at once. Does not wait for a search.
    pub(crate) fn search_again(&self) {
        self.roots.iter().for_each(|root| root.is_outdated.store(true, Ordering::Release));
    }

    /// The file of an address: `package://NAME/path`, `file:///path`, or a bare absolute path. `%20` and the like are
    /// decoded in addresses, as in resource_retriever's curl. The file need not exist.
    ///
    /// # Errors
    /// [`ResourceError::NoSuchPackage`]; [`ResourceError::UnsupportedScheme`] for `http://` and others;
    /// [`ResourceError::LeavesPackage`]; [`ResourceError::BadUrl`] for anything that is not an address.
    pub fn resolve(&self, url: &str) -> Result<PathBuf, ResourceError> {
        let bad = || ResourceError::BadUrl(url.to_owned());
        if url.starts_with('/') {
            return Ok(PathBuf::from(url));
        }
        let (scheme, rest) = url.split_once(':').ok_or_else(bad)?;
        match scheme.to_ascii_lowercase().as_str() {
            "package" => {
                let rest = rest.strip_prefix("//").ok_or_else(bad)?;
                let (package, path) = rest.split_once('/').ok_or_else(bad)?;
                if package.is_empty() {
                    return Err(bad());
                }
                let package = decode(package);
                let path = decode(path);
                let Some(path) = within(&path) else {
                    return Err(ResourceError::LeavesPackage { url: url.to_owned(), package });
                };
                let folder = self.package(&package).ok_or_else(|| ResourceError::NoSuchPackage {
                    url: url.to_owned(),
                    package,
                    searched: self.roots.iter().map(|root| root.path.clone()).collect(),
                })?;
                Ok(folder.join(path))
            }
            "file" => {
                // file:///path, file://localhost/path and file:/path
                let path = match rest.strip_prefix("//") {
                    Some(rest) => rest.strip_prefix("localhost").unwrap_or(rest),
                    None => rest,
                };
                if path.starts_with('/') {
                    Ok(PathBuf::from(decode(path)))
                } else {
                    Err(bad())
                }
            }
            scheme if rest.starts_with("//") => {
                Err(ResourceError::UnsupportedScheme { url: url.to_owned(), scheme: scheme.to_owned() })
            }
            _ => Err(bad()),
        }
    }
}

impl SearchFolder {
    fn find(&self, name: &str) -> Option<PathBuf> {
        let mut known = lock(&self.known);
        if let Some(found) = known.packages.get(name) {
            return Some(found.clone());
        }
        if let Some(found) = self.find_directly(name) {
            known.packages.insert(name.to_owned(), found.clone());
            return Some(found);
        }
        let begin = Instant::now();
        let is_outdated = self.is_outdated.swap(false, Ordering::AcqRel);
        if !is_outdated && known.next_crawl.is_some_and(|next| begin < next) {
            return None;
        }
        known.packages = crawl(&self.path);
        let end = Instant::now();
        known.next_crawl = Some(end + SEARCH_INTERVAL.max((end - begin) * SEARCH_INTERVAL_FACTOR));
        known.packages.get(name).cloned()
    }

    /// The package in the subfolder of its own name, if rospack's rules lead there.
    fn find_directly(&self, name: &str) -> Option<PathBuf> {
        if name.starts_with('.') || name.contains(['/', '\0']) {
            return None;
        }
        let stops = ["CATKIN_IGNORE", "rospack_nosubdirs", "package.xml", "manifest.xml"];
        if stops.iter().any(|file| self.path.join(file).is_file()) {
            return None;
        }
        let folder = self.path.join(name);
        if folder.join("CATKIN_IGNORE").is_file() {
            return None;
        }
        (package_name(&folder)? == name).then_some(folder)
    }
}

/// The name of the package in a folder; `None` if the folder is no package.
fn package_name(folder: &Path) -> Option<String> {
    let folder_name = || folder.file_name().map(|name| name.to_string_lossy().into_owned());
    if folder.join("manifest.xml").is_file() {
        return folder_name();
    }
    let manifest = folder.join("package.xml");
    if !manifest.is_file() {
        return None;
    }
    let named = read_small_text(&manifest, MAX_MANIFEST_BYTES).and_then(|text| {
        let document = xml::parse(&text).map_err(|error| error.to_string())?;
        let name = document.elements.first().and_then(|package| package.child("name"));
        Ok(name.ok_or("no package name in it")?.text.trim().to_owned())
    });
    match named {
        Ok(name) => Some(name),
        Err(reason) => {
            log::warn!("{}: {reason}; using the folder's name", manifest.display());
            folder_name()
        }
    }
}

/// All packages in a folder.
fn crawl(root: &Path) -> HashMap<String, PathBuf> {
    let mut packages = HashMap::new();
    let mut seen = HashSet::new();
    // Depth first, each folder's children in alphabetical order.
    let mut waiting = vec![(root.to_owned(), 0)];
    let mut searched = 0;
    while let Some((folder, depth)) = waiting.pop() {
        searched += 1;
        if searched > MAX_FOLDERS {
            log::warn!("{}: more than {MAX_FOLDERS} folders in it, the others are not searched", root.display());
            break;
        }
        let Ok(entries) = fs::read_dir(&folder) else { continue };
        let mut is_package = false;
        let mut is_leaf = false;
        let mut ignored = false;
        let mut children = Vec::new();
        for entry in entries.flatten() {
            let name = entry.file_name();
            let Ok(kind) = entry.file_type() else { continue };
            let path = entry.path();
            let is_dir = kind.is_dir() || (kind.is_symlink() && path.is_dir());
            if is_dir {
                if !name.to_string_lossy().starts_with('.') {
                    children.push((path, kind.is_symlink()));
                }
            } else if kind.is_file() || path.is_file() {
                match name.to_str() {
                    Some("CATKIN_IGNORE") => ignored = true,
                    Some("rospack_nosubdirs") => is_leaf = true,
                    Some("package.xml" | "manifest.xml") => is_package = true,
                    _ => {}
                }
            }
        }
        if ignored {
            continue;
        }
        if is_package {
            if let Some(name) = package_name(&folder) {
                packages.entry(name).or_insert(folder);
            }
            continue;
        }
        if is_leaf || depth == MAX_DEPTH {
            continue;
        }
        children.sort_unstable_by(|a, b| b.0.cmp(&a.0));
        for (path, is_link) in children {
            // Only links can lead to a folder twice.
            let first_time =
                !is_link || path.canonicalize().is_ok_and(|real| !folder.starts_with(&real) && seen.insert(real));
            if first_time {
                waiting.push((path, depth + 1));
            }
        }
    }
    packages
}

/// A path within a folder with `..` resolved textually; `None` if it leaves the folder.
fn within(path: &str) -> Option<PathBuf> {
    let mut inner = PathBuf::new();
    for component in Path::new(path.trim_start_matches('/')).components() {
        match component {
            Component::Normal(name) => inner.push(name),
            Component::ParentDir if !inner.pop() => return None,
            Component::ParentDir | Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(inner)
}

fn decode(text: &str) -> String {
    percent_decode_str(text).decode_utf8_lossy().into_owned()
}
