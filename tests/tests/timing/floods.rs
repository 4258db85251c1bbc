//! Messages faster than pictures can be drawn: the newest one is shown, and nothing is kept.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};
use std::time::Duration;

use crate::load::{drawn, of_process, watched, FILM};

#[test]
fn of_clouds_that_come_faster_than_they_can_be_drawn_the_newest_is_shown() {
    let fixture = RosFixture::start(&config(&[CLOUD, FILM], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    fixture.python("latch('/eye/camera_info', info(width=1024, height=1024, f=1100.0))");
    // Half transparent squares that fill the picture, all of one colour, which tells the message: its red's upper bits.
    fixture.python(
        "layers = [(0, 0, 1 + z / 1000) for z in range(200)]\n\
         coloured = [written(cloud((16 * k + 8) << 16 | 0xff, points=layers)) for k in range(16)]\n\
         sent = []\n\
         def film(i):\n    sent.append(time.time())\n    return coloured[len(sent) % 16]\n\
         def sent_at():\n    shown = viewer.middle()[0] // 16\n    newest = len(sent)\n    \
             return sent[newest - (newest - shown) % 16 - 1]\n\
         repeated = PublishRepeatedly(60, film, '/film')",
    );
    fixture.wait_for("viewer.last.width == 1024 and len(viewer.colors) > 4 and viewer.middle()[2] > 200");
    fixture.wait_for("'frames drawn' in values('camera_stream: CameraPub')");
    let (before, memory) = (drawn(&fixture), of_process(&fixture, "VmRSS"));
    fixture.python("begun, ages = time.time(), []");
    fixture.python("while time.time() < begun + 5: ages.append(time.time() - sent_at()); time.sleep(0.02)");
    fixture.python("arrays.clear()");
    fixture.wait_for("len(arrays) > 1");
    let secs: f64 = fixture.python("time.time() - begun").parse().unwrap();
    let period_secs = secs / (drawn(&fixture) - before) as f64;
    let age_secs: f64 = fixture.python("sorted(ages)[len(ages) // 2]").parse().unwrap();
    let grown_mb = of_process(&fixture, "VmRSS").saturating_sub(memory) >> 10;
    println!("a picture each {period_secs:.3} s, whose cloud is {age_secs:.3} s old in the middle; {grown_mb} MB more");
    assert!(period_secs > 2.0 / 60.0, "each cloud could be drawn: {period_secs} s");
    // One picture is being drawn while the one before it is shown.
    assert!(age_secs < 2.5 * period_secs + 0.1, "{age_secs} s old, a picture each {period_secs} s");
    assert!(grown_mb < 30, "{grown_mb} MB");
}

#[test]
fn a_thousand_sizes_of_the_picture_cost_nothing_afterwards() {
    let fixture = RosFixture::start(&config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    let (memory, threads) = (of_process(&fixture, "VmRSS"), of_process(&fixture, "Threads"));
    fixture.python(
        "import random; rng = random.Random(5); viewer.forget()\n\
         for i in range(1000):\n    \
             latch('/eye/camera_info', info(width=rng.randrange(1, 900), height=rng.randrange(1, 700), f=rng.uniform(1, 2000)))\n    \
             time.sleep(0.005)\n\
         latch('/eye/camera_info', info())",
    );
    fixture.wait_for("viewer.last and viewer.last.width == 64 and viewer.middle() == (255, 0, 0)");
    let sizes: usize = fixture.python("len({(i[4], i[5]) for i in viewer.images})").parse().unwrap();
    fixture.pictures_go_on(10, Duration::from_millis(500));
    let is_small = || of_process(&fixture, "VmRSS") < memory + (40 << 10);
    assert!(wait_until(PATIENCE, is_small), "{} kB, {memory} kB before", of_process(&fixture, "VmRSS"));
    println!("pictures of {sizes} sizes; {} MB, then {} MB", memory >> 10, of_process(&fixture, "VmRSS") >> 10);
    assert!(sizes > 50, "{sizes}");
    // Those of connections that come and go.
    let are_few = || of_process(&fixture, "Threads") <= threads + 2;
    assert!(wait_until(PATIENCE, are_few), "{} threads, {threads} before", of_process(&fixture, "Threads"));
    assert_eq!(fixture.log_lines(&["ERROR"]), 0, "{}", fixture.log());
}
