//! Images in flight; uploads, pipelines and targets are counted, so that nothing is done twice.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::Arc;

use common::{at, camera, points, scene, square_mesh};
use rcs_render::{CpuRenderer, Finished, GpuRenderer, RenderError, Renderer, View};
use rcs_scene::{
    Blending, Camera, CellSheet, Cells, CullMode, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment,
    Image, LineTopology, Lines, Material, PointBuffer, PointColors, PointStyle, Points, Rgba, RibbonElement, Ribbons,
    Scene, Text, VerticalAlignment,
};

const STYLES: [PointStyle; 6] = [
    PointStyle::Points { diameter_px: 3.0 },
    PointStyle::Squares { size_m: [0.1; 2] },
    PointStyle::FlatSquares { side_m: 0.1 },
    PointStyle::Spheres { size_m: [0.1; 2] },
    PointStyle::Boxes { size_m: [0.1; 3] },
    PointStyle::Tiles { size_m: [0.1; 2], normal: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] },
];

fn gpu() -> GpuRenderer {
    GpuRenderer::new(false).unwrap()
}

/// An image to be drawn.
struct Request {
    scene: Scene,
    camera: Camera,
    encoding: Encoding,
}

impl Request {
    /// A square whose colour and place identify it.
    fn new(number: u8, size_px: [u32; 2], encoding: Encoding) -> Self {
        let color = [40 * number, 255 - 40 * number, 90, 255];
        let cloud = points(PointStyle::FlatSquares { side_m: 0.4 }, color, &[[0.0; 3]]);
        let scene = scene([at(0.05 * f64::from(number), 0.0, 1.0, Geometry::Points(cloud))]);
        Self { scene, camera: camera(size_px[0], size_px[1], f64::from(size_px[0])), encoding }
    }

