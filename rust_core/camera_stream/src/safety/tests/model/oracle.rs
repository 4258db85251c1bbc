//! When light is allowed, as the rules say it: nothing of the program is used here. Times are milliseconds.

/// Age limit of all data, and the longest grant.
const LIMIT: i64 = 1000;

#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) is_valid: bool,
    /// `None` without a stamp.
    pub(super) stamp: Option<i64>,
    pub(super) at: i64,
}

impl Seen {
    /// A tracker without any mask yet.
    pub(super) const NONE: Self = Self { is_valid: false, stamp: None, at: 0 };
}

#[derive(Clone, Debug, Default)]
pub(super) struct Oracle {
    pub(super) now: i64,
    /// ROS time is `now + ahead`.
    pub(super) ahead: i64,
    pub(super) resumed: Option<i64>,
    pub(super) is_all_black: bool,
    pub(super) is_camera_black: bool,
    pub(super) has_camera: bool,
    /// The last mask of each of the trackers that publish.
    pub(super) masks: [Option<Seen>; 2],
    /// The newest transform of the head.
    pub(super) head: Option<Seen>,
    pub(super) path: Option<Seen>,
    /// Counts what the operator and the config have said.
    pub(super) words: u32,
}

impl Oracle {
    /// No measurement counts any more; the trackers are still there.
    pub(super) fn forget(&mut self) {
        self.masks.iter_mut().flatten().for_each(|mask| *mask = Seen::NONE);
        (self.head, self.path) = (None, None);
    }

    /// The end of the light if nothing new comes; `None` for dark. A test image shows no data.
    pub(super) fn allowed_until(&self, is_test: bool) -> Option<i64> {
        if self.is_all_black || self.is_camera_black || !self.has_camera || self.masks.iter().all(Option::is_none) {
            return None;
        }
        let mut ends = vec![self.now + LIMIT];
        for mask in self.masks.iter().flatten() {
            ends.push(self.measured_until(mask)?);
        }
        ends.push(self.measured_until(&self.head?)?);
        if let Some(path) = self.path.filter(|_| !is_test) {
            ends.push(self.end(&path)?);
        }
        ends.into_iter().min()
    }

    /// The end of a measurement, which is unknown if it comes from the future or may have waited while all stood still.
    fn measured_until(&self, seen: &Seen) -> Option<i64> {
        let is_ahead = seen.stamp.is_some_and(|stamp| stamp > self.now + self.ahead + LIMIT);
        let has_waited = seen.stamp.is_none() && self.resumed.is_some_and(|resumed| seen.at < resumed + LIMIT);
        if is_ahead || has_waited || !seen.is_valid {
            return None;
        }
        self.end(seen).filter(|end| *end > self.now)
    }

    /// The end of data by their arrival and their stamp.
    fn end(&self, seen: &Seen) -> Option<i64> {
        let by_stamp = seen.stamp.map_or(i64::MAX, |stamp| stamp - self.ahead + LIMIT);
        Some(by_stamp.min(seen.at + LIMIT)).filter(|end| *end >= self.now)
    }
}
