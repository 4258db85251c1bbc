//! Shows a test pattern full screen, as `projector_window` shows an image topic.
//!
//! `window_pattern WIDTHxHEIGHT [--monitor NAME|INDEX] [--screenshot FILE.png] [--limit SECONDS] [--set-mode yes]
//! [--guarded yes] [--identify SECONDS] [--keep TITLE]`: pixel (u, v) of the pattern has red u % 256, green v %
//! 256 and in blue 16 * (u / 256) + v / 256, so that no two pixels within 4096x4096 look the same. The same image is
//! shown again half a second later; with a limit, it is granted for that long. Keys and the monitor are logged. B is
//! black, Escape or q quit.

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use log::LevelFilter;
use rcs_light::{Content, Evidence, Generation, LightRules};
use rcs_window::{self as window, ImageSink, ScreenImage, UserEvent, WindowKey, WindowOptions, WindowRole};

fn pattern(width_px: u32, height_px: u32) -> ScreenImage {
    ScreenImage::from_fn(width_px, height_px, |u, v| {
        let blue = 16 * (u / 256) + v / 256;
        [(u % 256) as u8, (v % 256) as u8, (blue % 256) as u8]
    })
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    if let Some(status) = window::run_black_window() {
        return Ok(status);
    }
    run()?;
    Ok(ExitCode::SUCCESS)
}

/// Shows the pattern, granted for the limit if there is one.
fn show_pattern(sink: &ImageSink, size_px: [u32; 2], limit: Option<Duration>) {
    let image = pattern(size_px[0], size_px[1]);
    let Some(limit) = limit else { return sink.show(image) };
    let evidence = Evidence::unknown(&[], LightRules::none(limit), Arc::default());
    let grant = evidence.decide(Content::Scene, size_px, Ok(Generation::default()), Instant::now());
    let lit = grant.ok().and_then(|grant| grant.show(Arc::new(image)));
    lit.into_iter().for_each(|lit| sink.show_lit(lit));
}

fn run() -> Result<(), Box<dyn Error>> {
    let mut logger = env_logger::Builder::new();
    logger.filter_module("rcs_", LevelFilter::Info).filter_module("window_pattern", LevelFilter::Info);
    logger.format(|out, record| writeln!(out, "{}: {}", record.level(), record.args())).try_init()?;
    let mut arguments = std::env::args().skip(1);
    let size = arguments.next().ok_or("usage: window_pattern WIDTHxHEIGHT")?;
    let (width, height) = size.split_once('x').ok_or("the size is WIDTHxHEIGHT")?;
    let (width, height): (u32, u32) = (width.parse()?, height.parse()?);
    let mut options = WindowOptions { source: "the test pattern".to_owned(), ..WindowOptions::default() };
    let (mut identify, mut keep) = (None, None);
    while let Some(flag) = arguments.next() {
        let value = arguments.next().ok_or("each option takes a value")?;
        match flag.as_str() {
            "--monitor" => options.monitor = value.parse()?,
            "--screenshot" => options.screenshot = Some(value.into()),
            "--limit" => options.light_limit = Some(Duration::from_secs_f64(value.parse()?)),
            "--set-mode" => options.set_mode = true,
            "--guarded" => options.role = WindowRole::Guarded,
            "--keep" => keep = Some(value),
            "--identify" => identify = Some(Duration::from_secs_f64(value.parse()?)),
            _ => return Err(format!("unknown option {flag}").into()),
        }
    }
    if let Some(duration) = identify {
        return Ok(window::identify(duration, || false)?);
    }
    if let Some(title) = keep {
        return Ok(window::keep_over(&title, &options.monitor, || false)?);
    }
    let limit = options.light_limit;
    let show_once = move |sink: &ImageSink| show_pattern(sink, [width, height], limit);
    let show = move |sink: ImageSink| {
        thread::spawn(move || {
            show_once(&sink);
            thread::sleep(Duration::from_millis(500));
            show_once(&sink);
            log::info!("this was the second picture");
            log::info!("refreshed every {:?}", sink.refresh().map(|refresh| refresh.period()));
        });
    };
    window::run_interactive(&options, move |event, sink| match event {
        UserEvent::Opened(monitor) => {
            log::info!("opened on {monitor}");
            show(sink.clone());
        }
        UserEvent::MonitorChanged(monitor) => log::info!("now on {monitor}"),
        UserEvent::Key { key, is_repeat } => {
            log::info!("key {key:?}{}", if is_repeat { " again" } else { "" });
            if key == WindowKey::Character('b') {
                sink.clear();
            }
        }
    })?;
    Ok(())
}
