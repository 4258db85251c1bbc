//! Where one frame was in another: the walks through the tree, and their errors.
//!
//! A lookup walks from the source frame towards the root, then from the target frame until it meets the
//! first walk's end, and joins the two. A link whose history does not cover the time ends the first walk;
//! that is an error only if the target is not met below it, so a frame that stopped being published does
//! not hide what hangs under it. Time zero is first resolved to the latest common time: the oldest among
//! the newest stamps of the moving frames between the two. All of this is tf2's, with two differences:
//! a leading `/` is ignored in lookups too, and a lookup between two empty names is an error.
//!
//! No lookup that succeeds allocates.

use std::fmt;

use nalgebra::Isometry3;
use thiserror::Error;

use crate::history::History;
use crate::transform::strip_slash;
use crate::tree::FrameId;
use crate::{Time, TransformTree};

/// Frames further than this from their root are taken for a loop; tf2's value.
const MAX_DEPTH: usize = 1000;

/// Why there is no transform from `source` to `target`.
///
/// The frame called `source` is written `r#source` in the declaration, or thiserror would take it for the
/// error's cause.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum LookupError {
    /// A frame that no transform ever mentioned, or a loop of frames.
    #[error("no transform from frame [{source}] to frame [{target}]: {problem}")]
    Lookup {
        /// The frame to transform to.
        target: String,
        /// The frame to transform from.
        r#source: String,
        /// What is wrong.
        problem: LookupProblem,
    },
    /// Both frames exist, and no chain of parents connects them.
    #[error("no transform from frame [{source}] to frame [{target}]: they are in unconnected trees, whose roots are [{source_root}] and [{target_root}]")]
    Connectivity {
        /// The frame to transform to.
        target: String,
        /// The frame to transform from.
        r#source: String,
        /// The root above `target`; `target` itself if it has no parent.
        target_root: String,
        /// The root above `source`; `source` itself if it has no parent.
        source_root: String,
    },
    /// The frames are connected, or might be, but not at the requested time.
    #[error("no transform from frame [{source}] to frame [{target}] at {requested}: {}", extrapolation(.frame, *.requested, *.known))]
    Extrapolation {
        /// The frame to transform to.
        target: String,
        /// The frame to transform from.
        r#source: String,
        /// The frame on the way whose place in its parent is not known at that time.
        frame: String,
        /// The requested time.
        requested: Time,
        /// The earliest and latest time at which `frame` is known; `None` if it is not known at all (any more).
        known: Option<(Time, Time)>,
    },
    /// A frame name is empty.
    #[error("no transform from frame [{source}] to frame [{target}]: a frame name is empty")]
    InvalidArgument {
        /// The frame to transform to.
        target: String,
        /// The frame to transform from.
        r#source: String,
    },
}

/// What is wrong with the frames of a [`LookupError::Lookup`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum LookupProblem {
    /// No transform ever mentioned this frame.
    MissingFrame(String),
    /// The parents of this frame lead round in a circle.
    Loop(String),
}

impl fmt::Display for LookupProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LookupProblem::MissingFrame(frame) => write!(f, "frame [{frame}] does not exist"),
            LookupProblem::Loop(frame) => write!(f, "the parents of frame [{frame}] form a loop"),
        }
    }
}

fn extrapolation(frame: &str, requested: Time, known: Option<(Time, Time)>) -> String {
    match known {
        None => format!("nothing is known of frame [{frame}]"),
        Some((only, latest)) if only == latest => {
            format!("frame [{frame}] is known at {only} only")
        }
        Some((earliest, _)) if requested < earliest => {
            format!("frame [{frame}] is known from {earliest} on, {:.9} s later", earliest.secs_since(requested))
        }
        Some((_, latest)) => {
            format!("frame [{frame}] is known until {latest}, {:.9} s earlier", requested.secs_since(latest))
        }
    }
}

/// Why a walk failed, in a form that costs nothing where it is not reported.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Failure {
    Loop(FrameId),
    Unconnected { target_root: FrameId, source_root: FrameId },
    Unknown { frame: FrameId, time: Time },
}

/// A frame's way to its root by newest samples.
#[derive(Clone, Copy)]
enum WayUp {
    /// The other frame was met on the way.
    Met,
    Root {
        root: FrameId,
        links: usize,
    },
}

