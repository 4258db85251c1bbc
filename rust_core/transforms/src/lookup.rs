//! Lookups of the pose of one frame in another, and their errors.
//!
//! A lookup follows parents from the source frame towards the root, then from the target frame up to the first chain's
//! end, and joins the two. A link whose history does not cover the time ends the first chain; that is an error only if
//! the target is not below it, so a frame that stopped being published does not hide what hangs under it. Time zero is
//! first resolved to the latest common time: the oldest among the newest stamps of the moving frames between the two.
//! All of this is tf2's, except that a leading `/` is ignored in lookups too, and that a lookup between two empty names
//! is an error.
//!
//! No successful lookup allocates.

use std::fmt;

use nalgebra::Isometry3;
use thiserror::Error;

use crate::history::History;
use crate::sample::FrameId;
use crate::transform::strip_slash;
use crate::{Prediction, Time, TransformTree};

/// Frames further than this from their root are taken for a loop; tf2's value.
const MAX_DEPTH: usize = 1000;

/// Failed lookup of the transform from `source` to `target`.
#[derive(Clone, PartialEq, Debug)]
pub struct LookupError {
    /// The frame to transform to.
    pub target: String,
    /// The frame to transform from.
    pub source: String,
    /// Reason.
    pub problem: LookupProblem,
}

/// Reason why a lookup fails.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum LookupProblem {
    /// No transform ever mentioned this frame; tf2's `LookupException`.
    #[error("frame [{0}] does not exist")]
    MissingFrame(String),
    /// The parents of this frame form a circle.
    #[error("the parents of frame [{0}] form a loop")]
    Loop(String),
    /// No chain of parents connects the frames; tf2's `ConnectivityException`.
    #[error("they are in unconnected trees, whose roots are [{source_root}] and [{target_root}]")]
    Unconnected {
        /// The root above the target; the target itself if it has no parent.
        target_root: String,
        /// The root above the source; the source itself if it has no parent.
        source_root: String,
    },
    /// The frames are connected, or might be, but not at the requested time; tf2's `ExtrapolationException`.
    #[error("{}", extrapolation(.frame, *.requested, *.known))]
    Extrapolation {
        /// The frame between the two whose pose in its parent is not known at that time.
        frame: String,
        /// The requested time.
        requested: Time,
        /// The earliest and latest time at which `frame` is known; `None` if it is not known at all (any more).
        known: Option<(Time, Time)>,
    },
    /// A frame name is empty; tf2's `InvalidArgumentException`.
    #[error("a frame name is empty")]
    EmptyName,
}

impl std::error::Error for LookupError {}

impl fmt::Display for LookupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no transform from frame [{}] to frame [{}]", self.source, self.target)?;
        if let LookupProblem::Extrapolation { requested, .. } = &self.problem {
            write!(f, " at {requested}")?;
        }
        write!(f, ": {}", self.problem)
    }
}

fn extrapolation(frame: &str, requested: Time, known: Option<(Time, Time)>) -> String {
    match known {
        None => format!("nothing is known of frame [{frame}]"),
        Some((only, latest)) if only == latest => format!("frame [{frame}] is known at {only} only"),
        Some((earliest, _)) if requested < earliest => {
            format!("frame [{frame}] is known from {earliest} on, {:.9} s later", earliest.secs_since(requested))
        }
        Some((_, latest)) => {
            format!("frame [{frame}] is known until {latest}, {:.9} s earlier", requested.secs_since(latest))
        }
    }
}

/// Reason why a walk failed, in a form that costs nothing where it is not reported.
#[derive(Clone, Copy, Debug)]
enum WalkFailure {
    Loop(FrameId),
    Unconnected { target_root: FrameId, source_root: FrameId },
    Unknown { frame: FrameId, time: Time },
}

/// End of a chain of newest parents.
#[derive(Clone, Copy)]
enum ChainEnd {
    /// The other frame.
    Other,
    Root {
        root: FrameId,
        links: usize,
    },
}

impl TransformTree {
    /// Pose of `source` in `target` at `time`: takes coordinates in the source frame to the target frame.
    ///
    /// `time` zero means the latest time at which all moving frames between the two are known. A frame in itself is the
    /// identity at any time, whether or not the tree knows it.
    ///
    /// # Errors
    ///
    /// [`LookupError`], which names both frames.
    pub fn lookup(&self, target: &str, source: &str, time: Time) -> Result<Isometry3<f64>, LookupError> {
        let (target_from_source, _) = self.lookup_stamped(target, source, time)?;
        Ok(target_from_source)
    }

