//! A user's rules for the light of cameras.

use std::str::FromStr;
use std::sync::Arc;

use rcs_render::{Blend, LightMask, Orientation};

use super::ages::limits::AgeLimits;
use super::names::{cameras_text, unmatched, ForCamera};
use super::surface::ConfirmRules;
use rcs_node_support::key_value;

/// The rules of all cameras.
#[derive(Debug)]
pub(crate) struct Rules {
    /// Limits of the age of data.
    pub(crate) limits: AgeLimits,
    pub(crate) orientations: Vec<ForCamera<Orientation>>,
    /// The shares of projectors that light one surface.
    pub(crate) blends: Vec<ForCamera<Arc<Blend>>>,
    /// Masks from files.
    pub(crate) painted_masks: Vec<ForCamera<Arc<LightMask>>>,
    /// The topics of masks, by whole names.
    pub(crate) mask_topics: Vec<ForCamera<String>>,
    /// Frames around which there must be no light.
    pub(crate) keep_out: Vec<KeepOutFrame>,
    /// `true` if all is dark while a mask or the place of a keep-out frame is missing or stale.
    pub(crate) is_required: bool,
    /// Light that a depth camera confirms.
    pub(crate) confirm: ConfirmRules,
}

impl Rules {
    pub(super) fn is_noop(&self) -> bool {
        self.orientations.is_empty()
            && self.blends.is_empty()
            && self.painted_masks.is_empty()
            && self.mask_topics.is_empty()
            && self.keep_out.is_empty()
    }

    /// The rules that name other cameras than these; `None` if there are none.
    pub(super) fn unmatched(&self, cameras: &[String]) -> Option<String> {
        let of = |option: &str, names: Vec<&str>| names.into_iter().map(|name| format!("{option} {name}")).collect();
        let wrong: [Vec<String>; 5] = [
            of("mask_topic", unmatched(&self.mask_topics, cameras).collect()),
            of("mask", unmatched(&self.painted_masks, cameras).collect()),
            of("blend", unmatched(&self.blends, cameras).collect()),
            of("orientation", unmatched(&self.orientations, cameras).collect()),
            of("surface", unmatched(&self.confirm.surfaces, cameras).collect()),
        ];
        let wrong = wrong.concat();
        let text = || format!("the config has no camera for {}; {}", wrong.join(", "), cameras_text(cameras));
        (!wrong.is_empty()).then(text)
    }
}

/// A frame around which there must be no light: `FRAME=RADIUS`, metres.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct KeepOutFrame {
    /// `frame_id`, without a leading `/`.
    pub(crate) frame: String,
    /// Distance from its origin, metres.
    pub(crate) radius_m: f64,
}

impl FromStr for KeepOutFrame {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "not FRAME=RADIUS with a radius in metres, above 0 and not above 100".to_owned();
        let (frame, radius) = key_value::split(text).ok_or_else(wrong)?;
        let radius_m = radius.parse::<f64>().ok().filter(|radius_m| *radius_m > 0.0 && *radius_m <= 100.0);
        match (frame.trim_start_matches('/'), radius_m) {
            ("", _) | (_, None) => Err(wrong()),
            (frame, Some(radius_m)) => Ok(Self { frame: frame.to_owned(), radius_m }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_keep_out_frame_has_a_radius_in_metres() {
        let parse = |text: &str| text.parse::<KeepOutFrame>();
        assert_eq!(parse("/head=0.4"), Ok(KeepOutFrame { frame: "head".to_owned(), radius_m: 0.4 }));
        for wrong in ["head", "head=", "head=0.3 hand=0.2", "=1", "/=1", "head=0", "head=-1", "head=nan", "head=inf"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
