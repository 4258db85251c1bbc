//! A node for tests: it prints what it receives, one line an event, and publishes images.
//!
//! ```text
//! ros_probe listen [TOPIC TYPE QUEUE_SIZE]...      messages, transforms, calls of the service `probe_trigger`
//! ros_probe image TOPIC WIDTH HEIGHT RATE          images, while it listens to their own camera_info
//! ros_probe call SERVICE TIMEOUT                   one call of a std_srvs/Trigger
//! ros_probe nudge INFO_TOPIC ORIENTATION RIGHT DOWN FORWARD    one step of a projector
//! ```
//!
//! SIGTERM and SIGINT unregister and end it.

use rcs_camera_stream::nudge::{nudge, projector};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_srvs::{Trigger, TriggerReq};
use rcs_messages::{header, MessageKind};
use rcs_ros::{Change, NodeEvent, RosNode, ServiceCall, TopicSubscription};
use rcs_scene::{Encoding, Image};
use std::error::Error;
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn Error>> {
    log::set_logger(&StandardError)?;
    log::set_max_level(log::LevelFilter::Info);
    let ended = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGTERM, signal_hook::consts::SIGINT] {
        signal_hook::flag::register(signal, Arc::clone(&ended))?;
    }
    let is_ended = || ended.load(Ordering::Relaxed);
    let node = Arc::new(RosNode::connect("probe", &is_ended)?);
    let args: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.contains(":=")).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args.as_slice() {
        ["listen", topics @ ..] => listen(&node, topics, &is_ended)?,
        ["image", topic, width, height, rate] => {
            publish(&node, topic, [width.parse()?, height.parse()?], rate.parse()?, &is_ended)?;
        }
        ["call", service, timeout] => {
            let timeout = Duration::from_secs_f64(timeout.parse()?);
            match node.call::<Trigger>(service, &TriggerReq {}, timeout) {
                Ok(answer) => print_line(&format!("answer {} {}", answer.success, answer.message)),
                Err(error) => print_line(&format!("error {error}")),
            }
        }
        ["nudge", topic, orientation, right, down, forward] => {
            let step = [right.parse()?, down.parse()?, forward.parse()?, 0.0, 0.0, 0.0];
            let orientation = orientation.parse()?;
            let nudged = projector(&node, topic)
                .and_then(|mut projector| nudge(&node, &mut projector, orientation, &step).map(|()| projector));
            match nudged {
                Ok(projector) => print_line(&format!("nudged {} {:?}", projector.node, projector.nudge.0)),
                Err(error) => print_line(&format!("error {error}")),
            }
        }
        _ => return Err("usage: ros_probe listen|image|call|nudge ...".into()),
    }
    node.shutdown();
    print_line("ended");
    Ok(())
}

fn listen(node: &RosNode, topics: &[&str], is_ended: &dyn Fn() -> bool) -> Result<(), Box<dyn Error>> {
    node.subscribe_transforms()?;
    node.serve_trigger("probe_trigger")?;
    node.serve_set_bool("probe_switch")?;
    let subscriptions = topics.chunks_exact(3).map(|topic| subscribe(node, topic)).collect::<Result<Vec<_>, _>>()?;
    for subscription in &subscriptions {
        print_line(&format!("subscribed {}", subscription.topic()));
    }
    print_line(&format!("ready {} simulated {}", node.name(), node.is_simulated()));
    let mut publications = None;
    while !is_ended() && !node.is_asked_to_end() {
        for event in node.events().wait(Duration::from_millis(50)) {
            print_event(event);
        }
        for call in node.calls().drain() {
            answer(node, call);
        }
        // Each time that the master was asked gives another list.
        let latest = node.publications();
        if latest.as_ref().map(Arc::as_ptr) != publications.as_ref().map(Arc::as_ptr) {
            print_line("publications known");
            publications = latest;
        }
    }
    Ok(())
}

