//! The displays of a config: from a message to the scene, without ROS and without a clock.

use rcs_displays::SceneState;
use rcs_messages::AnyMessage;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_scene::Scene;
use rcs_transforms::Time;

/// The displays and the last scene.
#[derive(Debug)]
pub struct DisplayPipeline {
    displays: SceneState,
    now_nanos: i64,
    /// The scene after the last message.
    pub scene: Scene,
}

impl DisplayPipeline {
    /// The displays of these lines of a config, whose fixed frame is `map`.
    ///
    /// # Panics
    /// When they are not a valid config.
    #[expect(clippy::expect_used, reason = "the config is the test's own")]
    pub fn new(displays: &str) -> Self {
        let text = format!("Visualization Manager:\n  Displays:\n{displays}  Global Options: {{Fixed Frame: map}}\n");
        let config = rcs_rviz_config::parse(&text, "scene").expect("the config can be read");
        Self {
            displays: SceneState::new(&config, None, MeshStore::new(PackageIndex::new([]))),
            now_nanos: 1_000_000_000,
            scene: Scene::default(),
        }
    }

    /// Takes a message of a topic and updates the scene, a thirtieth of a second later than before.
    pub fn receive(&mut self, topic: &str, message: &AnyMessage) -> &Scene {
        self.step(Some((topic, message)))
    }

    /// Updates the scene a thirtieth of a second later, without a message.
    pub fn advance(&mut self) -> &Scene {
        self.step(None)
    }

    fn step(&mut self, received: Option<(&str, &AnyMessage)>) -> &Scene {
        self.now_nanos += 33_333_333;
        let now = Time::from_nanos(self.now_nanos);
        if let Some((topic, message)) = received {
            self.displays.take(topic, message, now);
        }
        if self.displays.update(now) {
            self.scene = self.displays.scene();
        }
        &self.scene
    }
}
