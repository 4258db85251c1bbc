//! A scene, the camera that sees it, and the renderer that draws it.
//!
//! `RCS_RENDERER` chooses the renderer: `cpu` (the default), `gpu` or `auto`.

use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use rcs_camera::CameraModel;
use rcs_camera_stream::scene::{self, SceneState};
use rcs_messages::{sensor_msgs::CameraInfo, AnyMessage};
use rcs_render::{create, Renderer, RendererChoice, View};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_scene::{Camera, CameraError, DisplayMask, Drawable, Encoding, Image, Intrinsics, Scene};
use rcs_transforms::Time;

/// Color of the background; no color of the scenes has this level in all channels.
const BACKGROUND: [u8; 3] = [LEVEL; 3];
const LEVEL: u8 = 3;

/// Why there is no renderer.
#[derive(Debug)]
pub struct RenderingError(String);

impl std::fmt::Display for RenderingError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for RenderingError {}

/// The renderer that `RCS_RENDERER` names.
///
/// # Errors
/// One line about what is wrong with the name or the GPU.
pub fn renderer() -> Result<Box<dyn Renderer>, RenderingError> {
    let name = std::env::var("RCS_RENDERER").unwrap_or_else(|_| "cpu".to_owned());
    let choice = name.parse::<RendererChoice>().map_err(|error| RenderingError(format!("RCS_RENDERER: {error}")))?;
    create(choice).map_err(|error| RenderingError(format!("RCS_RENDERER={name}: {error}")))
}

/// A camera in the fixed frame's origin that looks along z, y down, with a focal length in pixels.
///
/// # Errors
/// What is wrong with the numbers.
pub fn camera(size_px: [u32; 2], focal_px: f64) -> Result<Camera, CameraError> {
    let [width_px, height_px] = size_px;
    let (cx, cy) = (f64::from(width_px) / 2.0, f64::from(height_px) / 2.0);
    let p = [focal_px, 0.0, cx, 0.0, 0.0, focal_px, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    Ok(Camera::new(Intrinsics::from_p(width_px, height_px, &p)?, &Isometry3::identity(), 0.01))
}

/// The camera of a CameraInfo in `map`, as a config with one CameraPub display has it; `None` where there is none.
pub fn camera_of(info: &CameraInfo, model: CameraModel) -> Option<Camera> {
    const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz_camera_stream/CameraPub, Name: projector, Enabled: true, Image Topic: /image,
     Camera Info Topic: /camera_info}
";
    let config = rcs_rviz_config::parse(CONFIG, "scene.rviz").ok()?;
    let mut state = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])));
    state.take("/camera_info", &AnyMessage::CameraInfo(Arc::new(info.clone())), Time::ZERO);
    scene::camera(&state, &state.cameras()[0], model).ok()
}

/// The end-to-end benchmark's projector: 1280×800 pixels and a long focal length, so that a depth camera's view fills
/// it.
///
/// # Errors
/// None for these numbers.
pub fn projector() -> Result<Camera, CameraError> {
    camera([1280, 800], 1900.0)
}

/// A camera that moves a little with each frame and returns every eight frames.
///
/// # Errors
/// What is wrong with the numbers.
pub fn moving_camera(size_px: [u32; 2], focal_px: f64, frame: usize) -> Result<Camera, CameraError> {
    let still = camera(size_px, focal_px)?;
    let shift_m = 0.002 * (frame % 8) as f64;
    let fixed_from_optical = Isometry3::new(Vector3::new(shift_m, -shift_m, shift_m), Vector3::new(0.0, shift_m, 0.0));
    Ok(Camera::new(*still.intrinsics(), &fixed_from_optical, still.near_m()))
}

/// A scene and its renderer; the image's memory is reused.
pub struct Rendering {
    /// What is drawn.
    pub scene: Scene,
    /// What sees it.
    pub camera: Camera,
    /// How the image is laid out.
    pub encoding: Encoding,
    /// The last image.
    pub image: Image,
    renderer: Box<dyn Renderer>,
    visible: DisplayMask,
}

impl Rendering {
    /// Draws these on a renderer, without a light.
    pub fn new(drawables: Vec<Drawable>, camera: Camera, renderer: Box<dyn Renderer>) -> Self {
        Self {
            scene: Scene { drawables, light: None },
            camera,
            encoding: Encoding::Rgb8,
            image: Image::default(),
            renderer,
            visible: DisplayMask::all(),
        }
    }

    /// Draws an image of its own scene.
    ///
    /// # Errors
    /// Those of the renderer.
    pub fn draw(&mut self) -> Result<&Image, rcs_render::RenderError> {
        let scene = std::mem::take(&mut self.scene);
        let done = self.draw_of(&scene).map(|_| ());
        self.scene = scene;
        done.map(|()| &self.image)
    }

    /// Draws an image of a scene.
    ///
    /// # Errors
    /// Those of the renderer.
    pub fn draw_of(&mut self, scene: &Scene) -> Result<&Image, rcs_render::RenderError> {
        let view = View {
            scene,
            camera: &self.camera,
            visible: &self.visible,
            background: BACKGROUND,
            encoding: self.encoding,
        };
        self.renderer.render(&view, &mut self.image)?;
        Ok(&self.image)
    }

    /// The share of the image that is not background, in an encoding without alpha.
    pub fn covered(&self) -> f64 {
        let pixels = self.image.data.chunks_exact(self.encoding.bytes_per_pixel());
        let count = pixels.len().max(1) as f64;
        pixels.filter(|pixel| pixel.iter().any(|level| *level != LEVEL)).count() as f64 / count
    }
}
