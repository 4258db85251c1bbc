//! What the node's two threads share.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rcs_ros::{RosNode, TriggerReply};
use rcs_rviz_config::Config;

use crate::camera_stream::camera::output::CameraOutput;
use crate::camera_stream::runtime::activity::Activity;
use crate::camera_stream::runtime::diagnostics::Diagnostics;
use crate::camera_stream::runtime::watchdog;

/// Shared by the scene's thread and the control thread. No lock is held for long: not while messages are taken,
/// displays are updated or pictures are drawn.
pub(crate) struct Shared {
    pub(crate) ros: Arc<RosNode>,
    /// What the scene's thread is doing.
    pub(crate) activity: Arc<Activity>,
    cameras: Mutex<Vec<CameraOutput>>,
    diagnostics: Mutex<Diagnostics>,
    /// A config that the scene's thread is to apply.
    reload: Mutex<Option<Reload>>,
    /// Meshes and textures that could not be used are to be looked at again.
    retry: AtomicBool,
    end: AtomicBool,
}

/// Another config, which was read without an error.
pub(crate) struct Reload {
    pub(crate) config: Config,
    /// Answers who asked for it; `None` if the file changed, or if the answer could not wait.
    pub(crate) reply: Option<TriggerReply>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Without cameras.
    pub(crate) fn new(ros: Arc<RosNode>) -> Self {
        let diagnostics = Mutex::new(Diagnostics::start(&ros));
        let (activity, cameras, reload) = (Arc::<Activity>::default(), Mutex::default(), Mutex::default());
        watchdog::watch(&activity);
        Self { ros, activity, cameras, diagnostics, reload, retry: AtomicBool::new(false), end: AtomicBool::new(false) }
    }

    /// The cameras, in the config's order. Only the scene's thread adds and removes some.
    pub(crate) fn cameras(&self) -> MutexGuard<'_, Vec<CameraOutput>> {
        lock(&self.cameras)
    }

    /// The statuses' log and topic.
    pub(crate) fn diagnostics(&self) -> MutexGuard<'_, Diagnostics> {
        lock(&self.diagnostics)
    }

    /// The place of the next config.
    pub(crate) fn reload(&self) -> MutexGuard<'_, Option<Reload>> {
        lock(&self.reload)
    }

    /// Has the scene's thread look again at meshes and textures that could not be used.
    pub(crate) fn retry_resources(&self) {
        self.retry.store(true, Ordering::Release);
    }

    /// Whether it is to do so; once for each request.
    pub(crate) fn take_retry(&self) -> bool {
        self.retry.swap(false, Ordering::AcqRel)
    }

    /// Asks the scene's thread to end.
    pub(crate) fn end(&self) {
        self.end.store(true, Ordering::Release);
        self.ros.events().wake();
    }

    /// Whether the scene's thread is to end.
    pub(crate) fn is_ending(&self) -> bool {
        self.end.load(Ordering::Acquire)
    }
}
