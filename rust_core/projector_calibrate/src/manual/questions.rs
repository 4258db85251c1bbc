//! The dialog that asks for the measures on the terminal. It repeats a question after an unusable answer, and those of
//! a distance whose measures contradict each other.

use std::io::{self, BufRead, Write};
use std::path::{Path, PathBuf};

use anyhow::{anyhow, Context as _};
use rcs_calibration::manual::{solve, ManualMeasures, WallMeasures};
use rcs_node_support::dialog::{end_on_signals, Dialog, MAX_ATTEMPTS};

use crate::arguments::{length_m, size_px, two_lengths_m};
use crate::Failure;

const INTRODUCTION: &str = "\
Put the projector before a flat wall, its optical axis at right angles to it. Switch keystone correction off, show a
picture in the projector's own resolution (projector_calibrate show --test border), and leave zoom and focus alone from
now on. Measure in metres, or write the unit (90cm, 900mm).

  from the side                    the wall, seen from the projector

                |  picture         |<----------- W ----------->|
              / |                --+---------------------------+--
            /   |                ^ |                           | ^
          /     |                | |                           | H
        /       |                Y |                           | v
      /         |                | +---------------------------+--
  [O]-----------+  optical axis  v |
                |                --|- - - - - - -*  where the axis meets the wall: at the lens' height,
   |<--- Z ---->|                  |<---- X ---->|  here below the picture (Y greater than H)
  lens        wall
";
const SECOND: &str = "
With a second distance it does not matter where in the projector the light comes from. Move the projector straight back
or forth, by as much as there is room, and measure everything again, the distance from the same place of the projector.
";

/// Asks on the terminal for measures that determine a lens, and for the file to write unless `output` names it.
#[expect(clippy::disallowed_methods, reason = "a signal ends the program while it waits for an answer")]
pub(super) fn ask_user(tape_error_m: f64, output: Option<&Path>) -> Result<(ManualMeasures, PathBuf), Failure> {
    end_on_signals("projector_calibrate", || {}).context("cannot handle signals").map_err(Failure::Refused)?;
    ask(&mut io::stdin().lock(), &mut io::stderr(), tape_error_m, output)
}

/// Asks until the measures determine a lens.
fn ask(
    input: &mut impl BufRead,
    terminal: &mut impl Write,
    tape_error_m: f64,
    output: Option<&Path>,
) -> Result<(ManualMeasures, PathBuf), Failure> {
    let mut dialog = Dialog::new(input, terminal);
    dialog.say(INTRODUCTION)?;
    let size_px = dialog.answer("Width and height of the picture in pixels, such as 1280x800: ", size_px)?;
    let measures = |first, second| ManualMeasures { size_px, first, second, tape_error_m };
    let first = wall(&mut dialog, &|wall| solve(&measures(wall, None)).map(drop))?;
    dialog.say(SECOND)?;
    let second = if dialog.agrees("Measure at a second distance? [Y/n] ", true)? {
        Some(wall(&mut dialog, &|wall| solve(&measures(first, Some(wall))).map(drop))?)
    } else {
        None
    };
    let output = match output {
        Some(path) => path.to_owned(),
        None => file(&mut dialog)?,
    };
    Ok((measures(first, second), output))
}

/// Asks for the measures at one distance until `check` accepts them.
fn wall<E: std::fmt::Display>(
    dialog: &mut Dialog<'_>,
    check: &dyn Fn(WallMeasures) -> Result<(), E>,
) -> Result<WallMeasures, Failure> {
    for _ in 0..MAX_ATTEMPTS {
        let distance_m = dialog.answer("Distance from the lens to the wall, Z: ", |text| positive(length_m(text)?))?;
        let image_m = dialog.answer("Width and height of the picture on the wall, W x H: ", |text| {
            let [width, height] = two_lengths_m(text)?;
            Ok([positive(width)?, positive(height)?])
        })?;
        let axis_m = dialog.answer("Where the optical axis meets the wall, X, Y: ", |text| {
            let place = two_lengths_m(text)?;
            place.iter().all(|length| length.is_finite()).then_some(place).ok_or_else(not_finite)
        })?;
        let wall = WallMeasures { distance_m, image_m, axis_m: Some(axis_m) };
        match check(wall) {
            Ok(()) => return Ok(wall),
            Err(error) => dialog.say(&format!("  {error}: measure this distance again"))?,
        }
    }
    Err(Failure::Unreadable(anyhow!("no usable measures")))
}