fn subscribe(node: &RosNode, topic: &[&str]) -> Result<TopicSubscription, Box<dyn Error>> {
    let [topic, kind, queue_size] = topic else {
        return Err("usage: TOPIC TYPE QUEUE_SIZE".into());
    };
    let kind = MessageKind::from_ros_type(kind).ok_or("unknown type")?;
    Ok(node.subscribe(topic, kind, queue_size.parse()?)?)
}

fn print_event(event: NodeEvent) {
    match event {
        NodeEvent::Message { topic, message, publisher, .. } => {
            let header = header(&message).cloned().unwrap_or_default();
            print_line(&format!(
                "message {topic} {} from {publisher} seq {} frame {} stamp {} bytes {}",
                message.kind().ros_type(),
                header.seq,
                header.frame_id,
                header.stamp.nanos(),
                message.encode().len()
            ));
        }
        NodeEvent::Transforms { message, is_static, authority, .. } => {
            for transform in &message.transforms {
                let (parent, child) = (&transform.header.frame_id, &transform.child_frame_id);
                print_line(&format!("transform {parent} {child} static {is_static} from {authority}"));
            }
        }
        NodeEvent::TimeJumpedBack { from, to } => print_line(&format!("jump from {} to {}", from.sec, to.sec)),
        NodeEvent::Parameter { name, text } => {
            print_line(&format!("parameter {name} {}", text.as_deref().unwrap_or("-")));
        }
        NodeEvent::PublisherLeft { topic } => print_line(&format!("left {topic}")),
    }
}

fn answer(node: &RosNode, call: ServiceCall) {
    match call {
        ServiceCall::Trigger { service, reply, .. } => {
            print_line(&format!("trigger {service} at {}", node.now().sec));
            reply.send(true, format!("received by {}", node.name()));
        }
        ServiceCall::SetBool { service, value, caller, reply } => {
            print_line(&format!("set {service} {value} by {caller}"));
            reply.send(true, format!("received by {}", node.name()));
        }
        // It has no such server or service.
        ServiceCall::Reconfigure { .. } | ServiceCall::FilePath { .. } => {}
    }
}

fn publish(
    node: &RosNode,
    topic: &str,
    size_px: [u32; 2],
    rate: f64,
    is_ended: &dyn Fn() -> bool,
) -> Result<(), Box<dyn Error>> {
    let on_change = |change, name: &str| {
        if change == Change::Joined {
            print_line(&format!("subscriber {name}"));
        }
    };
    let mut publisher = node.image_publisher(topic, on_change)?;
    let _own = node.subscribe(publisher.info_topic(), MessageKind::CameraInfo, 1)?;
    print_line(&format!("ready {} image {} info {}", node.name(), publisher.topic(), publisher.info_topic()));
    let [width, height] = size_px;
    let mut image = Image::default();
    image.reset(width, height, Encoding::Rgb8);
    image.data.fill(7);
    let image = Arc::new(image);
    let mut info = CameraInfo { width, height, ..CameraInfo::default() };
    info.header.frame_id = "projector".to_owned();
    let mut next = Instant::now();
    let mut count = 0;
    while !is_ended() {
        for event in node.events().wait(next.saturating_duration_since(Instant::now())) {
            print_event(event);
        }
        if Instant::now() < next {
            continue;
        }
        next += Duration::from_secs_f64(1.0 / rate);
        let started = Instant::now();
        publisher.publish(&image, &info, node.now())?;
        count += 1;
        let (subscribers, micros) = (publisher.subscriber_count(), started.elapsed().as_micros());
        print_line(&format!("published {count} to {subscribers} in {micros} us"));
    }
    Ok(())
}

/// Prints a line and flushes it.
fn print_line(line: &str) {
    let mut out = std::io::stdout().lock();
    // The pipe is closed once the test is over.
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

struct StandardError;

impl log::Log for StandardError {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        if record.level() <= log::Level::Info {
            eprintln!("{} {}", record.level(), record.args());
        }
    }

    fn flush(&self) {}
}
