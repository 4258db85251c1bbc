//! Golden cases for tests that run programs on them: a bag of `tests/golden/cases`, and the config that it begins with.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use rcs_bag::Bag;
use rcs_messages::std_msgs;

use crate::programs::repository;

/// The topic of the config, a std_msgs/String, in the bags.
pub const CONFIG_TOPIC: &str = "/rviz_config";

/// Files of a golden case, as programs are given them.
#[derive(Debug, Clone)]
pub struct GoldenCase {
    /// The config, in the folder that [`GoldenCase::new`] was given.
    pub config: PathBuf,
    /// The bag.
    pub bag: PathBuf,
}

impl GoldenCase {
    /// The case of this name, whose config is written into `folder`.
    ///
    /// # Errors
    /// When the bag cannot be read or the config cannot be written.
    pub fn new(name: &str, folder: &Path) -> anyhow::Result<Self> {
        let bag = repository().join(format!("tests/golden/cases/{name}.bag"));
        let config = folder.join(format!("{name}.rviz"));
        fs::write(&config, config_in(&bag)?).with_context(|| config.display().to_string())?;
        Ok(Self { config, bag })
    }
}

/// The text of the config in a bag.
///
/// # Errors
/// When the bag cannot be read or has none.
pub fn config_in(bag: &Path) -> anyhow::Result<String> {
    let open = Bag::open(bag)?;
    let mut configs = open.messages(|connection| &*connection.topic == CONFIG_TOPIC);
    let config = configs.next().with_context(|| format!("{} has no {CONFIG_TOPIC}", bag.display()))??;
    Ok(rcs_messages::decode::<std_msgs::String>(&config.bytes)?.data)
}
