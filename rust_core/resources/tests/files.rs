//! Which files are read: regular ones, of packages and allowed folders, of a limited size.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::{
    fs::{self, File},
    os::unix::{fs::symlink, net::UnixListener},
    path::{Path, PathBuf},
    process::Command,
    sync::Arc,
    task::Poll,
};

use common::{get, DAE, MTL, OBJ, TEXT_STL};
use rcs_resources::{LoadedMesh, MeshFault, MeshStore, PackageIndex, ResourceError, ResourceOptions, Retry};
use tempfile::TempDir;

/// A workspace: the package `robot` in `src`, and beside `src` a folder that is no package.
struct Workspace {
    dir: TempDir,
}

impl Workspace {
    fn new() -> Self {
        let dir = tempfile::tempdir().unwrap();
        for folder in ["src/robot/meshes", "outside"] {
            fs::create_dir_all(dir.path().join(folder)).unwrap();
        }
        fs::write(dir.path().join("src/robot/package.xml"), "<package><name>robot</name></package>").unwrap();
        Self { dir }
    }

    fn path(&self, path: &str) -> PathBuf {
        self.dir.path().join(path)
    }

    fn store(&self, options: ResourceOptions) -> MeshStore {
        MeshStore::with_options(PackageIndex::new([self.path("src")]), options)
    }

    fn load(&self, url: &str) -> Result<Arc<LoadedMesh>, ResourceError> {
        get(&self.store(ResourceOptions::default()), url)
    }

    fn url_of(&self, path: &str) -> String {
        format!("file://{}", self.path(path).display())
    }
}

fn make_fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn only_regular_files_are_opened() {
    let workspace = Workspace::new();
    let mesh = |name: &str| workspace.path(&format!("src/robot/{name}.stl"));
    make_fifo(&mesh("fifo"));
    fs::create_dir(mesh("folder")).unwrap();
    symlink("/dev/zero", mesh("zero")).unwrap();
    symlink("/dev/tty", mesh("terminal")).unwrap();
    let _listener = UnixListener::bind(mesh("socket")).unwrap();
    for (name, kind) in [
        ("fifo", "a FIFO"),
        ("folder", "a folder"),
        ("zero", "a device"),
        ("terminal", "a device"),
        ("socket", "a socket"),
    ] {
        let error = workspace.load(&format!("package://robot/{name}.stl")).unwrap_err();
        assert!(matches!(&error, ResourceError::NotAFile { kind: found, .. } if *found == kind), "{name}: {error}");
        assert!(error.to_string().contains("only regular files are read"), "{error}");
    }
    symlink("loop.stl", mesh("loop")).unwrap();
    assert!(matches!(workspace.load("package://robot/loop.stl"), Err(ResourceError::Io { .. })));
}

#[test]
fn what_a_mesh_names_is_held_to_the_same_rules() {
    let workspace = Workspace::new();
    let robot = workspace.path("src/robot");
    fs::write(robot.join("a.obj"), OBJ).unwrap();
    // A material library that is a FIFO is left out, as one that is missing.
    make_fifo(&robot.join("things.mtl"));
    let mesh = workspace.load("package://robot/a.obj").unwrap();
    assert!(mesh.parts.iter().all(|part| part.material.texture.is_none()));
    // So is a texture.
    fs::remove_file(robot.join("things.mtl")).unwrap();
    fs::write(robot.join("things.mtl"), MTL).unwrap();
    make_fifo(&robot.join("red.png"));
    let mesh = workspace.load("package://robot/a.obj").unwrap();
    assert!(matches!(mesh.warnings.as_slice(), [ResourceError::NotAFile { .. }]), "{:?}", mesh.warnings);
    // A texture outside of the package.
    image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 255])).save(workspace.path("outside/x.png")).unwrap();
    fs::write(robot.join("a.dae"), DAE.replace("file://tex%20ture.png", "../../outside/x.png")).unwrap();
    let mesh = workspace.load("package://robot/a.dae").unwrap();
    assert!(matches!(mesh.warnings.as_slice(), [ResourceError::NotAllowed { .. }]), "{:?}", mesh.warnings);
    let options = ResourceOptions { folders: vec![workspace.path("outside")], ..ResourceOptions::default() };
    assert!(get(&workspace.store(options), "package://robot/a.dae").unwrap().warnings.is_empty());
}

