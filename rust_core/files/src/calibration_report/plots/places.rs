//! Projector, cameras and points in space: a parallel projection, viewed obliquely from above and from the projector's
//! right, in the projector's optical frame (x right, y down, z along the light).

use nalgebra::{Isometry3, Point2, Point3, Vector3};
use rcs_calibration::{Lens, Sample, Solution};

use super::{GREY, INK, SCANS};
use crate::calibration_report::scale::Scale;
use crate::calibration_report::svg::{Anchor, Svg};

const SIZE: [f64; 2] = [720.0, 430.0];
const MARGIN: f64 = 24.0;
/// Maximum number of drawn points.
const MOST_DOTS: usize = 1500;
/// Slopes of the drawn cameras' frustums; their lenses are not known here.
const CAMERA_SLOPE: [f64; 2] = [0.55, 0.42];
/// Colours of x, y and z.
const AXES: [&str; 3] = ["#d62728", "#2a9d4b", "#1f4fd1"];

/// Parallel projection onto the drawing.
struct ObliqueView {
    right: Vector3<f64>,
    down: Vector3<f64>,
    unit: f64,
    offset: [f64; 2],
}

impl ObliqueView {
    /// View that fits all points.
    fn of(points: &[Point3<f64>]) -> Self {
        let (turn, tilt) = (-55_f64.to_radians(), 24_f64.to_radians());
        let forward = Vector3::new(turn.sin() * tilt.cos(), tilt.sin(), turn.cos() * tilt.cos());
        let right = Vector3::y().cross(&forward).normalize();
        let mut view = Self { right, down: forward.cross(&right), unit: 1.0, offset: [0.0; 2] };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in points.iter().map(|point| view.place(point)).filter(|place| place.iter().all(|at| at.is_finite()))
        {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let extent: [f64; 2] = std::array::from_fn(|axis| (high[axis] - low[axis]).max(1e-3));
        view.unit = ((SIZE[0] - 2.0 * MARGIN) / extent[0]).min((SIZE[1] - 2.0 * MARGIN) / extent[1]);
        view.offset = std::array::from_fn(|axis| 0.5 * (SIZE[axis] - view.unit * (low[axis] + high[axis])));
        view
    }

    fn place(&self, point: &Point3<f64>) -> [f64; 2] {
        let [x, y] = [self.right, self.down].map(|axis| axis.dot(&point.coords));
        [self.offset[0] + self.unit * x, self.offset[1] + self.unit * y]
    }
}

/// Draws the plot.
pub(in crate::calibration_report) fn places(solution: &Solution, samples: &[Sample], depth_m: [f64; 2]) -> String {
    let [near_m, far_m] = match depth_m {
        [near, far] if near.is_finite() && far.is_finite() && far > 0.0 => [near.max(0.0).min(far), far],
        _ => [0.5, 1.0],
    };
    let dots = dots(solution, samples);
    let corners = |depth: f64| corners(&solution.lens, depth);
    let camera_m = 0.14 * far_m;
    let mut all: Vec<Point3<f64>> = dots.iter().flat_map(|(_, points)| points.iter().copied()).collect();
    all.extend(corners(far_m));
    // Room for the projector's name.
    all.extend([Point3::origin(), Point3::new(-0.1 * far_m, 0.0, -0.06 * far_m)]);
    for pose in &solution.poses {
        let camera = &pose.projector_from_camera;
        all.extend([-1.0, 1.0].map(|side| camera * Point3::new(0.0, side * camera_m, camera_m)));
        all.push(camera * Point3::origin());
    }
    let view = ObliqueView::of(&all);

    let mut svg = Svg::new(SIZE, "Cameras and projector in space");
    for (index, points) in &dots {
        let colour = SCANS[index % SCANS.len()];
        let style = format!("stroke=\"{colour}\" stroke-width=\"2.2\" stroke-opacity=\"0.65\"");
        svg.dots(points.iter().map(|point| view.place(point)), &style);
    }
    draw_depths(&mut svg, &view, far_m);
    draw_frustum(&mut svg, &view, &Isometry3::identity(), [&corners(near_m), &corners(far_m)], INK);
    draw_axes(&mut svg, &view, &Isometry3::identity(), 0.1 * far_m);
    let [x, y] = view.place(&Point3::origin());
    svg.text([x - 10.0, y + 5.0], Anchor::End, "projector", &format!("fill=\"{INK}\" font-weight=\"600\""));
    for (index, pose) in solution.poses.iter().enumerate() {
        let camera = &pose.projector_from_camera;
        let [slope_x, slope_y] = CAMERA_SLOPE;
        let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let rim = signs.map(|[x, y]| Point3::new(x * slope_x * camera_m, y * slope_y * camera_m, camera_m));
        let colour = SCANS[index % SCANS.len()];
        draw_frustum(&mut svg, &view, camera, [&rim, &rim], colour);
        draw_axes(&mut svg, &view, camera, 0.07 * far_m);
    }
    draw_legend(&mut svg, solution);
    svg.finish()
}

/// Draws the legend of the scans' colours.
fn draw_legend(svg: &mut Svg, solution: &Solution) {
    /// Maximum number of scans with different colours.
    const MOST: usize = SCANS.len();
    let poses = &solution.poses;
    for (index, pose) in poses.iter().take(MOST).enumerate() {
        let (y, colour) = (MARGIN + 19.0 * index as f64, SCANS[index]);
        let label = match poses.len() {
            1 => "camera and its points".to_owned(),
            _ => format!("camera of scan {} and its points", pose.scan),
        };
        svg.circle([16.0, y - 4.0], 5.0, &format!("fill=\"{colour}\""));
        svg.text([28.0, y], Anchor::Start, &label, &format!("fill=\"{INK}\""));
    }
    if poses.len() > MOST {
        let more = format!("and {} more, in the same colours again", poses.len() - MOST);
        svg.text([28.0, MARGIN + 19.0 * MOST as f64], Anchor::Start, &more, &format!("fill=\"{GREY}\""));
    }
}

/// Evenly drawn inliers in the projector's frame, by scan index.
fn dots(solution: &Solution, samples: &[Sample]) -> Vec<(usize, Vec<Point3<f64>>)> {
    let inliers = solution.residuals.iter().filter(|residual| residual.is_inlier);
    let step = (inliers.clone().count() / MOST_DOTS).max(1);
    let mut dots: Vec<(usize, Vec<Point3<f64>>)> = (0..solution.poses.len()).map(|index| (index, Vec::new())).collect();
    for sample in inliers.step_by(step).filter_map(|residual| samples.get(residual.sample)) {
        if let Some(index) = solution.poses.iter().position(|pose| pose.scan == sample.scan) {
            dots[index].1.push(solution.poses[index].projector_from_camera * sample.point);
        }
    }
    dots
}

/// Corners of the projector's image at a depth; where the distortion has no inverse, those of a pinhole.
fn corners(lens: &Lens, depth: f64) -> [Point3<f64>; 4] {
    let [width, height] = lens.size_px.map(f64::from);
    [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]].map(|[u, v]| {
        let pixel = Point2::new(u - 0.5, v - 0.5);
        let pinhole = (pixel - lens.center_px).component_div(&lens.focal_px).push(1.0);
        Point3::from(lens.ray(pixel).unwrap_or(pinhole) * depth)
    })
}

