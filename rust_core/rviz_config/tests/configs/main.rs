//! Whole `.rviz` files: what each section and display class is read into, and what is reported.

mod displays;
mod files;
mod rules;
mod versions;

use rcs_rviz_config::{parse, Config, DisplaySettings};

/// The config whose only display has these keys.
fn with_display(class: &str, keys: &str) -> Config {
    let mut text =
        format!("Visualization Manager:\n  Displays:\n    - Class: {class}\n      Name: it\n      Enabled: true\n");
    for line in keys.lines() {
        text += &format!("      {line}\n");
    }
    parse(&text, "test.rviz").unwrap_or_else(|error| panic!("{error}"))
}

/// The line of the first of `with_display`'s keys.
const FIRST_LINE: usize = 6;

fn settings(config: &Config) -> &DisplaySettings {
    &config.displays[0].settings
}

fn messages(config: &Config) -> Vec<String> {
    config.findings.iter().map(ToString::to_string).collect()
}
