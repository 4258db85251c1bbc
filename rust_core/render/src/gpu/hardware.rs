//! Looks for a GPU without loading any graphics driver.
//!
//! Vulkan's and GL's loaders map every driver that is installed before they say which hardware it found. On a machine
//! without a GPU those are Mesa's software drivers, which take 50 MB and dozens of threads and stay. But a GPU that
//! programs can use has a device file, so no driver needs to be asked where there is none.

use std::path::Path;

/// The beginnings of device files below `/dev`: of NVIDIA's own driver on computers and on Tegra, of Arm's, Qualcomm's,
/// Imagination's and Vivante's, and of the host's GPU under WSL. Those of the kernel's own drivers are in `dri`.
const DEVICES: [&str; 9] = ["nvidia", "nvhost-gpu", "nvgpu", "nvmap", "mali", "kgsl", "pvr", "galcore", "dxg"];
/// The kernel's own drivers give the devices that render such names; those without, such as a server's screen
/// controller, only show.
const RENDER_NODE: &str = "renderD";

/// True if there is a device file of a GPU. On other systems than Linux and Android that is unknown, so: true.
pub(super) fn may_have_gpu() -> bool {
    cfg!(not(any(target_os = "linux", target_os = "android"))) || has_device(Path::new("/dev"))
}

fn has_device(dev: &Path) -> bool {
    has_name(dev, &DEVICES) || has_name(&dev.join("dri"), &[RENDER_NODE])
}

/// True if a folder has a file with one of these beginnings.
fn has_name(folder: &Path, beginnings: &[&str]) -> bool {
    // A folder that does not exist has none.
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.into_iter().any(|name| beginnings.iter().any(|beginning| name.to_string_lossy().starts_with(beginning)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn device_files_of_gpus_are_found() {
        let dev = std::env::temp_dir().join(format!("rcs_render_dev_{}", std::process::id()));
        let names = ["dri/renderD128", "nvidia0", "nvhost-gpu", "mali0", "kgsl-3d0", "pvr_sync", "galcore", "dxg"];
        for name in names {
            let file = dev.join(name);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            for other in ["null", "fb0", "video0"] {
                std::fs::write(dev.join(other), []).unwrap();
            }
            std::fs::create_dir_all(dev.join("dri")).unwrap();
            std::fs::write(dev.join("dri/card0"), []).unwrap();
            assert!(!has_device(&dev), "{name}");
            std::fs::write(&file, []).unwrap();
            assert!(has_device(&dev), "{name}");
            std::fs::remove_dir_all(&dev).unwrap();
        }
        assert!(!has_device(&dev), "without any device");
    }
}
