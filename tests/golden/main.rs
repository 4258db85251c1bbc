//! Golden tests: what rviz drew, drawn again by both renderers.
//!
//! Each case is a bag with a config and messages, and the image that rviz 1.14.19 with its CameraPub plugin published
//! for them; `tests/golden/README.md` describes them. The images of the gallery in `docs` are tested with them.
//!
//! ```text
//! cargo test --release -p rcs_tests --test golden                              all cases, both renderers, the gallery
//! cargo test --release -p rcs_tests --test golden -- cpu::                     all cases on the CPU
//! cargo test --release -p rcs_tests --test golden -- marker_text               all tests with this text in their names
//! cargo test --release -p rcs_tests --test golden -- --exact gpu::pc2_points_1px      one case on the GPU
//! cargo test --release -p rcs_tests --test golden -- --list                    their names
//! GOLDEN_OUTPUT=DIR cargo test ...                                             keeps every rendered image in DIR
//! UPDATE_GALLERY=1 cargo test ... -- gallery::                                 writes the gallery's images again
//! ```
//!
//! A failing case leaves `expected | difference | actual` in `test_output/golden/RENDERER/NAME_difference.png`.

mod cases;
mod gallery;
mod score;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use libtest_mimic::{Arguments, Failed, Trial};
use rcs_camera::Projection;
use rcs_camera_stream::offline::{self, BagSection, RenderJob, RenderTarget};
use rcs_camera_stream::scene::SceneState;
use rcs_process::lock;
use rcs_render::{Renderer, RendererChoice};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_tests::golden::config_in;

use cases::Case;
use score::Rgb;

/// The lowest mean *close* score of all cases that passes, on each renderer.
const MIN_MEAN_CLOSE: f64 = 0.995;

type SharedRenderer = Arc<Mutex<Box<dyn Renderer>>>;
type Scores = Arc<Mutex<Vec<(String, f64, f64)>>>;

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::from_args();
    let cases = cases::all()?;
    let mut trials = vec![
        Trial::test("cases::names_and_descriptions", {
            let cases = cases.clone();
            move || check_descriptions(&cases)
        }),
        Trial::test("cases::low_tolerances_need_a_reason_and_unknown_fields_are_errors", check_parsing),
    ];
    let mut all_scores = Vec::new();
    for (name, choice) in [("cpu", RendererChoice::Cpu), ("gpu", RendererChoice::Gpu)] {
        match rcs_render::create(choice) {
            Ok(renderer) => {
                let renderer: SharedRenderer = Arc::new(Mutex::new(renderer));
                let scores: Scores = Arc::default();
                all_scores.push((name, scores.clone()));
                for case in &cases {
                    let (renderer, scores, case) = (renderer.clone(), scores.clone(), case.clone());
                    trials.push(Trial::test(format!("{name}::{}", case.name), move || {
                        test(&case, name, &renderer, &scores)
                    }));
                }
                if choice == RendererChoice::Cpu {
                    trials.extend(gallery::trials(&cases, &renderer));
                }
            }
            Err(error) => {
                let message = format!("no {name} renderer: {error}");
                trials.push(Trial::test(format!("{name}::renderer"), move || Err(Failed::from(message))));
            }
        }
    }
    let conclusion = libtest_mimic::run(&arguments, trials);
    let mut failed = conclusion.has_failed();
    for (name, scores) in all_scores {
        failed |= !report(name, &lock(&scores), cases.len());
    }
    std::process::exit(i32::from(failed));
}

/// Fails with the names of all cases whose name or description does not explain them.
fn check_descriptions(cases: &[Case]) -> Result<(), Failed> {
    let errors = cases.iter().filter_map(|case| cases::check_description(case).err());
    let errors: Vec<String> = errors.map(|error| error.to_string()).collect();
    if errors.is_empty() {
        Ok(())
    } else {
        Err(errors.join("\n").into())
    }
}

/// Fails unless a tolerance is read with its reason, and refused without one or misspelt.
fn check_parsing() -> Result<(), Failed> {
    let parse = |fields: &str| cases::parse(&format!("marker_text: {{{fields}}}\n"), Path::new("cases"));
    let is_error = |fields: &str, word: &str| parse(fields).is_err_and(|error| format!("{error:#}").contains(word));
    let min_close = |fields: &str| parse(fields).ok().map(|cases| cases[0].min_close);
    let expectations = [
        ("usual", min_close("about: a") == Some(0.98)),
        ("given", min_close("about: a, min_close: 0.9, why: glyphs") == Some(0.9)),
        ("no reason", is_error("about: a, min_close: 0.9", "why")),
        ("not a share", is_error("about: a, min_close: 98, why: percent", "98")),
        ("misspelt", is_error("about: a, min_closs: 0.9", "min_closs")),
        ("twice", is_error("about: a, about: b", "about")),
        ("list", is_error("about: [a]", "line 1")),
    ];
    let wrong: Vec<&str> = expectations.iter().filter(|(_, holds)| !holds).map(|(what, _)| *what).collect();
    if wrong.is_empty() {
        Ok(())
    } else {
        Err(format!("not as expected: {}", wrong.join(", ")).into())
    }
}

