//! Memory of loading a large mesh, in a program of its own, so that no other test's memory is counted.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::{fs, io::Write};

use common::load;

/// Three million of them may take about half a gigabyte.
const TRIANGLES: u32 = 1_000_000;
/// Of which the file is 50, and the mesh that is left 120.
const MAX_PEAK_BYTES: u64 = 220;

/// The most memory that this process ever had.
fn peak_bytes() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

#[test]
fn a_large_mesh_is_read_into_its_final_form() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("big.stl");
    let mut file = std::io::BufWriter::new(fs::File::create(&path).unwrap());
    file.write_all(&[b' '; 80]).unwrap();
    file.write_all(&TRIANGLES.to_le_bytes()).unwrap();
    for i in 0..TRIANGLES {
        // No two corners are the same, which takes the most memory.
        let x = i as f32;
        for value in [0.0, 0.0, 1.0, x, 0.0, 0.0, x, 1.0, 0.0, x + 0.5, 0.0, 1.0] {
            file.write_all(&f32::to_le_bytes(value)).unwrap();
        }
        file.write_all(&[0, 0]).unwrap();
    }
    file.flush().unwrap();
    let before = peak_bytes();
    let mesh = load(&path).unwrap();
    assert_eq!(mesh.parts[0].mesh.vertices.len(), 3 * TRIANGLES as usize);
    let peak = (peak_bytes() - before) / u64::from(TRIANGLES);
    println!("{peak} bytes for a triangle at the peak");
    assert!(peak < MAX_PEAK_BYTES, "{peak}");
}
