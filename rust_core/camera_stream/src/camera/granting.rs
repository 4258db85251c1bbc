//! Choice of what a camera shows: the scene, or what stands in its place, each with its grant.

use std::sync::Arc;
use std::time::Instant;

use rcs_light::{Content, DarkCause, DarkReason, Grant};

use super::frame::{FrameContent, FrameSpec, TestContent};
use super::output::CameraPublisher;
use super::substitute;
use crate::control::OperatorSettings;

impl CameraPublisher {
    /// Why its scene is dark now.
    pub(super) fn dark_reason(&self, operator: &OperatorSettings) -> Option<DarkReason> {
        operator.light.clone().err().or_else(|| self.light.evidence.dark_reason(Instant::now()))
    }

    /// The grant of the scene, or the content in its place with its grant: a test image or pattern where the operator
    /// wants one, else black for a reason. `place` is the size before turning, and the optical frame.
    pub(super) fn grant_scene(
        &self,
        place: ([u32; 2], &str),
        operator: &OperatorSettings,
    ) -> Result<Grant, (FrameContent, Option<Grant>)> {
        let ((size_px, frame_id), now) = (place, Instant::now());
        let decide = |content| {
            let grant = self.light.evidence.decide(content, size_px, operator.light.clone(), now)?;
            Ok::<_, DarkReason>(self.last_check.confirm(content, grant))
        };
        let turned_px = self.orientation().size_px(size_px);
        let pattern = operator.pattern.as_ref().filter(|pattern| pattern.fits(frame_id, turned_px));
        let pattern = pattern.map(|pattern| TestContent::Pattern(Arc::clone(pattern)));
        if let Some(test) = pattern.or(operator.test_image.map(TestContent::Image)) {
            match decide(Content::Test) {
                Ok(grant) if grant.is_unconfirmed() => {
                    let dark =
                        DarkReason::new(DarkCause::Surface, "no light of the scene was confirmed before the test");
                    return Err((FrameContent::Black { size_px, dark }, None));
                }
                Ok(grant) => {
                    let grant = substitute::grant_of(&test, grant);
                    return Err((FrameContent::Test { size_px, test }, Some(grant)));
                }
                // The scene is dark, too.
                Err(_) => {}
            }
        }
        let dark = match decide(Content::Scene) {
            Ok(grant) => return Ok(grant),
            Err(dark) => dark,
        };
        let note = self.light.has_note.then(|| decide(Content::Note).ok()).flatten();
        Err(match note.filter(|grant| !grant.is_unconfirmed()) {
            Some(grant) => (FrameContent::Note { size_px, dark }, Some(grant)),
            None => (FrameContent::Black { size_px, dark }, None),
        })
    }

    /// The last frame as a pause keeps it, with the scene's present grant; `None` if it may not stay.
    pub(super) fn held(&self, grant: &Grant) -> Option<FrameSpec> {
        let last = self.buffers.front.as_ref()?;
        let is_scene = matches!(last.spec.content, FrameContent::Scene { .. });
        let has_light = |own: &Grant| own.allows_the_same(grant);
        let can_be_masked = last.drawn.is_some() || last.spec.grant.as_ref().is_some_and(has_light);
        let stays = is_scene && can_be_masked && last.spec.epoch == self.epoch.number;
        let stays = stays && self.last_check.is_of_present_pose();
        stays.then(|| FrameSpec { grant: Some(grant.clone()), ..last.spec.clone() })
    }
}