#[test]
fn files_outside_of_packages_need_an_allowed_folder() {
    let workspace = Workspace::new();
    fs::write(workspace.path("src/robot/meshes/in.stl"), TEXT_STL).unwrap();
    fs::write(workspace.path("outside/out.stl"), TEXT_STL).unwrap();
    assert!(workspace.load(&workspace.url_of("src/robot/meshes/in.stl")).is_ok());
    let url = workspace.url_of("outside/out.stl");
    let error = workspace.load(&url).unwrap_err();
    assert!(matches!(error, ResourceError::NotAllowed { .. }), "{error}");
    assert!(error.to_string().contains("~mesh_folder ") && error.to_string().contains("--mesh-folder"), "{error}");
    // Neither dots nor links lead out of what is allowed.
    let around = workspace.url_of("src/robot/../../outside/out.stl");
    assert!(matches!(workspace.load(&around), Err(ResourceError::NotAllowed { .. })));
    symlink(workspace.path("outside"), workspace.path("src/robot/link")).unwrap();
    let link = "package://robot/link/out.stl";
    assert!(matches!(workspace.load(link), Err(ResourceError::NotAllowed { .. })));
    // Allowed by its name or by another name of the same folder.
    for folder in ["outside", "src/robot/link"] {
        let options = ResourceOptions { folders: vec![workspace.path(folder)], ..ResourceOptions::default() };
        let store = workspace.store(options);
        assert!(get(&store, &url).is_ok() && get(&store, link).is_ok(), "{folder}");
    }
    let etc = "file:///etc/passwd";
    assert!(workspace.load(etc).is_err());
    symlink("/etc/passwd", workspace.path("src/robot/passwd.stl")).unwrap();
    assert!(matches!(workspace.load("package://robot/passwd.stl"), Err(ResourceError::NotAllowed { .. })));
}

#[test]
fn links_from_an_installed_package_to_its_source_work() {
    let workspace = Workspace::new();
    fs::write(workspace.path("src/robot/meshes/arm.stl"), TEXT_STL).unwrap();
    // Each file is a link (colcon's --symlink-install), or the package is.
    fs::create_dir_all(workspace.path("install/share/robot/meshes")).unwrap();
    for file in ["package.xml", "meshes/arm.stl"] {
        let link = workspace.path("install/share/robot").join(file);
        symlink(workspace.path("src/robot").join(file), link).unwrap();
    }
    fs::create_dir_all(workspace.path("devel/share")).unwrap();
    symlink(workspace.path("src/robot"), workspace.path("devel/share/robot")).unwrap();
    for space in ["install/share", "devel/share"] {
        let store = MeshStore::new(PackageIndex::new([workspace.path(space)]));
        assert!(get(&store, "package://robot/meshes/arm.stl").is_ok(), "{space}");
    }
}

#[test]
fn links_of_a_package_may_lead_to_other_folders_of_its_repository() {
    let workspace = Workspace::new();
    fs::write(workspace.path("outside/out.stl"), TEXT_STL).unwrap();
    symlink("../../outside", workspace.path("src/robot/cad")).unwrap();
    let load = |url: &str| workspace.load(url);
    assert!(load("package://robot/cad/out.stl").is_err(), "of no repository");
    fs::create_dir(workspace.path(".git")).unwrap();
    assert!(load("package://robot/cad/out.stl").is_ok());
    assert!(load(&workspace.url_of("src/robot/cad/out.stl")).is_ok());
    // Only by way of the package, and not further.
    fs::write(workspace.path("secret.stl"), TEXT_STL).unwrap();
    for path in ["outside/out.stl", "src/robot/cad/../secret.stl", "src/robot/../../secret.stl"] {
        let error = load(&workspace.url_of(path)).unwrap_err();
        assert!(matches!(error, ResourceError::NotAllowed { .. }), "{path}: {error}");
    }
    let beyond = tempfile::tempdir().unwrap();
    fs::write(beyond.path().join("a.stl"), TEXT_STL).unwrap();
    symlink(beyond.path(), workspace.path("src/robot/beyond")).unwrap();
    assert!(matches!(load("package://robot/beyond/a.stl"), Err(ResourceError::NotAllowed { .. })));
}

#[test]
fn nothing_is_downloaded() {
    for url in ["http://localhost:1/a.stl", "https://localhost/a.stl", "ftp://localhost/a.stl"] {
        let error = Workspace::new().load(url).unwrap_err();
        assert!(matches!(error, ResourceError::UnsupportedScheme { .. }), "{error}");
        assert!(error.to_string().contains("nothing is downloaded"), "{error}");
    }
}

#[test]
fn larger_files_than_the_limit_are_refused_unread() {
    let workspace = Workspace::new();
    // It takes no room on the disk, but a terabyte of memory.
    let huge = workspace.path("src/robot/huge.stl");
    File::create(&huge).unwrap().set_len(1 << 40).unwrap();
    let error = workspace.load("package://robot/huge.stl").unwrap_err();
    assert!(matches!(error, ResourceError::TooLarge { max_mb: 512, .. }), "{error}");
    assert!(error.to_string().contains("~max_mesh_mb"), "{error}");
    let options = ResourceOptions { max_file_bytes: TEXT_STL.len() as u64, ..ResourceOptions::default() };
    let store = workspace.store(options);
    fs::write(workspace.path("src/robot/fits.stl"), TEXT_STL).unwrap();
    fs::write(workspace.path("src/robot/larger.stl"), format!("{TEXT_STL} ")).unwrap();
    assert!(get(&store, "package://robot/fits.stl").is_ok());
    assert!(matches!(get(&store, "package://robot/larger.stl"), Err(ResourceError::TooLarge { .. })));
}

