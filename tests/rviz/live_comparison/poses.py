"""Random displays of poses and paths: Pose, PoseArray, PoseWithCovariance, Odometry, Path, PointStamped, Polygon."""

import numpy as np
from geometry_msgs.msg import (Point32, PointStamped, PolygonStamped, PoseArray, PoseStamped, PoseWithCovarianceStamped)
from nav_msgs.msg import Odometry, Path


def symbol(scene):
    """The properties of the symbol at a pose: an arrow or axes."""
    return {'Color': scene.color(), 'Alpha': scene.alpha(), 'Shaft Length': scene.uniform(0.1, 1.0),
            'Shaft Radius': scene.uniform(0.01, 0.15), 'Head Length': scene.uniform(0.05, 0.4),
            'Head Radius': scene.uniform(0.02, 0.3), 'Axes Length': scene.uniform(0.1, 1.0),
            'Axes Radius': scene.uniform(0.01, 0.15)}


def covariance_properties(scene):
    position = {'Value': scene.chance(0.8), 'Color': scene.color(), 'Alpha': scene.alpha(), 'Scale': scene.uniform(0.2, 3)}
    orientation = {'Value': scene.chance(0.8), 'Frame': scene.rng.choice(['Local', 'Fixed']),
                   'Color Style': scene.rng.choice(['Unique', 'RGB']), 'Color': scene.color(), 'Alpha': scene.alpha(),
                   'Offset': scene.uniform(0.1, 1.2), 'Scale': scene.uniform(0.2, 3)}
    return {'Value': scene.chance(0.85), 'Position': position, 'Orientation': orientation}


def covariance(scene):
    """The covariance of a pose, 36 numbers: any, of a pose in the plane, or none."""
    kind = scene.rng.choice(['any', 'any', 'plane', 'none'])
    if kind == 'none':
        return [0.0] * 36
    square = scene.numpy.normal(size=(6, 6)) * 0.12
    matrix = square @ square.T
    if kind == 'plane':
        for i in (2, 3, 4):
            matrix[i, :] = matrix[:, i] = 0
    return [float(value) for value in np.round(matrix, 6).flatten()]


def pose(scene):
    topic = scene.topic('pose')
    shape = {'Shape': scene.rng.choice(['Arrow', 'Axes'])}
    scene.add_display('Pose', Topic=topic, **shape, **scene.some(symbol(scene)))
    scene.publish_at_some(topic, lambda step: PoseStamped(scene.header(step), scene.pose()))


def pose_array(scene):
    topic = scene.topic('poses')
    shape = scene.rng.choice(['Arrow (Flat)', 'Arrow (3D)', 'Axes'])
    sizes = {'Arrow Length': scene.uniform(0.05, 0.6)}
    scene.add_display('PoseArray', Topic=topic, Shape=shape, **scene.some({**symbol(scene), **sizes}))
    scene.publish_at_some(topic, lambda step: PoseArray(scene.header(step), some_poses(scene)))


def some_poses(scene):
    return [scene.pose() for _ in range(scene.count([1, 5, 5, 40]))]


def pose_with_covariance(scene):
    topic = scene.topic('estimate')
    shape = {'Shape': scene.rng.choice(['Arrow', 'Axes'])}
    more = {**symbol(scene), 'Covariance': covariance_properties(scene)}
    scene.add_display('PoseWithCovariance', Topic=topic, **shape, **scene.some(more))

    def message(step):
        result = PoseWithCovarianceStamped(header=scene.header(step))
        result.pose.pose, result.pose.covariance = scene.pose(), covariance(scene)
        return result

    scene.publish_at_some(topic, message)


def odometry(scene):
    topic = scene.topic('odometry')
    shape = {'Value': scene.rng.choice(['Arrow', 'Axes']), **scene.some(symbol(scene))}
    more = {'Shape': shape, 'Covariance': covariance_properties(scene), 'Keep': scene.rng.choice([0, 1, 2, 3, 100]),
            'Position Tolerance': scene.rng.choice([0, 0.1, 0.5]), 'Angle Tolerance': scene.rng.choice([0, 0.1, 0.5])}
    scene.add_display('Odometry', Topic=topic, **scene.some(more))

    def message(step):
        result = Odometry(header=scene.header(step))
        result.pose.pose, result.pose.covariance = scene.pose(), covariance(scene)
        return result

    scene.publish_at_some(topic, message)


def path(scene):
    topic = scene.topic('path')
    styles = {'Line Style': scene.rng.choice(['Lines', 'Billboards']),
              'Pose Style': scene.rng.choice(['None', 'Axes', 'Arrows'])}
    sizes = {'Line Width': scene.log_uniform(0.005, 0.1), 'Color': scene.color(), 'Alpha': scene.alpha(),
             'Buffer Length': scene.rng.choice([1, 1, 2, 3]), 'Offset': offset(scene), 'Pose Color': scene.color(),
             'Length': scene.uniform(0.05, 0.5), 'Radius': scene.uniform(0.005, 0.05),
             'Shaft Length': scene.uniform(0.05, 0.3), 'Shaft Diameter': scene.uniform(0.02, 0.1),
             'Head Length': scene.uniform(0.05, 0.3), 'Head Diameter': scene.uniform(0.05, 0.3)}
    scene.add_display('Path', Topic=topic, **styles, **scene.some(sizes))

    def message(step):
        result = Path(header=scene.header(step))
        result.poses = [PoseStamped(result.header, pose) for pose in some_poses(scene)]
        return result

    scene.publish_at_some(topic, message)


def offset(scene):
    return {name: scene.uniform(-0.5, 0.5) for name in 'XYZ'}


def point_stamped(scene):
    topic = scene.topic('point')
    more = {'Color': scene.color(), 'Alpha': scene.alpha(), 'Radius': scene.log_uniform(0.02, 0.4),
            'History Length': scene.rng.choice([1, 2, 5])}
    scene.add_display('PointStamped', Topic=topic, **scene.some(more))
    scene.publish_at_some(topic, lambda step: PointStamped(scene.header(step), scene.point()))


def polygon(scene):
    topic = scene.topic('polygon')
    scene.add_display('Polygon', Topic=topic, **scene.some({'Color': scene.color(), 'Alpha': scene.alpha()}))

    def message(step):
        result = PolygonStamped(header=scene.header(step))
        corners = [scene.point() for _ in range(scene.count([1, 2, 3, 3, 8, 8]))]
        result.polygon.points = [Point32(corner.x, corner.y, corner.z) for corner in corners]
        return result

    scene.publish_at_some(topic, message)
