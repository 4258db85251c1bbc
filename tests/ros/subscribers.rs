//! Subscribers that read slowly, stop, or leave: nobody pays for another.

use crate::probe;
use crate::raw::{read_framed, subscribe};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use std::io::Read;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

const TOPIC: &str = "/view/image";
const RATE: u32 = 20;
/// One period and a half: half of one is for what wakes up late.
const LONGEST_GAP: Duration = Duration::from_millis(75);
const ROUNDS: usize = 4;
/// How long a viewer that goes on was stopped, in seconds, if another time than the test's is to be measured.
const STOPPED_S: &str = "STOPPED_S";

fn pictures(master: &RosMaster) -> Running {
    let publisher = probe(master, &["image", TOPIC, "1280", "800", &RATE.to_string()]);
    assert!(publisher.line_with("ready").is_some(), "{:?}", publisher.errors());
    publisher
}

/// A picture's sequence number, which its message begins with.
fn seq(message: &[u8]) -> u32 {
    u32::from_le_bytes([message[0], message[1], message[2], message[3]])
}

/// How long ago a picture was published: its stamp follows the sequence number.
fn latency(message: &[u8]) -> Duration {
    let [secs, nanos] = [4, 8].map(|at| u32::from_le_bytes(std::array::from_fn(|index| message[at + index])));
    let stamp = SystemTime::UNIX_EPOCH + Duration::new(secs.into(), nanos);
    SystemTime::now().duration_since(stamp).unwrap_or_default()
}

/// A picture as it arrived.
struct Seen {
    at: Instant,
    seq: u32,
    latency: Duration,
}

/// What a viewer saw in a while.
#[derive(Debug)]
struct Measured {
    pictures: usize,
    longest_gap: Duration,
    median_latency: Duration,
}

