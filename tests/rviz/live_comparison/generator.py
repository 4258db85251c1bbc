"""Scenes from seeds: which displays a scene has, and what is put around them."""

from . import clouds, markers, poses, robots, sensors
from .scene import Scene
from .view import Camera, config, grouped

# One function for each display class that draws something, and how often it is chosen.
DISPLAYS = {
    sensors.accel_stamped: 1, robots.axes: 1, clouds.depth_cloud: 2, sensors.effort: 1, clouds.fluid_pressure: 1,
    robots.grid: 2, sensors.grid_cells: 2, clouds.illuminance: 1, markers.interactive_markers: 2, clouds.laser_scan: 2,
    sensors.map_: 2, markers.marker: 4, markers.marker_array: 4, poses.odometry: 2, poses.path: 2, clouds.point_cloud: 2,
    clouds.point_cloud2: 6, poses.point_stamped: 1, poses.polygon: 1, poses.pose: 1, poses.pose_array: 1,
    poses.pose_with_covariance: 2, sensors.range_: 1, clouds.relative_humidity: 1, robots.robot_model: 2,
    clouds.temperature: 1, robots.tf: 1, sensors.twist_stamped: 1, sensors.wrench_stamped: 1}


def scene_of(seed, start_secs):
    """The scene of a seed, whose first step is at a time of the simulated clock."""
    scene = Scene(seed, start_secs)
    for add in scene.rng.choices(list(DISPLAYS), list(DISPLAYS.values()), k=scene.rng.choice([1, 2, 2, 3, 3, 4, 6])):
        add(scene)
    scene.cameras = [Camera(scene, number) for number in range(scene.rng.choice([1, 1, 2]))]
    scene.displays = grouped(scene)
    scene.config = config(scene)
    return scene
