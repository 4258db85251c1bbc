//! Prints the problems found in captures whose images are in order, and in those where one is another's.
//! `cargo run --release -p rcs_tests --example image_order still|lapses|moved FOLDER|SEED|FIRST..END...`

use std::path::Path;

use anyhow::{bail, Result};
use rcs_scan_simulator::{Conditions, Motion};
use rcs_tests::captures::KnownCapture;

/// Motions in the middle of a scan, camera pixels.
const SHIFTS: [[f64; 2]; 4] = [[0.6, 0.3], [1.0, 0.0], [-0.2, 2.5], [6.0, -4.0]];

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let what = arguments.next().unwrap_or_default();
    for name in arguments {
        let seeds =
            name.split_once("..").map(|(first, end)| Ok::<_, anyhow::Error>(first.parse()?..end.parse::<u64>()?));
        let captures: Box<dyn Iterator<Item = Result<(String, KnownCapture)>>> = match (seeds, name.parse()) {
            (Some(seeds), _) => Box::new(seeds?.map(|seed| Ok((seed.to_string(), KnownCapture::simulated(seed))))),
            (None, Ok(seed)) => Box::new(std::iter::once(Ok((name, KnownCapture::simulated(seed))))),
            _ => Box::new(std::iter::once(KnownCapture::read(Path::new(&name)).map(|capture| (name, capture)))),
        };
        for capture in captures {
            let (name, capture) = capture?;
            match what.as_str() {
                "still" => show(&capture, &name, &capture.in_order())?,
                "lapses" => {
                    for (lapse, _, order) in capture.lapses() {
                        show(&capture, &format!("{name}: {lapse}"), &order)?;
                    }
                }
                "moved" => {
                    let seed: u64 = name.parse()?;
                    for (from_image, shift) in [4, 14, 20, 31, 38].into_iter().flat_map(|at| SHIFTS.map(|by| (at, by)))
                    {
                        let motion = Some(Motion { from_image, shift_px: shift.into() });
                        let conditions = Conditions { motion, ..Conditions::random(seed) };
                        let capture = KnownCapture::simulated_under(seed, conditions);
                        show(&capture, &format!("{name}: {shift:?} from {from_image}"), &capture.in_order())?;
                    }
                }
                _ => bail!("still, lapses or moved"),
            }
        }
    }
    Ok(())
}

fn show(capture: &KnownCapture, name: &str, order: &[usize]) -> Result<()> {
    let decoded = capture.decode(order)?;
    let shares = capture.shares(&decoded);
    let problems: Vec<String> = (decoded.quality.problems().into_iter())
        .map(|problem| format!("{}{problem}", if problem.is_fatal() { "refused: " } else { "" }))
        .collect();
    let quality = decoded.quality;
    println!(
        "{name}: decoded {:.3}, wrong {:.4}, moved {:.2}, exposure {:.3}, clipped {:.3}, contradicted {:.3}; {problems:?}",
        shares.decoded, shares.wrong, quality.moved_px, quality.exposure_change, quality.clipped, quality.contradicted
    );
    Ok(())
}
