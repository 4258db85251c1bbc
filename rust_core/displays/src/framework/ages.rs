//! Basis of a display's age: the newest message that it shows, and the frames that it follows.
//!
//! No clock is read here: who draws decides how old is too old.

use rcs_scene::DisplayId;

use crate::framework::lookups::FollowedFrames;
use crate::{ShownMessage, TopicRequest};

/// The data of a display.
#[derive(Clone, Debug)]
pub struct DisplayAge<'a> {
    /// Its number.
    pub id: DisplayId,
    /// The names of the groups around it and its own.
    pub path: &'a [String],
    /// What it subscribes to, by the names in the config.
    pub topics: Vec<TopicRequest>,
    /// The newest message that what it shows stands for; none before the first, and for a display without topics. A
    /// message that was refused, dropped or still waits for its frame does not count, and one that says the same as
    /// the message before it does. Its stamp is that of the latest transforms that placed it, where those are older.
    pub current: Option<ShownMessage>,
    /// The frames that it follows.
    pub follows: &'a FollowedFrames,
    /// It shows nothing.
    pub is_empty: bool,
}
