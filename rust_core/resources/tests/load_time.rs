//! How long a large mesh takes to load: in a program of its own, so that no other test runs beside it.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::time::{Duration, Instant};

use common::{binary_stl, load_bytes, TRIANGLES};

const MAX_TIME: Duration = Duration::from_millis(800);

/// The fastest counts: a machine's other work only ever adds.
const ATTEMPTS: usize = 5;

#[test]
fn twenty_megabytes_of_stl_load_well_under_a_second() {
    let triangles: Vec<_> = TRIANGLES.iter().copied().cycle().take(400_000).collect();
    let bytes = binary_stl(b"", &triangles);
    let times = [(); ATTEMPTS].map(|()| {
        let begin = Instant::now();
        let mesh = load_bytes("big.stl", &bytes).unwrap();
        let took = begin.elapsed();
        assert_eq!(mesh.parts[0].mesh.indices.len(), 1_200_000);
        took
    });
    println!("loaded in {times:.0?}");
    assert!(*times.iter().min().unwrap() < MAX_TIME, "{times:?}");
}