fn too_large(result: Result<Arc<LoadedMesh>, ResourceError>) -> &'static str {
    match result {
        Err(ResourceError::BadMesh { fault: MeshFault::TooLarge { what, .. }, .. }) => what,
        other => panic!("too large, not {other:?}"),
    }
}

#[test]
fn a_small_file_does_not_expand_to_a_large_mesh() {
    let workspace = Workspace::new();
    // As many corners as an STL file of 6000 bytes.
    let store = workspace.store(ResourceOptions { max_file_bytes: 6_000, ..ResourceOptions::default() });
    let check = |name: &str, text: &str| {
        assert!(text.len() < 6_000, "{name}: {}", text.len());
        fs::write(workspace.path("src/robot").join(name), text).unwrap();
        too_large(get(&store, &format!("package://robot/{name}")))
    };
    let instances = "<instance_node url=\"#lib\"/>".repeat(60);
    let dae = DAE.replace("<node id=\"n\">", &format!("<node id=\"m\">{instances}</node><node id=\"n\">"));
    assert_eq!(check("instances.dae", &dae), "corners");
    let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", format!("f{}\n", " 1 2 3".repeat(20)).repeat(40));
    assert_eq!(check("corners.obj", &obj), "corners");

    // Nodes that double, each with a mesh: few bytes and corners, many things to draw.
    let mut nodes = String::new();
    for i in 0..16 {
        let next = format!("<instance_node url=\"#d{}\"/>", i + 1);
        nodes += &format!("<node id=\"d{i}\">{next}{next}</node>");
    }
    nodes += "<node id=\"d16\"><instance_geometry url=\"#geo\"/></node>";
    let dae = DAE.replace("<library_nodes>", &format!("<library_nodes>{nodes}"));
    let dae = dae.replace("<node id=\"n\">", "<node id=\"n\"><instance_node url=\"#d0\"/>");
    fs::write(workspace.path("src/robot/double.dae"), dae).unwrap();
    assert_eq!(too_large(workspace.load("package://robot/double.dae")), "meshes");

    let groups: String = (0..60_000).map(|i| format!("g {i}\n")).collect();
    fs::write(workspace.path("src/robot/groups.obj"), groups).unwrap();
    assert_eq!(too_large(workspace.load("package://robot/groups.obj")), "meshes");
    let materials: String = (0..11_000).map(|i| format!("usemtl {i}\n")).collect();
    fs::write(workspace.path("src/robot/materials.obj"), materials).unwrap();
    assert_eq!(too_large(workspace.load("package://robot/materials.obj")), "materials");
}

#[test]
fn deep_nesting_and_many_elements_are_refused() {
    let workspace = Workspace::new();
    for (name, text) in [
        ("deep.dae", format!("<COLLADA>{}{}</COLLADA>", "<a>".repeat(300_000), "</a>".repeat(300_000))),
        ("many.dae", format!("<COLLADA>{}</COLLADA>", "<a/>".repeat(4_100_000))),
    ] {
        fs::write(workspace.path("src/robot").join(name), text).unwrap();
        let error = workspace.load(&format!("package://robot/{name}")).unwrap_err();
        assert!(matches!(error, ResourceError::BadMesh { .. }), "{name}: {error}");
    }
}

/// A PNG file that announces a size.
fn png(width: u32, height: u32) -> Vec<u8> {
    let chunk = |name: &[u8; 4], data: &[u8]| {
        let crc = name.iter().chain(data).fold(!0_u32, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 })
        });
        let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
        chunk.extend(name);
        chunk.extend(data);
        chunk.extend((!crc).to_be_bytes());
        chunk
    };
    let header = [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 6, 0, 0, 0]].concat();
    [b"\x89PNG\r\n\x1a\n".to_vec(), chunk(b"IHDR", &header), chunk(b"IDAT", &[]), chunk(b"IEND", &[])].concat()
}

#[test]
fn images_of_absurd_sizes_are_refused() {
    let workspace = Workspace::new();
    let store = workspace.store(ResourceOptions::default());
    for (name, width, height, reason) in
        [("wide.png", 1 << 30, 1, "not a readable image"), ("large.png", 16_000, 16_000, "pixels are too many")]
    {
        fs::write(workspace.path("src/robot").join(name), png(width, height)).unwrap();
        let Poll::Ready(Err(error)) = store.texture(&format!("package://robot/{name}"), Retry::Yes) else {
            panic!("{name} is an error")
        };
        assert!(matches!(error, ResourceError::BadImage { .. }) && error.to_string().contains(reason), "{error}");
    }
}