    fn with_view<T>(&self, work: impl FnOnce(&View<'_>) -> T) -> T {
        let visible = DisplayMask::all();
        let (scene, camera, encoding) = (&self.scene, &self.camera, self.encoding);
        work(&View { scene, camera, visible: &visible, background: [1, 2, 3], encoding })
    }

    fn submit(&self, renderer: &mut dyn Renderer) -> Result<(), RenderError> {
        self.with_view(|view| renderer.submit(view))
    }

    fn rendered(&self, renderer: &mut dyn Renderer) -> Image {
        let mut image = Image::default();
        self.with_view(|view| renderer.render(view, &mut image)).unwrap();
        image
    }
}

fn requests() -> [Request; 5] {
    [
        Request::new(1, [64, 48], Encoding::Rgb8),
        Request::new(2, [64, 48], Encoding::Bgra8),
        Request::new(3, [37, 91], Encoding::Mono16),
        Request::new(4, [64, 48], Encoding::Rgb8),
        Request::new(5, [130, 7], Encoding::Bgr8),
    ]
}

fn finished(renderer: &mut dyn Renderer) -> Image {
    let mut image = Image::default();
    assert_eq!(renderer.finish(&mut image).unwrap(), Finished::Drawn);
    image
}

fn is_empty(renderer: &mut dyn Renderer) -> bool {
    let mut image = Image { data: vec![7], ..Image::default() };
    let finished = renderer.finish(&mut image).unwrap();
    finished == Finished::NoneInFlight && image.data == [7]
}

#[test]
fn images_in_flight_come_out_in_order_and_as_they_are_drawn_alone() {
    let renderers: [Box<dyn Renderer>; 2] = [Box::new(gpu()), Box::new(CpuRenderer::new())];
    for mut renderer in renderers {
        let renderer = renderer.as_mut();
        let alone: Vec<Image> = requests().iter().map(|request| request.rendered(renderer)).collect();
        for at_once in 1..=5 {
            for (requests, alone) in requests().chunks(at_once).zip(alone.chunks(at_once)) {
                requests.iter().for_each(|request| request.submit(renderer).unwrap());
                alone.iter().for_each(|alone| assert_eq!(finished(renderer), *alone));
                assert!(is_empty(renderer));
            }
        }
        // One begins whenever one ends.
        let requests = requests();
        requests[0].submit(renderer).unwrap();
        for (request, alone) in requests[1..].iter().zip(&alone) {
            request.submit(renderer).unwrap();
            assert_eq!(finished(renderer), *alone);
        }
        assert_eq!(finished(renderer), alone[4]);
    }
}

#[test]
fn a_image_drawn_at_once_drops_those_in_flight() {
    let renderers: [Box<dyn Renderer>; 2] = [Box::new(gpu()), Box::new(CpuRenderer::new())];
    for mut renderer in renderers {
        let renderer = renderer.as_mut();
        let [first, second, third, ..] = requests();
        let alone = third.rendered(renderer);
        first.submit(renderer).unwrap();
        second.submit(renderer).unwrap();
        assert_eq!(third.rendered(renderer), alone);
        assert!(is_empty(renderer));
    }
}

#[test]
fn a_refused_image_leaves_those_in_flight() {
    let mut renderer = gpu();
    let [first, second, ..] = requests();
    let alone = [&first, &second].map(|request| request.rendered(&mut renderer));
    first.submit(&mut renderer).unwrap();
    // Where the adapter draws images as large as they may be, none is refused.
    let refused = Request::new(1, [16384, 1], Encoding::Rgb8).submit(&mut renderer);
    second.submit(&mut renderer).unwrap();
    assert_eq!(finished(&mut renderer), alone[0]);
    match refused {
        Ok(()) => assert_eq!(finished(&mut renderer).width_px, 16384),
        Err(error) => assert!(matches!(error, RenderError::TooLarge { .. }), "{error}"),
    }
    assert_eq!(finished(&mut renderer), alone[1]);
}

#[test]
fn a_renderer_may_be_dropped_with_images_in_flight() {
    let mut renderer = gpu();
    requests().iter().for_each(|request| request.submit(&mut renderer).unwrap());
    drop(renderer);
    let mut renderer = gpu();
    requests()[0].submit(&mut renderer).unwrap();
    finished(&mut renderer);
    requests()[1].submit(&mut renderer).unwrap();
}

#[test]
fn a_cloud_is_uploaded_once_for_all_cameras_images_and_styles() {
    let mut renderer = gpu();
    let cloud = |blue: u8| {
        let positions: Vec<_> = (0..1000).map(|i| [(i % 40) as f32 / 40.0, (i / 40) as f32 / 40.0, 1.0]).collect();
        Arc::new(PointBuffer { colors: PointColors::PerPoint(vec![[9, 9, blue, 255]; positions.len()]), positions })
    };
    let cameras = [camera(64, 48, 50.0), camera(64, 48, 90.0), camera(100, 30, 50.0), camera(20, 20, 10.0)];
    let mut draw = |buffer: &Arc<PointBuffer>| {
        let before = renderer.stats();
        for style in STYLES {
            for camera in &cameras {
                let points = Points { buffer: Arc::clone(buffer), style, alpha: 1.0, blended: false, auto_size: false };
                let scene = scene([at(0.0, 0.0, 0.0, Geometry::Points(points))]);
                Request { scene, camera: camera.clone(), encoding: Encoding::Rgb8 }.submit(&mut renderer).unwrap();
            }
            cameras.iter().for_each(|_| drop(finished(&mut renderer)));
        }
        let after = renderer.stats();
        (after.uploads - before.uploads, after.uploaded_bytes - before.uploaded_bytes, after.targets - before.targets)
    };
    let [first, second] = [cloud(1), cloud(2)];
    assert_eq!(draw(&first), (1, 16_000, 4), "a target for each picture in flight");
    assert_eq!(draw(&first), (0, 0, 0));
    assert_eq!(draw(&second), (1, 16_000, 0));
}

#[test]
fn a_cloud_whose_points_lie_in_many_shares_is_drawn_whole() {
    let mut renderer = gpu();
    let (width, height) = (400_u32, 200_u32);
    // One point for each pixel, more than one share and not a whole number of them.
    let positions = (0..width * height).map(|i| [(i % width) as f32 + 0.5, (i / width) as f32 + 0.5, 1.0]).collect();
    let colors: Vec<[u8; 4]> = (0..width * height).map(|i| [i as u8, (i >> 8) as u8, (i >> 16) as u8, 255]).collect();
    let buffer = Arc::new(PointBuffer { positions, colors: PointColors::PerPoint(colors[..70_000].to_vec()) });
    let style = PointStyle::Points { diameter_px: 1.0 };
    let cloud = Points { buffer, style, alpha: 1.0, blended: false, auto_size: false };
    let mut drawable = at(0.0, 0.0, 0.0, Geometry::Points(cloud));
    drawable.fixed_from_object[(0, 3)] = -f64::from(width) / 2.0;
    drawable.fixed_from_object[(1, 3)] = -f64::from(height) / 2.0;
    let request = Request { scene: scene([drawable]), camera: camera(width, height, 1.0), encoding: Encoding::Rgba8 };
    let expected: Vec<u8> = colors[..70_000].iter().chain([[255; 4]; 10_000].iter()).flatten().copied().collect();
    assert!(request.rendered(&mut renderer).data == expected);
}

/// One of everything, in every state that displays give it.
fn one_of_everything() -> Vec<Drawable> {
    let blendings = [Blending::Replace, Blending::Alpha];
    let mut geometries = Vec::new();
    for (style, blended) in STYLES.into_iter().flat_map(|style| [(style, false), (style, true)]) {
        geometries.push(Geometry::Points(Points { blended, ..points(style, [9, 200, 9, 255], &[[0.0; 3]]) }));
    }
    for blending in blendings {
        let (positions, colors) = (vec![[0.0; 3], [0.3, 0.2, 0.0]], vec![[255; 4]; 2]);
        geometries.push(Geometry::Lines(Arc::new(Lines {
            positions,
            colors,
            topology: LineTopology::Strip,
            blending,
        })));
        let chain = [[0.0; 3], [0.3, 0.2, 0.0]].map(|position| RibbonElement { position, color: [255; 4] }).to_vec();
        geometries.push(Geometry::Ribbons(Arc::new(Ribbons { chains: vec![chain], width_m: 0.1, blending })));
        for depth_write in [false, true] {
            geometries.push(Geometry::Cells(CellSheet {
                cells: Arc::new(Cells::new(2, 2, &[1, 2, 3, 4])),
                palette: Arc::new([[255; 4]; 256]),
                alpha: 1.0,
                blending,
                depth_write,
            }));
        }
    }
    let tint = Material { blending: Blending::Alpha, ..Material::lit(Rgba::WHITE) };
    for look in [Material::lit(Rgba::WHITE), Material::lit(Rgba::new(1.0, 1.0, 1.0, 0.5)), tint] {
        for cull in [CullMode::None, CullMode::Back, CullMode::Front] {
            let material = Arc::new(Material { cull, ..look.clone() });
            geometries.push(Geometry::Mesh { mesh: Arc::new(square_mesh()), material });
        }
    }
    let text = || Text::new("A", 0.2, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Center));
    geometries.extend([text(), text().on_top()].map(|text| Geometry::Text(Arc::new(text))));
    geometries.into_iter().map(|geometry| at(0.0, 0.0, 1.0, geometry)).collect()
}

