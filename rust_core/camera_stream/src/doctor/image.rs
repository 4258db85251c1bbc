//! Checks of a camera's images: whether they come, how often, and how old they are.

use std::time::Duration;

use rcs_displays::CameraView;
use rcs_messages::{Image, MessageKind};
use rcs_ros::{RosNode, TopicSubscription};

use super::finding::{secs, Finding};
use super::look::Look;
use crate::check::observed::Arrivals;

/// Images that wait for the doctor's thread, so that none is missed while it updates the scene.
const QUEUE_SIZE: usize = 10;
/// Age on arrival that is a fault, seconds.
const MAX_AGE_SECS: f64 = 0.5;
/// Part of the config's frame rate that is a fault.
const LOW_RATE: f64 = 0.5;

/// Subscribes to the images of cameras. A node that publishes on demand draws from then on.
pub(super) fn subscribe<'c>(ros: &RosNode, cameras: impl Iterator<Item = &'c CameraView>) -> Vec<TopicSubscription> {
    let topics = cameras.map(|camera| &camera.settings.image_topic).filter(|topic| !topic.is_empty());
    let subscribe = |topic: &String| ros.subscribe(topic, MessageKind::Image, QUEUE_SIZE);
    topics.filter_map(|topic| subscribe(topic).map_err(|error| log::warn!("{error}")).ok()).collect()
}

/// The images of a camera.
pub(super) fn rate(look: &Look<'_>, camera: &CameraView) -> Finding {
    let name = look.name("image", camera);
    let topic = look.whole_name(&camera.settings.image_topic);
    let publishers = look.publishers(&topic);
    let (node, listened) = (look.session.checked_name.trim_start_matches('/'), secs(look.listened.as_secs_f64()));
    match look.observed.topics.get(topic.as_str()) {
        Some(arrivals) => {
            let image = look.observed.images.get(topic.as_str());
            let wanted_hz = f64::from(camera.settings.frame_rate_hz);
            received(name, arrivals, wanted_hz, image.is_some_and(|image| is_black(image)))
        }
        None if publishers.is_empty() => Finding::bad(
            name,
            format!("nobody publishes {topic}"),
            format!("start {node} (roslaunch), or correct image_topic"),
        ),
        None if camera.settings.frame_rate_hz == 0.0 => {
            Finding::unknown(name, format!("none on {topic} in {listened}: Frame Rate is 0"), "call its camera_trigger")
        }
        None => {
            let text = format!("none on {topic} in {listened}, published by {}", publishers.join(", "));
            Finding::bad(name, text, "correct what is wrong above, then see that node's log")
        }
    }
}

/// The finding for images that came.
fn received(name: String, arrivals: &Arrivals, wanted_hz: f64, is_black: bool) -> Finding {
    let age_secs = arrivals.last_age_secs.unwrap_or_default();
    let hz = arrivals.period().map(|period| 1.0 / period.max(Duration::from_micros(1)).as_secs_f64());
    let rate = hz.map_or_else(|| "one image".to_owned(), |hz| format!("{hz:.1} images a second"));
    let text = format!("{rate}, {} old on arrival", secs(age_secs));
    if age_secs > MAX_AGE_SECS {
        return Finding::bad(name, text, "the network or the computer is too slow for them, or its clock is wrong");
    }
    if hz.is_some_and(|hz| wanted_hz > 0.0 && hz < wanted_hz * LOW_RATE) {
        let text = format!("{text}, the config asks for {wanted_hz}");
        return Finding::bad(
            name,
            text,
            "the node's log says what is slow; a GPU (renderer:=gpu) or a smaller scene helps",
        );
    }
    if is_black {
        return Finding::unknown(
            name,
            format!("{text}, but black"),
            "nothing is lit: see the displays and limits above",
        );
    }
    Finding::good(name, text)
}

/// `true` if no pixel is lit.
fn is_black(image: &Image) -> bool {
    let is_dark = |pixel: &[u8]| pixel.iter().take(3).all(|channel| *channel == 0);
    if image.encoding.ends_with("a8") {
        return image.data().chunks(4).all(is_dark);
    }
    image.data().iter().all(|byte| *byte == 0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Instant;

    use rcs_messages::std_msgs::Header;

    use super::*;
    use crate::check::observed::tests::arrivals;

    #[test]
    fn images_are_judged_by_rate_age_and_light() {
        let line = |period: f64, age: f64, wanted_hz: f64, is_black: bool| {
            let times: Vec<f64> = (0..20).map(|index| f64::from(index) * period).collect();
            let seen = arrivals(Instant::now(), &times, age);
            received("image".to_owned(), &seen, wanted_hz, is_black).to_string()
        };
        assert_eq!(line(0.1, 0.02, -1.0, false), "✓ image: 10.0 images a second, 0.02 s old on arrival");
        assert!(line(0.1, 0.02, 30.0, false)
            .starts_with("✗ image: 10.0 images a second, 0.02 s old on arrival, the config"));
        assert!(
            line(0.1, 0.9, -1.0, false).starts_with("✗ image: 10.0 images a second, 0.9 s old on arrival; the network")
        );
        assert!(line(0.1, 0.02, -1.0, true)
            .starts_with("? image: 10.0 images a second, 0.02 s old on arrival, but black; "));
    }

    #[test]
    fn a_black_image_has_no_lit_pixel_whatever_its_alpha() {
        let image = |encoding: &str, pixels: &[u8]| {
            Image::new(Header::default(), [1, 1], encoding, 4, Arc::new(pixels.to_vec()))
        };
        assert!(is_black(&image("rgb8", &[0, 0, 0])) && is_black(&image("rgba8", &[0, 0, 0, 255])));
        assert!(!is_black(&image("rgb8", &[0, 0, 1])) && !is_black(&image("bgra8", &[0, 9, 0, 255])));
    }
}
