//! What all benchmarks share.

use std::time::Duration;

use criterion::Criterion;

/// Short measurements: differences of a tenth can be seen, those of a hundredth cannot.
pub(crate) fn quick() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .nresamples(2000)
        .warm_up_time(Duration::from_millis(150))
        .measurement_time(Duration::from_millis(400))
}
