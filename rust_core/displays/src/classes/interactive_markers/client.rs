//! The client of all interactive marker servers that share a topic.
//!
//! Each server has an id in its messages. rviz's client subscribes to the topic of all markers only while it waits for
//! a server's first list; that topic is latched, so whenever it subscribes again it gets each server's last message.
//! Here that message is kept.

use std::collections::BTreeMap;
use std::sync::Arc;

use rcs_messages::visualization_msgs::{InteractiveMarkerInit, InteractiveMarkerUpdate};
use rcs_transforms::Time;

use super::server::{MarkerChange, Server};
use crate::{Level, Statuses, World};

/// rviz's name for the status of the connection as a whole.
const GENERAL: &str = "General";

#[derive(Debug)]
pub(super) struct Client {
    translucent: bool,
    servers: BTreeMap<String, Server>,
    /// The last list of all markers of each server.
    inits: BTreeMap<String, Arc<InteractiveMarkerInit>>,
    is_stopped: bool,
    now: Time,
}

impl Client {
    pub(super) fn new(translucent: bool, statuses: &mut Statuses) -> Self {
        statuses.set(Level::Ok, GENERAL, "Waiting for messages.");
        Self { translucent, servers: BTreeMap::new(), inits: BTreeMap::new(), is_stopped: false, now: Time::ZERO }
    }

    pub(super) fn take_init(&mut self, init: &Arc<InteractiveMarkerInit>, statuses: &mut Statuses) {
        if !init.server_id.is_empty() {
            self.inits.insert(init.server_id.clone(), init.clone());
        }
        if let Some(server) = self.server(&init.server_id, statuses) {
            server.take_init(init, statuses);
        }
    }

    pub(super) fn take_update(&mut self, update: &InteractiveMarkerUpdate, now: Time, statuses: &mut Statuses) {
        if let Some(server) = self.server(&update.server_id, statuses) {
            server.take_update(update, now, statuses);
        }
    }

    fn server(&mut self, id: &str, statuses: &mut Statuses) -> Option<&mut Server> {
        if self.is_stopped {
            return None;
        }
        if id.is_empty() {
            statuses.set(Level::Error, GENERAL, "Received message with empty server_id!");
            return None;
        }
        statuses.set(Level::Ok, GENERAL, "Receiving messages.");
        let translucent = self.translucent;
        Some(self.servers.entry(id.to_owned()).or_insert_with(|| Server::new(id, translucent, statuses)))
    }

    /// Processes the messages whose frames are known. Returns the changes for the display, by server.
    pub(super) fn update(&mut self, world: &World<'_>, statuses: &mut Statuses) -> Vec<(String, MarkerChange)> {
        self.now = world.now;
        let mut steps = Vec::new();
        for (id, server) in &mut self.servers {
            if server.update(world, statuses) {
                if let Some(init) = self.inits.get(id) {
                    server.take_init(init, statuses);
                }
            }
            steps.extend(server.take_changes().into_iter().map(|step| (id.clone(), step)));
        }
        steps
    }

    /// Time of the next change without a message.
    pub(super) fn next_change(&self) -> Option<Time> {
        self.servers.values().filter_map(|server| server.next_change(self.now)).min()
    }

    pub(super) fn is_waiting(&self) -> bool {
        self.servers.values().any(Server::is_waiting)
    }

    /// Removes all servers and ignores messages from now on.
    pub(super) fn stop(&mut self) {
        self.servers.clear();
        self.is_stopped = true;
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// Starts again, as if it had just subscribed.
    pub(super) fn restart(&mut self, statuses: &mut Statuses) {
        self.servers.clear();
        self.is_stopped = false;
        statuses.set(Level::Ok, GENERAL, "Waiting for messages.");
        for init in self.inits.values() {
            let mut server = Server::new(&init.server_id, self.translucent, statuses);
            server.take_init(init, statuses);
            self.servers.insert(init.server_id.clone(), server);
        }
    }
}
