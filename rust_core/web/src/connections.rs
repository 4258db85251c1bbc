//! The slots of connections: one half is for those that have shown the token, the other for those that have not.
//!
//! Whoever may connect can also hold connections and send nothing. Without the token, an address may have half of the
//! second half. A newcomer always gets in: it takes the place of the oldest connection without the token, of its own
//! address if that has too many. So everybody gets to show the token, and a flood displaces the flood.

use std::collections::VecDeque;
use std::future::Future;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, OnceLock};

use rcs_process::lock;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::AbortHandle;

/// The slots of all connections.
pub(crate) struct Connections {
    strangers: Mutex<Strangers>,
    most_strangers: usize,
    /// The slots of connections with the token.
    admitted: Arc<Semaphore>,
}

/// The connections that have not shown the token, oldest first.
#[derive(Default)]
struct Strangers {
    all: VecDeque<Stranger>,
    last_id: u64,
}

struct Stranger {
    id: u64,
    peer: IpAddr,
    task: AbortHandle,
}

/// A connection's slot, until it is dropped; an extension of its request.
pub(crate) struct Slot {
    connections: Arc<Connections>,
    id: u64,
    permit: OnceLock<OwnedSemaphorePermit>,
}

impl Connections {
    /// The slots of this many connections.
    pub(crate) fn new(most: usize) -> Arc<Self> {
        let half = most / 2;
        Arc::new(Self { strangers: Mutex::default(), most_strangers: half, admitted: Arc::new(Semaphore::new(half)) })
    }

    /// Serves a new connection as a task, in place of the oldest one if there are too many.
    pub(crate) fn serve<F>(self: &Arc<Self>, peer: IpAddr, serve: impl FnOnce(Arc<Slot>) -> F)
    where
        F: Future<Output = ()> + Send + 'static,
    {
        let mut strangers = lock(&self.strangers);
        strangers.last_id += 1;
        let id = strangers.last_id;
        let of_peer = strangers.all.iter().filter(|stranger| stranger.peer == peer).count();
        let displaced = if of_peer >= self.most_strangers.div_ceil(2) {
            strangers.all.iter().position(|stranger| stranger.peer == peer)
        } else {
            (strangers.all.len() >= self.most_strangers).then_some(0)
        };
        let displaced = displaced.and_then(|index| strangers.all.remove(index));
        let slot = Arc::new(Slot { connections: Arc::clone(self), id, permit: OnceLock::new() });
        let task = tokio::spawn(serve(slot)).abort_handle();
        strangers.all.push_back(Stranger { id, peer, task });
        drop(strangers);
        if let Some(displaced) = displaced {
            displaced.task.abort();
        }
    }

    fn forget_stranger(&self, id: u64) {
        lock(&self.strangers).all.retain(|stranger| stranger.id != id);
    }
}

impl Slot {
    /// Moves the connection to those with the token. Returns `false` if they have no slot left.
    pub(crate) fn admit(&self) -> bool {
        let permit = Arc::clone(&self.connections.admitted).try_acquire_owned();
        self.connections.forget_stranger(self.id);
        permit.is_ok_and(|permit| self.permit.set(permit).is_ok())
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.connections.forget_stranger(self.id);
    }
}

#[cfg(test)]
mod tests {
    use std::future::pending;
    use std::sync::Weak;

    use super::*;

    /// Serves a connection until it is displaced, which drops its slot.
    fn connect(connections: &Arc<Connections>, last: u8) -> Weak<Slot> {
        let mut opened = Weak::new();
        connections.serve([10, 0, 0, last].into(), |slot| {
            opened = Arc::downgrade(&slot);
            async move {
                let _slot = slot;
                pending::<()>().await;
            }
        });
        opened
    }

    /// Which of these connections are still served.
    async fn served(all: &[Weak<Slot>]) -> Vec<bool> {
        tokio::task::yield_now().await;
        all.iter().map(|slot| slot.strong_count() > 0).collect()
    }

    fn run(test: impl Future<Output = ()>) {
        tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(test);
    }

    #[test]
    fn a_newcomer_displaces_the_oldest_of_its_address_and_then_the_oldest_of_all() {
        run(async {
            let connections = Connections::new(8);
            let mut all = [1, 2, 2, 2].map(|last| connect(&connections, last)).to_vec();
            assert_eq!(served(&all).await, [true, false, true, true], "an address has two of four");
            all.extend([3, 4].map(|last| connect(&connections, last)));
            assert_eq!(served(&all).await, [false, false, true, true, true, true]);
        });
    }

    #[test]
    fn those_with_the_token_stay_and_have_the_other_half() {
        run(async {
            let connections = Connections::new(8);
            let admit = |slot: &Weak<Slot>| slot.upgrade().unwrap().admit();
            let mut all = Vec::new();
            for _ in 0..4 {
                all.push(connect(&connections, 1));
                assert!(admit(&all[all.len() - 1]));
            }
            all.extend([1; 3].map(|last| connect(&connections, last)));
            assert_eq!(served(&all).await, [true, true, true, true, false, true, true]);
            assert!(!admit(&all[6]), "its half is full");
            assert!(lock(&connections.strangers).all.len() == 1 && connections.admitted.available_permits() == 0);
        });
    }
}
