//! The latency figures on `/diagnostics`, compared with what a subscriber measures.

use rcs_tests::ros_fixture::{RosFixture, Setup, CLOUD};
/// Python helpers beside `monitor`: a camera's figures as (median, p95), and when the image first changed after a
/// cloud.
const FIGURES: &str = "
CAMERA, DISPLAY = 'camera_stream: CameraPub', 'camera_stream: cloud'
def measured(): return int(values(CAMERA).get('frames measured', -1))
def reported(name): return values(CAMERA)[name + ' ms (median / p95)']
def figure(name): return tuple(float(part) for part in reported(name).split(' / '))
def age_now(): return float(values(DISPLAY)['age of the data shown ms'])
def shown_at(): return arrays[-1][1] * 1e3 - age_now()
STAGES = ['received to decoded', 'decoded to drawn', 'drawn to published']
TOTAL, AGE = 'received to published', 'age of the data shown'
def seen_ms(sent): return (next(image[0] for image in viewer.images if image[6] != before) - sent) * 1e3
def reported_ms(sent): return (arrays[-1][0] - sent) * 1e3
def drawn_ms(): return figure(STAGES[0])[0] + figure(STAGES[1])[0] - 0.01
def ago(secs): return rospy.Time.now() - rospy.Duration(secs)
";

/// Asserts that the image was drawn before the subscriber saw it, and published before that was reported: a node that
/// has to wait for a processor may see its own hand-over later than the subscriber sees the image.
fn assert_in_time(fixture: &RosFixture, least_ms: f64) -> f64 {
    let figures = fixture.python("[(name, reported(name)) for name in STAGES + [TOTAL, AGE]]");
    let [drawn_ms, seen_ms] = ["drawn_ms()", "seen_ms(sent)"].map(|python| number(fixture, python));
    let [total_ms, reported_ms] = ["figure(TOTAL)[0]", "reported_ms(sent)"].map(|python| number(fixture, python));
    assert!(drawn_ms <= seen_ms, "drawn after {drawn_ms} ms, seen after {seen_ms} ms: {figures}");
    assert!(least_ms < total_ms && total_ms <= reported_ms, "{total_ms} of {reported_ms} ms: {figures}");
    seen_ms
}

/// Whether the three stages of the only image add up to the total: they are reported to a hundredth of a millisecond.
const ADDS_UP: &str = "abs(sum(figure(stage)[0] for stage in STAGES) - figure(TOTAL)[0]) < 0.03";

/// A node whose camera sees an empty scene and has measured nothing yet.
fn watched(fixture: RosFixture, info: &str) -> RosFixture {
    fixture.python("monitor()");
    fixture.python(FIGURES);
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python(format!("latch('/eye/camera_info', {info})"));
    fixture.wait_for("level(CAMERA) == 0");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.images and publisher('/cloud', PointCloud2, False).get_num_connections()");
    fixture.python("before = viewer.images[-1][6]");
    fixture
}

fn fixture(info: &str) -> RosFixture {
    watched(Setup::of(&[CLOUD]).start(), info)
}

/// The value of a Python expression that is a number.
fn number(fixture: &RosFixture, python: &str) -> f64 {
    fixture.python(python).parse().unwrap()
}

#[test]
fn the_stages_of_a_image_add_up_to_no_more_than_the_latency_a_subscriber_sees() {
    let fixture = fixture("info(width=1280, height=800, f=900.0)");
    fixture.wait_for("measured() == 0");
    assert_eq!(fixture.python("[reported(name) for name in STAGES + [TOTAL, AGE]]"), "['-', '-', '-', '-', '-']");
    // A hundred squares of half the image, each in front of the last one, take time to render.
    fixture.python("squares = [(0, 0, 4 - z / 50) for z in range(100)]");
    fixture.python("sent = time.time(); send('/cloud', cloud(0xff0000, points=squares, stamp=ago(2)))");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and measured() == 1");
    let figures = fixture.python("[(name, reported(name)) for name in STAGES + [TOTAL, AGE]]");
    assert_eq!(fixture.python("all(figure(name)[0] == figure(name)[1] for name in STAGES + [TOTAL, AGE])"), "True");
    assert_eq!(fixture.python(ADDS_UP), "True", "{figures}");
    assert_eq!(fixture.python("all(figure(stage)[0] >= 0 for stage in STAGES)"), "True", "{figures}");
    let seen_ms = assert_in_time(&fixture, 0.0);
    let age_ms = number(&fixture, "figure(AGE)[0]");
    // Stamped after `sent`, before it was received; the image is stamped before it is published.
    let least_ms = 2000.0 + number(&fixture, "figure(TOTAL)[0] - figure('drawn to published')[0]") - 0.1;
    assert!((least_ms..=2000.0 + seen_ms).contains(&age_ms), "seen after {seen_ms} ms: {figures}");
    // A repeated image is not measured again.
    let published = "int(values(CAMERA)['frames published'])";
    fixture.wait_for(format!("{published} > 60"));
    assert_eq!(fixture.python("measured(), reported(AGE)"), format!("(1, '{age_ms:.2} / {age_ms:.2}')"));
}