/// Prints the scores' means. Returns whether the mean *close* is high enough, which it is taken to be unless all cases
/// ran.
fn report(renderer: &str, scores: &[(String, f64, f64)], case_count: usize) -> bool {
    let mean = |of: fn(&(String, f64, f64)) -> f64| scores.iter().map(of).sum::<f64>() / scores.len().max(1) as f64;
    let (strict, close) = (mean(|score| score.1), mean(|score| score.2));
    let worst = scores.iter().min_by(|a, b| a.2.total_cmp(&b.2));
    if let Some((name, _, worst)) = worst {
        println!(
            "{renderer}: {} cases, mean strict {strict:.4}, mean close {close:.4}, worst close {worst:.4} ({name})",
            scores.len()
        );
    }
    let enough = scores.len() < case_count || close >= MIN_MEAN_CLOSE;
    if !enough {
        println!("{renderer}: the mean close is below {MIN_MEAN_CLOSE}");
    }
    enough
}

fn test(case: &Case, renderer_name: &str, renderer: &SharedRenderer, scores: &Scores) -> Result<(), Failed> {
    let output = std::env::var_os("GOLDEN_OUTPUT")
        .map_or_else(|| cases::repository().join("test_output/golden"), PathBuf::from)
        .join(renderer_name);
    std::fs::create_dir_all(&output)?;
    let file = output.join(format!("{}.png", case.name));
    render(case, &file, renderer).map_err(|error| format!("{error:#}"))?;
    let (expected, actual) = (load(&case.image)?, load(&file)?);
    let Some(score) = score::score(&expected, &actual) else {
        return Err(format!(
            "{} by {} pixels, expected {} by {}",
            actual.width, actual.height, expected.width, expected.height
        )
        .into());
    };
    lock(scores).push((case.name.clone(), score.strict, score.close));
    if score.close < case.min_close {
        let comparison = output.join(format!("{}_difference.png", case.name));
        save(&comparison, &score::comparison(&expected, &actual, &score))?;
        return Err(format!(
            "strict {:.4}, close {:.4}, below {}; see {}",
            score.strict,
            score.close,
            case.min_close,
            comparison.display()
        )
        .into());
    }
    if std::env::var_os("GOLDEN_OUTPUT").is_none() {
        std::fs::remove_file(&file)?;
    }
    Ok(())
}

fn render(case: &Case, file: &Path, renderer: &SharedRenderer) -> anyhow::Result<()> {
    let config = rcs_rviz_config::parse(&config_in(&case.bag)?, &case.name)?;
    let meshes = MeshStore::new(PackageIndex::new([cases::golden()]));
    let parameters = offline::read_parameters(&case.params, meshes.packages())?;
    let mut stage = SceneState::new(&config, None, meshes);
    offline::set_parameters(&mut stage, &parameters);
    let target = RenderTarget::Image { file: file.to_owned() };
    let mut renderer = lock(renderer);
    let (camera, section, model) = (case.camera.as_deref(), BagSection::default(), Projection::Rviz.into());
    let (bags, remappings, orientations) = ([case.bag.clone()], HashMap::new(), Vec::new());
    let job = RenderJob {
        bags: &bags,
        remappings: &remappings,
        camera,
        projector: None,
        section,
        target: &target,
        model,
        orientations,
    };
    offline::render(&mut stage, &job, renderer.as_mut())
}

fn load(file: &Path) -> Result<Rgb, Failed> {
    let image = image::open(file).map_err(|error| format!("{}: {error}", file.display()))?;
    // A 16-bit grey becomes 8 bits: the scorer's levels are of 255.
    let image = image.to_rgb8();
    let pixels = image.pixels().map(|pixel| pixel.0).collect();
    Ok(Rgb { width: image.width() as usize, height: image.height() as usize, pixels })
}

fn save(file: &Path, image: &Rgb) -> Result<(), Failed> {
    let bytes = image.pixels.as_flattened();
    image::save_buffer(file, bytes, image.width as u32, image.height as u32, image::ExtendedColorType::Rgb8)
        .map_err(|error| format!("{}: {error}", file.display()).into())
}