/// Draws the edges of a frustum with its near and far sides.
fn draw_frustum(svg: &mut Svg, view: &ObliqueView, pose: &Isometry3<f64>, sides: [&[Point3<f64>; 4]; 2], colour: &str) {
    let place = |point: &Point3<f64>| view.place(&(pose * point));
    let line = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.2\" stroke-linejoin=\"round\"");
    let faint = format!("{line} stroke-opacity=\"0.6\"");
    for side in sides {
        let [a, b, c, d] = side.each_ref().map(place);
        svg.path(&[a, b, c, d, a], &line);
    }
    for corner in sides[1] {
        svg.line(place(&Point3::origin()), place(corner), &faint);
    }
}

fn draw_axes(svg: &mut Svg, view: &ObliqueView, pose: &Isometry3<f64>, length_m: f64) {
    let origin = view.place(&(pose * Point3::origin()));
    for (index, colour) in AXES.iter().enumerate() {
        let mut end = Point3::origin();
        end[index] = length_m;
        svg.line(origin, view.place(&(pose * end)), &format!("stroke=\"{colour}\" stroke-width=\"2.2\""));
    }
    svg.circle(origin, 2.6, &format!("fill=\"{INK}\""));
}

/// Draws the optical axis with marks at round depths.
fn draw_depths(svg: &mut Svg, view: &ObliqueView, far_m: f64) {
    let on_axis = |depth: f64| view.place(&Point3::new(0.0, 0.0, depth));
    let line = format!("stroke=\"{GREY}\" stroke-width=\"1\"");
    svg.line(on_axis(0.0), on_axis(far_m), &format!("{line} stroke-dasharray=\"6 4\""));
    // A white outline keeps the texts readable.
    let readable =
        format!("fill=\"{GREY}\" font-size=\"11\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"");
    for (depth, text) in Scale::new([0.0, far_m], [0.0, 1.0]).ticks(5.0).into_iter().skip(1) {
        let [x, y] = on_axis(depth);
        svg.line([x, y - 4.0], [x, y + 4.0], &line);
        svg.text([x, y + 17.0], Anchor::Middle, &format!("{text} m"), &readable);
    }
}