#[test]
fn no_pipeline_is_built_after_the_device_was_opened() {
    let mut renderer = gpu();
    let opened = renderer.stats();
    assert!(opened.pipelines > 0);
    let request = Request { scene: scene(one_of_everything()), camera: camera(60, 40, 40.0), encoding: Encoding::Rgb8 };
    request.rendered(&mut renderer);
    let first = renderer.stats();
    assert_eq!(first.pipelines, opened.pipelines);
    assert!(first.uploads > opened.uploads);
    for _ in 0..5 {
        request.rendered(&mut renderer);
    }
    let last = renderer.stats();
    assert_eq!((last.pipelines, last.uploads, last.targets), (first.pipelines, first.uploads, 1));
    assert_eq!(last.images, 6);
}

#[test]
fn targets_are_made_for_new_sizes_and_dropped_when_unused() {
    let mut renderer = gpu();
    let [small, _, tall, ..] = requests();
    let mut targets_after = |request: &Request| {
        request.rendered(&mut renderer);
        renderer.stats().targets
    };
    assert_eq!([&small, &tall, &small, &tall].map(&mut targets_after), [1, 2, 2, 2]);
    assert!((0..70).all(|_| targets_after(&tall) == 2));
    assert_eq!(targets_after(&small), 3);
    renderer.forget_sizes();
    small.rendered(&mut renderer);
    assert_eq!(renderer.stats().targets, 4);
}
