//! The evidence about what may be lit, and the decision from it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_render::PostProcess;

use crate::cause::{Content, DarkCause, DarkReason};
use crate::grant::{Generation, Grant, GrantedLight};

/// State of one cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Condition {
    /// Dark, and why.
    Dark(String),
    /// May be lit until then, if nothing new arrives.
    Until(Instant),
    /// May be lit as long as nobody says otherwise: not for what is measured.
    Always,
}

impl Condition {
    /// Both: the first that is dark, else the sooner end.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Dark(why), _) | (_, Self::Dark(why)) => Self::Dark(why),
            (Self::Always, other) | (other, Self::Always) => other,
            (Self::Until(a), Self::Until(b)) => Self::Until(a.min(b)),
        }
    }
}

/// The rules of a camera that do not change with each frame.
#[derive(Clone, Debug)]
pub struct LightRules {
    /// `true` if there are masks, keep-out frames, confirmed light or, for received images, a timeout.
    pub protects_eyes: bool,
    /// `true` if only light that a measured surface confirms is allowed.
    pub must_confirm: bool,
    /// Longest duration of a grant: an output that hears nothing for this long is black.
    pub limit: Duration,
}

impl LightRules {
    /// No rules: nothing but the end of the process ends the light, after this limit.
    pub fn none(limit: Duration) -> Self {
        Self { protects_eyes: false, must_confirm: false, limit }
    }
}

/// A condition for each cause that applies, and the allowed light at each pixel. A cause that nobody has set is dark.
#[derive(Clone, Debug)]
pub struct Evidence {
    rules: LightRules,
    rows: Vec<(DarkCause, Condition)>,
    post: Arc<PostProcess>,
}

impl Evidence {
    /// Evidence of which nothing is known yet: dark for each of the causes, which are in the table's order.
    pub fn unknown(causes: &[DarkCause], rules: LightRules, post: Arc<PostProcess>) -> Self {
        let rows = causes.iter().map(|cause| (*cause, Condition::Dark("nothing is known yet".to_owned()))).collect();
        Self { rules, rows, post }
    }

    /// Sets the state of a cause. One that does not apply is an error of the program, and stays dark.
    pub fn set(&mut self, cause: DarkCause, condition: Condition) {
        match self.rows.iter_mut().find(|(known, _)| *known == cause) {
            Some((_, known)) => *known = condition,
            None => self.rows.insert(0, (cause, Condition::Dark(format!("{cause:?} is no cause here")))),
        }
    }

    /// Takes over the state of a cause.
    pub fn keep(&mut self, cause: DarkCause, from: &Self) {
        if let Some((_, condition)) = from.rows.iter().find(|(known, _)| *known == cause) {
            self.set(cause, condition.clone());
        }
    }

    /// The rules.
    pub fn rules(&self) -> &LightRules {
        &self.rules
    }

    /// Post-processing with the allowed light at each pixel, and the orientation.
    pub fn post(&self) -> &Arc<PostProcess> {
        &self.post
    }

    /// The first cause in the table that darkens the scene now.
    pub fn dark_reason(&self, now: Instant) -> Option<DarkReason> {
        self.check(Content::Scene, now).err()
    }

    /// The time of the next change if nothing new arrives.
    pub fn end(&self) -> Option<Instant> {
        let until = |(_, condition): &(DarkCause, Condition)| match condition {
            Condition::Until(until) => Some(*until),
            Condition::Dark(_) | Condition::Always => None,
        };
        self.rows.iter().filter_map(until).min()
    }

    /// Decides about content for an image of this size (before it is turned). `operator` is the generation of the
    /// operator's words, or why the operator wants no light.
    ///
    /// # Errors
    /// The first cause in the table for which the content is dark.
    pub fn decide(
        &self,
        content: Content,
        size_px: [u32; 2],
        operator: Result<Generation, DarkReason>,
        now: Instant,
    ) -> Result<Grant, DarkReason> {
        let generation = operator?;
        let until = self.check(content, now)?;
        let blend = self.post.blend.clone().filter(|_| content == Content::Scene);
        let post = match blend == self.post.blend {
            true => Arc::clone(&self.post),
            // Blending lifts the black of scenes only.
            false => Arc::new(PostProcess { blend, ..PostProcess::clone(&self.post) }),
        };
        Ok(Grant::new(until, generation, GrantedLight { size_px, post, must_confirm: self.rules.must_confirm }))
    }

    /// The end of what holds now.
    fn check(&self, content: Content, now: Instant) -> Result<Instant, DarkReason> {
        let mut until = now + self.rules.limit;
        for (cause, condition) in self.rows.iter().filter(|row| row.0.darkens(content, self.rules.protects_eyes)) {
            match condition {
                Condition::Dark(why) => return Err(DarkReason::new(*cause, why.clone())),
                Condition::Until(end) if *end <= now => {
                    return Err(DarkReason::new(*cause, "the node is busy, and its data are too old by now"));
                }
                Condition::Until(end) => until = until.min(*end),
                Condition::Always => {}
            }
        }
        Ok(until)
    }
}

#[cfg(test)]
mod tests {
    use rcs_render::Blend;

    use super::*;

    const LIMIT: Duration = Duration::from_secs(1);

    /// Evidence of a camera with all causes well.
    fn lit(protects_eyes: bool, post: PostProcess) -> Evidence {
        let rules = LightRules { protects_eyes, must_confirm: false, limit: LIMIT };
        let mut evidence = Evidence::unknown(&DarkCause::OF_CAMERA, rules, Arc::new(post));
        DarkCause::OF_CAMERA.iter().for_each(|cause| evidence.set(*cause, Condition::Always));
        evidence
    }