    /// Like [`lookup`](Self::lookup), with the time that time zero resolved to: `time` itself if it is not zero, and
    /// zero where everything between the frames is static.
    ///
    /// # Errors
    ///
    /// [`LookupError`], which names both frames.
    pub fn lookup_stamped(
        &self,
        target: &str,
        source: &str,
        time: Time,
    ) -> Result<(Isometry3<f64>, Time), LookupError> {
        let (target, source) = names(target, source)?;
        if target == source {
            let latest = self.frames.id(target).and_then(|id| self.newest_stamp(id));
            let stamp = if time.is_zero() { latest.unwrap_or(Time::ZERO) } else { time };
            return Ok((Isometry3::identity(), stamp));
        }
        let (target_id, source_id) = self.ids(target, source)?;
        self.walk(target_id, source_id, time).map_err(|failure| self.describe(failure, target, source))
    }

    /// Predicted pose of `source` in `target`: takes coordinates in the source frame to the target frame. Links whose
    /// transforms reach the predicted time are interpolated, those that move steadily are extrapolated, and all others
    /// hold their newest transform.
    ///
    /// # Errors
    ///
    /// [`LookupError`], in the same cases as [`lookup`](Self::lookup) at time zero.
    pub fn predict(&self, target: &str, source: &str, prediction: &Prediction) -> Result<Isometry3<f64>, LookupError> {
        let (target, source) = names(target, source)?;
        if target == source {
            return Ok(Isometry3::identity());
        }
        let (target_id, source_id) = self.ids(target, source)?;
        // Frames that cannot be looked up, such as through one that fell silent long ago, are not predicted either.
        let known = self.walk(target_id, source_id, Time::ZERO);
        let by_motion = |history: &History| history.predicted(prediction);
        let found = known.and_then(|_| self.walk_by(target_id, source_id, prediction.time(), by_motion));
        let (target_from_source, _) = found.map_err(|failure| self.describe(failure, target, source))?;
        Ok(target_from_source)
    }

    /// `true` if [`lookup`](Self::lookup) would succeed. Cheap either way.
    pub fn can_transform(&self, target: &str, source: &str, time: Time) -> bool {
        let (target, source) = (strip_slash(target), strip_slash(source));
        if target.is_empty() || source.is_empty() {
            return false;
        }
        match (self.frames.id(target), self.frames.id(source)) {
            (Some(target_id), Some(source_id)) => self.walk(target_id, source_id, time).is_ok(),
            _ => target == source,
        }
    }

    /// Time that zero means for these two frames: the oldest among the newest stamps of the moving frames between them.
    /// Zero where all of them are static; of a frame and itself, its newest stamp.
    ///
    /// # Errors
    ///
    /// [`LookupError`], which names both frames.
    pub fn latest_common_time(&self, a: &str, b: &str) -> Result<Time, LookupError> {
        let (a, b) = names(a, b)?;
        let (a_id, b_id) = self.ids(a, b)?;
        self.common_time(a_id, b_id).map_err(|failure| self.describe(failure, a, b))
    }

    fn ids(&self, target: &str, source: &str) -> Result<(FrameId, FrameId), LookupError> {
        let find = |frame: &str| {
            let missing = || refused(target, source, LookupProblem::MissingFrame(frame.to_owned()));
            self.frames.id(frame).ok_or_else(missing)
        };
        Ok((find(target)?, find(source)?))
    }

    /// `target_from_source` at `time` with the time that zero resolved to.
    fn walk(&self, target: FrameId, source: FrameId, time: Time) -> Result<(Isometry3<f64>, Time), WalkFailure> {
        let time = if time.is_zero() { self.common_time(target, source)? } else { time };
        self.walk_by(target, source, time, |history| history.at(time))
    }

    /// `target_from_source` with `place` giving each link's parent and `parent_from_child`; `time` is returned, and
    /// named by failures.
    fn walk_by(
        &self,
        target: FrameId,
        source: FrameId,
        time: Time,
        place: impl Fn(&History) -> Option<(FrameId, Isometry3<f64>)>,
    ) -> Result<(Isometry3<f64>, Time), WalkFailure> {
        let mut top = source;
        let mut top_from_source = Isometry3::identity();
        let mut links = 0;
        let mut broken_at = None;
        while let Some(history) = self.frames.history(top) {
            if top == target {
                break;
            }
            let Some((parent, parent_from_child)) = place(history) else {
                broken_at = Some(top);
                break;
            };
            top_from_source = parent_from_child * top_from_source;
            top = parent;
            links += 1;
            if links > MAX_DEPTH {
                return Err(WalkFailure::Loop(source));
            }
        }

        let mut frame = target;
        let mut frame_from_target = Isometry3::identity();
        links = 0;
        while frame != top {
            if frame == source {
                return Ok((frame_from_target.inverse(), time));
            }
            let Some(history) = self.frames.history(frame) else {
                return Err(match broken_at {
                    Some(frame) => WalkFailure::Unknown { frame, time },
                    None => WalkFailure::Unconnected { target_root: frame, source_root: top },
                });
            };
            let Some((parent, parent_from_child)) = place(history) else {
                return Err(WalkFailure::Unknown { frame, time });
            };
            frame_from_target = parent_from_child * frame_from_target;
            frame = parent;
            links += 1;
            if links > MAX_DEPTH {
                return Err(WalkFailure::Loop(target));
            }
        }
        let top_from_target = frame_from_target;
        Ok((top_from_target.inverse() * top_from_source, time))
    }

