//! Reading large files: `files/stl/TRIANGLES`, a binary STL file to a mesh, and `files/points/COUNT`, a calibration's
//! points.csv to samples.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot read measures nothing")]

mod common;

use std::fs;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use nalgebra::{Point2, Point3};
use rcs_calibration::Sample;
use rcs_files::correspondences::{write_points, Correspondences, PointColumns};
use rcs_resources::{MeshStore, PackageIndex, ResourceOptions, Retry};

/// Triangles in a row of squares, each cut in two.
const TRIANGLES: u32 = 400_000;
const POINTS: u32 = 200_000;

fn stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(TRIANGLES.to_le_bytes());
    for i in 0..TRIANGLES {
        let (left, right) = ((i / 2) as f32, (i / 2 + 1) as f32);
        let corners = [[left, 0.0], [right, 1.0], if i % 2 == 0 { [left, 1.0] } else { [right, 0.0] }];
        let numbers = [0.0, 0.0, 1.0].into_iter().chain(corners.into_iter().flat_map(|[x, y]| [x, y, 0.0]));
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

fn read(c: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, points) = (folder.path().join("mesh.stl"), folder.path().join("points.csv"));
    fs::write(&mesh, stl()).unwrap();
    let sample = |i: u32| Sample::new(Point2::new(f64::from(i) * 0.0064, 2.0), Point3::new(0.25, -0.5, 1.0));
    write_points(&points, &(0..POINTS).map(sample).collect::<Vec<_>>(), PointColumns::WithSigmas).unwrap();
    let mut group = c.benchmark_group("files");
    group.throughput(Throughput::Elements(TRIANGLES.into()));
    group.bench_function(BenchmarkId::new("stl", TRIANGLES), |b| {
        b.iter(|| {
            let options = ResourceOptions { folders: vec![folder.path().to_owned()], ..ResourceOptions::default() };
            let store = MeshStore::with_options(PackageIndex::new([]), options);
            assert!(store.mesh(mesh.to_str().unwrap(), Retry::Yes).is_ready());
        });
    });
    group.throughput(Throughput::Elements(POINTS.into()));
    group.bench_function(BenchmarkId::new("points", POINTS), |b| {
        b.iter(|| Correspondences::read(&[&points]).unwrap().samples.len());
    });
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = read }
criterion_main!(benches);