/// Reads pictures as they come, and notes when.
struct Viewer {
    seen: Arc<Mutex<Vec<Seen>>>,
    is_ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Viewer {
    fn start(mut stream: TcpStream) -> Self {
        let (seen, is_ended): (Arc<Mutex<Vec<_>>>, Arc<AtomicBool>) = Default::default();
        let (notes, end) = (Arc::clone(&seen), Arc::clone(&is_ended));
        let thread = std::thread::spawn(move || {
            while !end.load(Ordering::Acquire) {
                let Ok(message) = read_framed(&mut stream) else { return };
                let seen = Seen { at: Instant::now(), seq: seq(&message), latency: latency(&message) };
                notes.lock().unwrap().push(seen);
            }
        });
        Self { seen, is_ended, thread: Some(thread) }
    }

    /// The pictures of so long, from now on.
    fn measure(&self, duration: Duration) -> Measured {
        let begin = Instant::now();
        std::thread::sleep(duration);
        self.since(begin)
    }

    /// The pictures from a moment until now.
    fn since(&self, begin: Instant) -> Measured {
        let duration = begin.elapsed();
        let all = self.seen.lock().unwrap();
        let seen: Vec<&Seen> = all.iter().filter(|seen| seen.at >= begin).collect();
        let gaps = seen.windows(2).map(|pair| pair[1].at - pair[0].at);
        let mut latencies: Vec<Duration> = seen.iter().map(|seen| seen.latency).collect();
        latencies.sort();
        Measured {
            pictures: seen.len(),
            longest_gap: gaps.max().unwrap_or(duration),
            median_latency: latencies.get(latencies.len() / 2).copied().unwrap_or(duration),
        }
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        self.is_ended.store(true, Ordering::Release);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Reads so many bytes a second until the connection ends or this is dropped.
struct SlowReader(Arc<AtomicBool>);

impl SlowReader {
    fn start(mut stream: TcpStream, bytes_per_s: usize) -> Self {
        let is_ended: Arc<AtomicBool> = Arc::default();
        let end = Arc::clone(&is_ended);
        std::thread::spawn(move || {
            let mut piece = vec![0; bytes_per_s / 50];
            while !end.load(Ordering::Acquire) && stream.read_exact(&mut piece).is_ok() {
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        Self(is_ended)
    }
}

impl Drop for SlowReader {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// Fails when viewers that come beside a good one cost it pictures or time. The best of some rounds counts: a machine's
/// other work only ever adds. In each round they come anew, because what one costs may be a single pause.
fn assert_undisturbed<T>(master: &RosMaster, publisher: &Running, others: impl Fn() -> T) {
    let good = Viewer::start(subscribe(master, "/probe", TOPIC, "/good"));
    let alone = good.measure(Duration::from_secs(3));
    println!("3 s alone: {alone:?}");
    let is_undisturbed = (0..ROUNDS).any(|_| {
        let begin = Instant::now();
        let present = others();
        std::thread::sleep(Duration::from_secs(5).saturating_sub(begin.elapsed()));
        let beside = good.since(begin);
        println!("5 s beside others: {beside:?}");
        drop(present);
        assert!(publisher.prints_again("to 1 in", PATIENCE));
        beside.pictures * 100 >= 5 * RATE as usize * 98
            && beside.longest_gap < LONGEST_GAP
            && beside.median_latency < alone.median_latency + Duration::from_millis(2)
    });
    assert!(is_undisturbed);
}

#[test]
fn slow_and_stopped_viewers_cost_the_others_nothing() {
    let master = RosMaster::start().unwrap();
    let publisher = pictures(&master);
    assert_undisturbed(&master, &publisher, || {
        let slow = [1_000_000, 10_000_000]
            .map(|rate| SlowReader::start(subscribe(&master, "/probe", TOPIC, &format!("/reads_{rate}")), rate));
        let stopped = [0, 1, 2, 3, 4].map(|index| subscribe(&master, "/probe", TOPIC, &format!("/stopped_{index}")));
        assert!(publisher.prints_again("to 8 in", PATIENCE));
        (slow, stopped)
    });
}

/// Subscribes until it is dropped.
struct Subscribed<'a>(&'a PythonNode);

impl Drop for Subscribed<'_> {
    fn drop(&mut self) {
        // A test that fails may have ended the node.
        let _ = self.0.run("images.unregister()");
    }
}

#[test]
fn a_rospy_viewer_that_takes_long_for_each_picture_costs_the_others_nothing() {
    let master = RosMaster::start().unwrap();
    let publisher = pictures(&master);
    let slow = PythonNode::start(&master, &["__name:=slow"]).unwrap();
    slow.run("def see(image):\n    times.append(time.monotonic())\n    time.sleep(0.3)").unwrap();
    assert_undisturbed(&master, &publisher, || {
        slow.run("times = []").unwrap();
        slow.run(format!("images = rospy.Subscriber('{TOPIC}', Image, see, queue_size=1, buff_size=1 << 24)")).unwrap();
        assert!(slow.wait_for(PATIENCE, "len(times) > 1"));
        Subscribed(&slow)
    });
    // It has watched all the while, and as slowly as it was to.
    let rate: f64 = slow.run("(len(times) - 1) / (times[-1] - times[0])").unwrap().parse().unwrap();
    println!("the slow one saw {rate:.1} pictures a second");
    assert!((1.0..3.4).contains(&rate), "{rate}");
}

/// How many pictures of so many bytes the kernel may hold whole for a viewer that does not read: they fill the buffer
/// of the viewer's side, which grows up to a limit of the system while the viewer reads much, and the node's (512 kB,
/// which Linux doubles).
fn held_by_kernel(picture_bytes: usize) -> usize {
    let limits = std::fs::read_to_string("/proc/sys/net/ipv4/tcp_rmem").unwrap();
    let longest: usize = limits.split_whitespace().last().unwrap().parse().unwrap();
    (longest + 2 * 512 * 1024) / picture_bytes
}

#[test]
fn a_stopped_viewer_is_never_cut_and_goes_on_with_the_newest_picture() {
    let master = RosMaster::start().unwrap();
    let _publisher = pictures(&master);
    let good = Viewer::start(subscribe(&master, "/probe", TOPIC, "/good"));
    // One that has watched for a while, and one that has not read a picture yet: its buffers are small.
    let mut watched = subscribe(&master, "/probe", TOPIC, "/watched");
    let bytes = (0..40).map(|_| read_framed(&mut watched).unwrap().len()).max().unwrap();
    let unwatched = subscribe(&master, "/probe", TOPIC, "/unwatched");
    let latest = || good.seen.lock().unwrap().last().unwrap().seq;
    let before = latest();
    let stopped_s = std::env::var(STOPPED_S).map_or(4, |secs| secs.parse().unwrap());
    std::thread::sleep(Duration::from_secs(stopped_s.into()));
    for (name, mut stopped, most) in [("unwatched", unwatched, 1), ("watched", watched, 1 + held_by_kernel(bytes))] {
        let newest = latest();
        assert!(newest > before + (stopped_s - 1) * RATE, "{before} {newest}");
        let begin = Instant::now();
        let old = std::iter::repeat_with(|| seq(&read_framed(&mut stopped).unwrap())).take_while(|seq| *seq < newest);
        // What the kernel had, of which the last one was being sent; then the one in the queue.
        let old: Vec<u32> = old.collect();
        let took = begin.elapsed();
        println!(
            "{name}, after {stopped_s} s: {} old pictures of at most {most}, a new one after {took:.0?}",
            old.len()
        );
        assert!(old.len() <= most, "{name}: {old:?} before {newest}");
        assert!(took < Duration::from_millis(500), "{name}: {took:?}");
    }
}

#[test]
fn a_viewer_that_leaves_is_noticed_at_once_and_gets_a_picture_at_once_when_it_returns() {
    let master = RosMaster::start().unwrap();
    let publisher = pictures(&master);
    for round in 0..3 {
        let name = format!("/viewer{round}");
        let mut viewer = subscribe(&master, "/probe", TOPIC, &name);
        assert!(publisher.line_with(&format!("subscriber {name}")).is_some());
        read_framed(&mut viewer).unwrap();
        assert!(publisher.prints_again("to 1 in", PATIENCE));
        drop(viewer);
        assert!(publisher.prints_again("to 0 in", Duration::from_millis(300)), "still there after 0.3 s");
    }
}

#[test]
fn fifty_viewers_are_served() {
    let master = RosMaster::start().unwrap();
    let publisher = probe(&master, &["image", TOPIC, "320", "200", &RATE.to_string()]);
    assert!(publisher.line_with("ready").is_some());
    let viewers: Vec<Viewer> =
        (0..50).map(|index| Viewer::start(subscribe(&master, "/probe", TOPIC, &format!("/viewer{index}")))).collect();
    assert!(publisher.prints_again("to 50 in", PATIENCE));
    let all_are_served = (0..ROUNDS).any(|_| {
        let begin = Instant::now();
        std::thread::sleep(Duration::from_secs(3));
        let measured: Vec<Measured> = viewers.iter().map(|viewer| viewer.since(begin)).collect();
        let pictures = measured.iter().map(|one| one.pictures).min().unwrap_or_default();
        let gap = measured.iter().map(|one| one.longest_gap).max().unwrap_or_default();
        let latency = measured.iter().map(|one| one.median_latency).max().unwrap_or_default();
        println!("3 s: {pictures} pictures and more each, longest gap {gap:.1?}, median latency up to {latency:.1?}");
        pictures * 100 >= 3 * RATE as usize * 95 && gap < LONGEST_GAP
    });
    assert!(all_are_served);
}