    /// `a` is the target and `b` the source of the lookup.
    fn common_time(&self, a: FrameId, b: FrameId) -> Result<Time, WalkFailure> {
        if a == b {
            return Ok(self.newest_stamp(a).unwrap_or(Time::ZERO));
        }
        // The distances from the root show where the two chains can meet first.
        let (b_root, above_b) = match self.chain_end(b, a)? {
            ChainEnd::Other => return Ok(self.oldest_between(b, a)),
            ChainEnd::Root { root, links } => (root, links),
        };
        let (a_root, above_a) = match self.chain_end(a, b)? {
            ChainEnd::Other => return Ok(self.oldest_between(a, b)),
            ChainEnd::Root { root, links } => (root, links),
        };
        if a_root != b_root {
            return Err(WalkFailure::Unconnected { target_root: a_root, source_root: b_root });
        }
        let (mut a, mut b) = (a, b);
        let mut oldest = None;
        for _ in above_b..above_a {
            a = self.step_up(a, &mut oldest);
        }
        for _ in above_a..above_b {
            b = self.step_up(b, &mut oldest);
        }
        while a != b {
            a = self.step_up(a, &mut oldest);
            b = self.step_up(b, &mut oldest);
        }
        Ok(oldest.unwrap_or(Time::ZERO))
    }

    /// Follows newest parents from `from` to its root, or to `other` if that comes first.
    fn chain_end(&self, from: FrameId, other: FrameId) -> Result<ChainEnd, WalkFailure> {
        let mut frame = from;
        for links in 0..=MAX_DEPTH {
            if frame == other {
                return Ok(ChainEnd::Other);
            }
            match self.frames.history(frame).and_then(History::newest) {
                Some(newest) => frame = newest.parent,
                None => return Ok(ChainEnd::Root { root: frame, links }),
            }
        }
        Err(WalkFailure::Loop(from))
    }

    /// Common time from `from` up to `ancestor`, which is known to be above it.
    fn oldest_between(&self, from: FrameId, ancestor: FrameId) -> Time {
        let (mut frame, mut oldest) = (from, None);
        while frame != ancestor {
            frame = self.step_up(frame, &mut oldest);
        }
        oldest.unwrap_or(Time::ZERO)
    }

    /// The newest parent of `frame`; its stamp joins `oldest`. Stamps of zero bound no common time.
    fn step_up(&self, frame: FrameId, oldest: &mut Option<Time>) -> FrameId {
        let Some(newest) = self.frames.history(frame).and_then(History::newest) else { return frame };
        if !newest.stamp.is_zero() {
            *oldest = Some(oldest.map_or(newest.stamp, |oldest| oldest.min(newest.stamp)));
        }
        newest.parent
    }

    fn newest_stamp(&self, id: FrameId) -> Option<Time> {
        Some(self.frames.history(id)?.newest()?.stamp)
    }

    fn describe(&self, failure: WalkFailure, target: &str, source: &str) -> LookupError {
        let name = |frame| self.frames.name(frame).to_owned();
        let problem = match failure {
            WalkFailure::Loop(frame) => LookupProblem::Loop(name(frame)),
            WalkFailure::Unconnected { target_root, source_root } => {
                LookupProblem::Unconnected { target_root: name(target_root), source_root: name(source_root) }
            }
            WalkFailure::Unknown { frame, time } => LookupProblem::Extrapolation {
                frame: name(frame),
                requested: time,
                known: self.frames.history(frame).and_then(History::span),
            },
        };
        refused(target, source, problem)
    }
}

fn refused(target: &str, source: &str, problem: LookupProblem) -> LookupError {
    LookupError { target: target.to_owned(), source: source.to_owned(), problem }
}

/// Both names without a leading slash, if neither is empty.
fn names<'a>(target: &'a str, source: &'a str) -> Result<(&'a str, &'a str), LookupError> {
    let (target, source) = (strip_slash(target), strip_slash(source));
    if target.is_empty() || source.is_empty() {
        return Err(refused(target, source, LookupProblem::EmptyName));
    }
    Ok((target, source))
}