/// Asks for the file to write.
fn file(dialog: &mut Dialog<'_>) -> Result<PathBuf, Failure> {
    loop {
        let path = dialog.answer("File to write [projector.yaml]: ", |text| match text {
            "" => Ok(PathBuf::from("projector.yaml")),
            _ if Path::new(text).is_dir() => Err(format!("{text} is a folder")),
            _ => Ok(PathBuf::from(text)),
        })?;
        if !path.exists() || dialog.agrees(&format!("{} exists. Replace it? [y/N] ", path.display()), false)? {
            return Ok(path);
        }
    }
}

fn positive(length_m: f64) -> Result<f64, String> {
    if !length_m.is_finite() {
        Err(not_finite())
    } else if length_m <= 0.0 {
        Err("it must be greater than zero".to_owned())
    } else {
        Ok(length_m)
    }
}

fn not_finite() -> String {
    "not a finite number".to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(lines: &[&str]) -> (Result<(ManualMeasures, PathBuf), Failure>, String) {
        let (input, mut shown) = (lines.join("\n") + "\n", Vec::new());
        let result = ask(&mut input.as_bytes(), &mut shown, 0.001, Some(Path::new("out.yaml")));
        (result, String::from_utf8(shown).unwrap())
    }

    #[test]
    fn each_measure_is_asked_for() {
        let lines = ["1280x800", "1.2", "0.9x0.56", "45cm,60cm", "", "2.4", "1.83x1.14", "0.915,1.22"];
        let (result, shown) = answers(&lines);
        let (measures, output) = result.unwrap();
        assert_eq!(measures.size_px, [1280, 800]);
        assert_eq!(measures.first.axis_m, Some([0.45, 0.6]));
        assert_eq!(measures.second.unwrap().image_m, [1.83, 1.14]);
        assert_eq!(output, PathBuf::from("out.yaml"));
        assert!(shown.starts_with(INTRODUCTION) && shown.contains(SECOND), "{shown}");
    }

    #[test]
    fn what_cannot_be_used_is_asked_for_again() {
        let lines = ["wide", "1280x800", "-1", "nan", "1.2", "0.9", "0.9x0.56", "0.45,inf", "0.45,0.6", "maybe", "n"];
        let (result, shown) = answers(&lines);
        assert_eq!(result.unwrap().0.first.image_m, [0.9, 0.56]);
        for reason in ["not a size", "greater than zero", "not a finite number", "not two lengths", "answer y or n"] {
            assert!(shown.contains(reason), "{reason}: {shown}");
        }
    }

    #[test]
    fn a_second_distance_that_contradicts_the_first_is_asked_for_again() {
        let first = ["1280x800", "1.2", "0.9x0.56", "0.45,0.6", "y"];
        let lines = [&first[..], &["2.4", "0.8x0.5", "0.4,0.5", "2.4", "1.8x1.12", "0.9,1.2"]].concat();
        let (result, shown) = answers(&lines);
        assert_eq!(result.unwrap().0.second.unwrap().distance_m, 2.4);
        assert!(shown.contains("a picture grows with the distance: measure this distance again"), "{shown}");
    }

    #[test]
    fn the_end_of_the_input_ends_the_questions_and_so_do_endless_answers() {
        for count in 0..4 {
            let (result, _) = answers(&["1280x800", "1.2", "0.9x0.56"][..count]);
            assert!(matches!(result, Err(Failure::Refused(_))), "{result:?}");
        }
        let mut endless = io::BufReader::new(io::repeat(b'7'));
        let result = ask(&mut endless, &mut Vec::new(), 0.001, None);
        assert!(matches!(result, Err(Failure::Unreadable(_))), "{result:?}");
    }
}