    fn unknown() -> Evidence {
        Evidence::unknown(&DarkCause::OF_CAMERA, LightRules::none(LIMIT), Arc::default())
    }

    fn decide(evidence: &Evidence, content: Content, now: Instant) -> Result<Grant, DarkCause> {
        evidence.decide(content, [1, 1], Ok(Generation::default()), now).map_err(|dark| dark.cause)
    }

    #[test]
    fn a_cause_that_nobody_has_set_is_dark_and_so_is_one_that_is_none_here() {
        let now = Instant::now();
        for missing in DarkCause::OF_CAMERA {
            let mut evidence = unknown();
            let others = DarkCause::OF_CAMERA.into_iter().filter(|cause| *cause != missing);
            others.for_each(|cause| evidence.set(cause, Condition::Always));
            assert_eq!(decide(&evidence, Content::Scene, now).err(), Some(missing));
            assert_eq!(evidence.dark_reason(now).map(|dark| dark.cause), Some(missing));
        }
        let mut evidence = lit(true, PostProcess::default());
        assert!(decide(&evidence, Content::Scene, now).is_ok() && evidence.dark_reason(now).is_none());
        evidence.set(DarkCause::BlackImage, Condition::Always);
        assert_eq!(decide(&evidence, Content::Scene, now).err(), Some(DarkCause::BlackImage));
    }

    #[test]
    fn the_operator_comes_before_all() {
        let black = Err(DarkReason::new(DarkCause::Blackout, "key b"));
        let decided = lit(false, PostProcess::default()).decide(Content::Test, [1, 1], black, Instant::now());
        assert_eq!(decided.err().map(|dark| dark.cause), Some(DarkCause::Blackout));
    }

    #[test]
    fn a_grant_ends_with_the_first_condition_and_after_the_limit_at_the_latest() {
        let (now, mut evidence) = (Instant::now(), lit(true, PostProcess::default()));
        let after = |millis| now + Duration::from_millis(millis);
        assert_eq!(decide(&evidence, Content::Scene, now).unwrap().until(), now + LIMIT);
        assert_eq!(evidence.end(), None);
        evidence.set(DarkCause::Mask, Condition::Until(after(700)));
        evidence.set(DarkCause::Displays, Condition::Until(after(300)));
        assert_eq!(decide(&evidence, Content::Scene, now).unwrap().until(), after(300));
        assert_eq!(decide(&evidence, Content::Test, now).unwrap().until(), after(700), "a test picture shows no data");
        assert_eq!(evidence.end(), Some(after(300)));
        assert_eq!(decide(&evidence, Content::Scene, after(300)).err(), Some(DarkCause::Displays));
        assert_eq!(decide(&evidence, Content::Test, after(700)).err(), Some(DarkCause::Mask));
        evidence.set(DarkCause::Mask, Condition::Until(after(5000)));
        assert_eq!(decide(&evidence, Content::Test, after(100)).unwrap().until(), after(100) + LIMIT);
    }

    #[test]
    fn what_darkens_a_note_depends_on_whether_eyes_are_protected() {
        let now = Instant::now();
        for (protects_eyes, expected) in [(false, None), (true, Some(DarkCause::NoCamera))] {
            let mut evidence = lit(protects_eyes, PostProcess::default());
            evidence.set(DarkCause::NoCamera, Condition::Dark("no pose".to_owned()));
            assert_eq!(decide(&evidence, Content::Note, now).err(), expected);
        }
    }

    #[test]
    fn the_state_of_a_cause_is_taken_over() {
        let (known, mut evidence) = (lit(false, PostProcess::default()), unknown());
        evidence.keep(DarkCause::NoCamera, &known);
        evidence.keep(DarkCause::NoImage, &known);
        assert_eq!(evidence.dark_reason(Instant::now()).map(|dark| dark.cause), Some(DarkCause::UnknownName));
        let others = DarkCause::OF_CAMERA.into_iter().filter(|cause| *cause != DarkCause::NoCamera);
        others.for_each(|cause| evidence.set(cause, Condition::Always));
        assert_eq!(evidence.dark_reason(Instant::now()), None);
        let mut dark = lit(false, PostProcess::default());
        dark.set(DarkCause::NoCamera, Condition::Dark("no pose".to_owned()));
        evidence.keep(DarkCause::NoCamera, &dark);
        assert_eq!(evidence.dark_reason(Instant::now()).map(|dark| dark.cause), Some(DarkCause::NoCamera));
    }

    #[test]
    fn blending_lifts_the_black_of_scenes_only() {
        let blend = Blend::new([1, 1], &[u16::MAX], &[], 2.2).ok().map(Arc::new);
        let (now, evidence) = (Instant::now(), lit(false, PostProcess { blend, ..PostProcess::default() }));
        assert!(evidence.post().blend.is_some());
        let has_blend = |content| decide(&evidence, content, now).unwrap().post().blend.is_some();
        assert_eq!([Content::Scene, Content::Test, Content::Note].map(has_blend), [true, false, false]);
    }

    #[test]
    fn of_two_conditions_the_worse_counts() {
        let (now, dark) = (Instant::now(), || Condition::Dark("why".to_owned()));
        let until = |secs| Condition::Until(now + Duration::from_secs(secs));
        assert_eq!(until(1).and(dark()), dark());
        assert_eq!(dark().and(Condition::Always), dark());
        assert_eq!(until(2).and(until(1)), until(1));
        assert_eq!(Condition::Always.and(until(1)), until(1));
        assert_eq!(until(1).and(Condition::Always), until(1));
    }
}
