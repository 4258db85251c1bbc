//! The threads that share work (rayon's pool), which each process has once.

/// Names the threads that share work `draw-0`, `draw-1`, …, for `top -H` and debuggers. To be called before there is
/// work to share, later it changes nothing; and after what must come before all threads, because it starts them.
pub fn name_threads() {
    // Fails if they run already.
    let _ = rayon::ThreadPoolBuilder::new().thread_name(|index| format!("draw-{index}")).build_global();
}