/// A GPU draws one cloud while the next is uploaded, but waits for none.
#[test]
fn clouds_are_seen_on_a_gpu_before_the_next_one_is_sent_and_after_many_the_last_one() {
    let node = Setup::of(&[CLOUD]).args(&["--renderer", "gpu"]).start();
    let fixture = watched(node, "info()");
    for color in ["0xff0000", "0x00ff00", "0x0000ff"] {
        fixture.python(format!("color = {color}; send('/cloud', cloud(color))"));
        fixture.wait_for("viewer.middle() == tuple(color.to_bytes(3, 'big'))");
    }
    fixture.wait_for("measured() == 3");
    fixture.python("[send('/cloud', cloud(0x10000 + i)) for i in range(50)]; send('/cloud', cloud(0xffffff))");
    fixture.wait_for("viewer.middle() == (255, 255, 255)");
}

#[test]
fn waiting_for_a_frame_counts_from_when_the_message_was_received() {
    let fixture = fixture("info()");
    fixture.python("sent = time.time(); send('/cloud', cloud(0x00ff00, 'late', stamp=rospy.Time.now()))");
    fixture.wait_for("values(DISPLAY).get('messages received') == '1'");
    // The time that is measured below; meanwhile nothing may be drawn.
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert_eq!(fixture.python("measured(), values(DISPLAY)['age of the data shown ms']"), "(0, '-')");
    fixture.python("latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'late').transforms))");
    fixture.wait_for("viewer.middle() == (0, 255, 0) and measured() == 1");
    let figures = fixture.python("[(name, reported(name)) for name in STAGES + [TOTAL, AGE]]");
    assert_eq!(fixture.python(ADDS_UP), "True", "{figures}");
    let seen_ms = assert_in_time(&fixture, 1000.0);
    assert!(number(&fixture, "figure('received to decoded')[0]") > 1000.0, "{figures}");
    assert!((1000.0..=seen_ms).contains(&number(&fixture, "figure(AGE)[0]")), "seen after {seen_ms} ms: {figures}");
}

#[test]
fn figures_are_those_of_the_last_hundred_images_and_the_age_follows_the_stamps() {
    let fixture = fixture("info()");
    let often = |stamp: &str| {
        fixture.python("before_count = len({image[6] for image in viewer.images})");
        fixture
            .python(format!("repeated = PublishRepeatedly(40, lambda i: cloud(0x10000 + i, stamp={stamp}), '/cloud')"));
        fixture.wait_for("len({image[6] for image in viewer.images}) - before_count > 130");
    };
    let pause = || {
        fixture.python("repeated.stop(); arrived = len(arrays)");
        fixture.wait_for("len(arrays) > arrived + 2");
        fixture.python("viewer.forget(); before = None");
    };
    often("ago(2)");
    pause();
    let figures = fixture.python("[(name, reported(name)) for name in STAGES + [TOTAL, AGE]]");
    assert_eq!(fixture.python("measured()"), "100");
    assert_eq!(fixture.python("all(0 <= figure(name)[0] <= figure(name)[1] for name in STAGES + [TOTAL])"), "True");
    let (total_ms, age_ms) = (number(&fixture, "figure(TOTAL)[0]"), number(&fixture, "figure(AGE)[0]"));
    assert!(total_ms > 0.0 && age_ms > 2000.0 + total_ms / 2.0, "{figures}");

    // No new message arrives, and the data shown grows older: it is the same data's.
    fixture.python("age, at = age_now(), shown_at()");
    fixture.wait_for("2000 < age < age_now() - 1500 and abs(shown_at() - at) < 500");

    // Stamps of a clock that is ahead.
    often("ago(-3600)");
    pause();
    let figures = fixture.python("reported(AGE)");
    assert_eq!(fixture.python("all(-3600000 <= age < 0 for age in figure(AGE))"), "True", "{figures}");
    // Data with stamp zero is measured but has no age: the last ages stay.
    often("rospy.Time()");
    pause();
    assert_eq!(fixture.python("measured(), reported(AGE)"), format!("(100, '{figures}')"));
    assert_eq!(fixture.python("values(DISPLAY)['age of the data shown ms']"), "-");
}

#[test]
fn with_simulated_time_the_age_is_in_that_time_and_unknown_before_the_first_clock() {
    let fixture = Setup::of(&[CLOUD]).simulated_time().start();
    fixture.python("monitor()");
    fixture.python(FIGURES);
    fixture.python("place_camera(); viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.images");
    fixture.python("send('/cloud', cloud(0xff0000, stamp=rospy.Time(70)))");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and measured() >= 1");
    fixture.wait_for("values(DISPLAY).get('messages received') == '1'");
    assert_eq!(fixture.python("reported(AGE), values(DISPLAY)['age of the data shown ms']"), "('-', '-')");
    fixture.python("from rosgraph_msgs.msg import Clock");
    fixture.python("latch('/clock', Clock(rospy.Time(77)))");
    fixture.wait_for("arrays[-1][1] == 77.0");
    fixture.python("send('/cloud', cloud(0x0000ff, stamp=rospy.Time(75)))");
    fixture.wait_for("viewer.middle() == (0, 0, 255) and reported(AGE) == '2000.00 / 2000.00'");
    fixture.wait_for("age_now() == 2000");
    assert_eq!(fixture.python("0 < figure(TOTAL)[1]"), "True", "the stages are in the computer's time");
}
