//! The pages that are open, as the program sees them: their number, their images, and what is new for them.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_process::lock;
use tokio::sync::watch;

use crate::images::Images;
use crate::operator::Operator;

/// Longest time for which pages share one text of the state.
const STATE_AGE: Duration = Duration::from_millis(200);

/// The pages that are open. Clones share them.
#[derive(Clone)]
pub struct Pages(Arc<SharedPages>);

struct SharedPages {
    images: Images,
    news: watch::Sender<()>,
    open: AtomicUsize,
    /// Counts changes of the state.
    version: AtomicU64,
    state: Mutex<Option<PagesState>>,
}

/// The last text of the state.
struct PagesState {
    version: u64,
    made: Instant,
    text: Arc<str>,
}

impl Pages {
    /// Without a page.
    #[expect(clippy::new_without_default, reason = "a default would hide that clones share it")]
    pub fn new() -> Self {
        let news = watch::Sender::new(());
        let images = Images::new(news.clone());
        let (open, version) = (AtomicUsize::new(0), AtomicU64::new(0));
        Self(Arc::new(SharedPages { images, news, open, version, state: Mutex::default() }))
    }

    /// The images for the pages.
    pub fn images(&self) -> &Images {
        &self.0.images
    }

    /// Returns `true` if a page is open.
    pub fn is_any_open(&self) -> bool {
        self.0.open.load(Ordering::Acquire) > 0
    }

    /// Sends the state to all pages soon: it has changed.
    pub fn state_changed(&self) {
        self.0.version.fetch_add(1, Ordering::AcqRel);
        self.0.news.send_replace(());
    }

    /// Sends new lines of the log to all pages soon.
    pub fn log_changed(&self) {
        self.0.news.send_replace(());
    }

    /// Wakes the pages' tasks when something is new.
    pub(crate) fn subscribe(&self) -> watch::Receiver<()> {
        self.0.news.subscribe()
    }

    pub(crate) fn state_version(&self) -> u64 {
        self.0.version.load(Ordering::Acquire)
    }

    /// The state with its version, composed once for all pages.
    pub(crate) fn state(&self, operator: &dyn Operator) -> (u64, Arc<str>) {
        let mut last = lock(&self.0.state);
        let version = self.state_version();
        if let Some(known) = last.as_ref().filter(|known| known.version == version && known.made.elapsed() < STATE_AGE)
        {
            return (version, Arc::clone(&known.text));
        }
        let text: Arc<str> = operator.state().into();
        *last = Some(PagesState { version, made: Instant::now(), text: Arc::clone(&text) });
        (version, text)
    }

    /// Counts a page as open until the result is dropped.
    pub(crate) fn open(&self) -> OpenPage {
        self.0.open.fetch_add(1, Ordering::AcqRel);
        OpenPage { pages: self.clone(), id: self.0.images.join() }
    }
}

/// A page that is open.
pub(crate) struct OpenPage {
    pages: Pages,
    /// Identifies it among the [`Images`].
    pub(crate) id: u64,
}

impl Drop for OpenPage {
    fn drop(&mut self) {
        self.pages.images().leave(self.id);
        self.pages.0.open.fetch_sub(1, Ordering::AcqRel);
    }
}
