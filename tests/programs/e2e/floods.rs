//! Messages faster than images can be drawn: the newest one is shown, and nothing is kept.

use crate::load::{of_process, watched, FILM};
use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{Setup, CLOUD};

#[test]
#[ignore = "a load: ./test full"]
fn of_clouds_that_come_faster_than_they_can_be_drawn_the_newest_is_shown() {
    let fixture = Setup::of(&[CLOUD, FILM]).start();
    watched(&fixture);
    fixture.python("latch('/eye/camera_info', info(width=1024, height=1024, f=1100.0))");
    // Half transparent squares that fill the image, all of one colour, which tells the message: its red's upper bits.
    fixture.python(
        "layers = [(0, 0, 1 + z / 1000) for z in range(200)]\n\
         coloured = [written(cloud((16 * k + 8) << 16 | 0xff, points=layers)) for k in range(16)]\n\
         sent = []\n\
         def film(i):\n    sent.append(time.time())\n    return coloured[len(sent) % 16]\n\
         repeated = PublishRepeatedly(200, film, '/film')",
    );
    fixture.wait_for("viewer.last.width == 1024 and len(viewer.colors) > 4 and viewer.middle()[2] > 200");
    let memory = of_process(&fixture, "VmRSS");
    fixture.python("viewer.forget()");
    fixture.wait_for("len(viewer.colors) > 30");
    fixture.python("repeated.stop(); stopped = time.time()");
    fixture.wait_for("viewer.middle()[0] // 16 == len(sent) % 16");
    // Of the newest, and of one that was just being received. Any that are kept would be drawn, too: up to ten.
    let later = fixture.python("len({image[6] for image in viewer.images if image[2] > stopped})");
    let grown_mb = of_process(&fixture, "VmRSS").saturating_sub(memory) >> 10;
    println!("{} pictures, {later} of them begun later; {grown_mb} MB more", fixture.python("len(viewer.colors)"));
    assert!(later.parse::<u32>().unwrap() < 6, "{later} pictures of older clouds");
    assert!(grown_mb < 30, "{grown_mb} MB");
}

#[test]
#[ignore = "a load: ./test full"]
fn a_thousand_sizes_of_the_image_cost_nothing_afterwards() {
    let fixture = Setup::of(&[CLOUD]).start();
    watched(&fixture);
    let (memory, threads) = (of_process(&fixture, "VmRSS"), of_process(&fixture, "Threads"));
    fixture.python(
        "import random; rng = random.Random(5); viewer.forget()\n\
         def resize():\n    \
             for i in range(500):\n        \
                 latch('/eye/camera_info', info(width=rng.randrange(1, 900), height=rng.randrange(1, 700), f=rng.uniform(1, 2000)))\n        \
                 time.sleep(0.005)\n    \
             return len({i[4:6] for i in viewer.images})\n\
         resize()",
    );
    assert!(wait_until(PATIENCE, || fixture.python("resize()").parse::<u32>().unwrap() > 50), "few sizes");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("viewer.last and viewer.last.width == 64 and viewer.middle() == (255, 0, 0)");
    let sizes = fixture.python("len({i[4:6] for i in viewer.images})");
    fixture.images_go_on(10);
    let is_small = || of_process(&fixture, "VmRSS") < memory + (40 << 10);
    assert!(wait_until(PATIENCE, is_small), "{} kB, {memory} kB before", of_process(&fixture, "VmRSS"));
    println!("pictures of {sizes} sizes; {} MB, then {} MB", memory >> 10, of_process(&fixture, "VmRSS") >> 10);
    // Those of connections that come and go.
    let are_few = || of_process(&fixture, "Threads") <= threads + 2;
    assert!(wait_until(PATIENCE, are_few), "{} threads, {threads} before", of_process(&fixture, "Threads"));
    assert_eq!(fixture.log_lines(&["ERROR"]), 0, "{}", fixture.log());
}