impl TransformTree {
    /// Where `source` was in `target` at `time`: takes coordinates in the source frame to the target frame.
    ///
    /// `time` zero means the latest time at which all moving frames between the two are known. A frame in
    /// itself is the identity at any time, whether or not the tree knows it.
    ///
    /// # Errors
    ///
    /// [`LookupError`], which names both frames.
    pub fn lookup(&self, target: &str, source: &str, time: Time) -> Result<Isometry3<f64>, LookupError> {
        let (target_from_source, _) = self.lookup_stamped(target, source, time)?;
        Ok(target_from_source)
    }

    /// As [`TransformTree::lookup`], with the time that time zero resolved to: `time` itself if it is not
    /// zero, and zero where everything between the frames is static.
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
            let latest = self.id(target).and_then(|id| self.newest_stamp(id));
            let stamp = if time.is_zero() { latest.unwrap_or(Time::ZERO) } else { time };
            return Ok((Isometry3::identity(), stamp));
        }
        let (target_id, source_id) = self.ids(target, source)?;
        self.walk(target_id, source_id, time).map_err(|failure| self.describe(failure, target, source))
    }

    /// Where `source` at `source_time` is in `target` at `target_time`, if `fixed` stood still in between:
    /// tf2's lookup with a time for each frame.
    ///
    /// # Errors
    ///
    /// [`LookupError`]; it names `fixed` and whichever of the two frames could not be connected with it.
    pub fn lookup_fixed(
        &self,
        target: &str,
        target_time: Time,
        source: &str,
        source_time: Time,
        fixed: &str,
    ) -> Result<Isometry3<f64>, LookupError> {
        // All three must exist, even where two are the same.
        for frame in [source, target] {
            let (fixed, frame) = names(fixed, frame)?;
            self.ids(fixed, frame)?;
        }
        let fixed_from_source = self.lookup(fixed, source, source_time)?;
        let target_from_fixed = self.lookup(target, fixed, target_time)?;
        Ok(target_from_fixed * fixed_from_source)
    }

    /// Whether [`TransformTree::lookup`] would succeed. Cheap either way.
    pub fn can_transform(&self, target: &str, source: &str, time: Time) -> bool {
        let (target, source) = (strip_slash(target), strip_slash(source));
        if target.is_empty() || source.is_empty() {
            return false;
        }
        match (self.id(target), self.id(source)) {
            (Some(target_id), Some(source_id)) => self.walk(target_id, source_id, time).is_ok(),
            _ => target == source,
        }
    }

    /// The time that zero means for these two frames: the oldest among the newest stamps of the moving
    /// frames between them. Zero where all of them are static; of a frame and itself, its newest stamp.
    ///
    /// # Errors
    ///
    /// [`LookupError`], which names both frames.
    pub fn latest_common_time(&self, a: &str, b: &str) -> Result<Time, LookupError> {
        let (a, b) = names(a, b)?;
        let (a_id, b_id) = self.ids(a, b)?;
        self.common_time(a_id, b_id).map_err(|failure| self.describe(failure, a, b))
    }

    pub(crate) fn ids(&self, target: &str, source: &str) -> Result<(FrameId, FrameId), LookupError> {
        let find = |frame: &str| {
            self.id(frame).ok_or_else(|| LookupError::Lookup {
                target: target.to_owned(),
                source: source.to_owned(),
                problem: LookupProblem::MissingFrame(frame.to_owned()),
            })
        };
        Ok((find(target)?, find(source)?))
    }

    /// `target_from_source` at `time` with the time that zero resolved to.
    pub(crate) fn walk(&self, target: FrameId, source: FrameId, time: Time) -> Result<(Isometry3<f64>, Time), Failure> {
        let time = if time.is_zero() { self.common_time(target, source)? } else { time };
        self.walk_by(target, source, time, |history| history.at(time))
    }

    /// `target_from_source` by what `place` says of each link, its parent and `parent_from_child`; `time` is returned,
    /// and named by failures.
    pub(crate) fn walk_by(
        &self,
        target: FrameId,
        source: FrameId,
        time: Time,
        place: impl Fn(&History) -> Option<(FrameId, Isometry3<f64>)>,
    ) -> Result<(Isometry3<f64>, Time), Failure> {
        let mut top = source;
        let mut top_from_source = Isometry3::identity();
        let mut links = 0;
        let mut broken_at = None;
        while let Some(history) = self.history(top) {
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
                return Err(Failure::Loop(source));
            }
        }

        let mut frame = target;
        let mut frame_from_target = Isometry3::identity();
        links = 0;
        while frame != top {
            if frame == source {
                return Ok((frame_from_target.inverse(), time));
            }
            let Some(history) = self.history(frame) else {
                return Err(match broken_at {
                    Some(frame) => Failure::Unknown { frame, time },
                    None => Failure::Unconnected { target_root: frame, source_root: top },
                });
            };
            let Some((parent, parent_from_child)) = place(history) else {
                return Err(Failure::Unknown { frame, time });
            };
            frame_from_target = parent_from_child * frame_from_target;
            frame = parent;
            links += 1;
            if links > MAX_DEPTH {
                return Err(Failure::Loop(target));
            }
        }
        let top_from_target = frame_from_target;
        Ok((top_from_target.inverse() * top_from_source, time))
    }

    /// `a` is the target and `b` the source of the lookup.
    fn common_time(&self, a: FrameId, b: FrameId) -> Result<Time, Failure> {
        if a == b {
            return Ok(self.newest_stamp(a).unwrap_or(Time::ZERO));
        }
        // The distances from the root show where the two ways up can meet first.
        let (b_root, above_b) = match self.way_up(b, a)? {
            WayUp::Met => return Ok(self.oldest_between(b, a)),
            WayUp::Root { root, links } => (root, links),
        };
        let (a_root, above_a) = match self.way_up(a, b)? {
            WayUp::Met => return Ok(self.oldest_between(a, b)),
            WayUp::Root { root, links } => (root, links),
        };
        if a_root != b_root {
            return Err(Failure::Unconnected { target_root: a_root, source_root: b_root });
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
    fn way_up(&self, from: FrameId, other: FrameId) -> Result<WayUp, Failure> {
        let mut frame = from;
        for links in 0..=MAX_DEPTH {
            if frame == other {
                return Ok(WayUp::Met);
            }
            match self.history(frame).and_then(|history| history.newest()) {
                Some(newest) => frame = newest.parent,
                None => return Ok(WayUp::Root { root: frame, links }),
            }
        }
        Err(Failure::Loop(from))
    }

    /// The common time from `from` up to `ancestor`, which is known to be above it.
    fn oldest_between(&self, from: FrameId, ancestor: FrameId) -> Time {
        let (mut frame, mut oldest) = (from, None);
        while frame != ancestor {
            frame = self.step_up(frame, &mut oldest);
        }
        oldest.unwrap_or(Time::ZERO)
    }

    /// The newest parent of `frame`; its stamp joins `oldest`. Stamps of zero bound no common time.
    fn step_up(&self, frame: FrameId, oldest: &mut Option<Time>) -> FrameId {
        let Some(newest) = self.history(frame).and_then(|history| history.newest()) else {
            return frame;
        };
        if !newest.stamp.is_zero() {
            *oldest = Some(oldest.map_or(newest.stamp, |oldest| oldest.min(newest.stamp)));
        }
        newest.parent
    }

    fn newest_stamp(&self, id: FrameId) -> Option<Time> {
        Some(self.history(id)?.newest()?.stamp)
    }

    pub(crate) fn describe(&self, failure: Failure, target: &str, source: &str) -> LookupError {
        let (target, source) = (target.to_owned(), source.to_owned());
        match failure {
            Failure::Loop(frame) => {
                LookupError::Lookup { target, source, problem: LookupProblem::Loop(self.name(frame).to_owned()) }
            }
            Failure::Unconnected { target_root, source_root } => LookupError::Connectivity {
                target,
                source,
                target_root: self.name(target_root).to_owned(),
                source_root: self.name(source_root).to_owned(),
            },
            Failure::Unknown { frame, time } => LookupError::Extrapolation {
                target,
                source,
                frame: self.name(frame).to_owned(),
                requested: time,
                known: self.history(frame).and_then(|history| history.span()),
            },
        }
    }
}

/// Both names without a leading slash, if neither is empty.
pub(crate) fn names<'a>(target: &'a str, source: &'a str) -> Result<(&'a str, &'a str), LookupError> {
    let (target, source) = (strip_slash(target), strip_slash(source));
    if target.is_empty() || source.is_empty() {
        return Err(LookupError::InvalidArgument { target: target.to_owned(), source: source.to_owned() });
    }
    Ok((target, source))
}
