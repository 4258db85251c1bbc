"""Random displays of what sensors, maps and drives tell: screws (Accel, Twist, Wrench), Range, GridCells, Map, Effort."""

from geometry_msgs.msg import AccelStamped, Point, Pose, TwistStamped, Vector3, WrenchStamped
from map_msgs.msg import OccupancyGridUpdate
from nav_msgs.msg import GridCells, OccupancyGrid
from sensor_msgs.msg import JointState, Range

from .robots import ARM_JOINTS, add_robot


def screw(kind, words, fill):
    """AccelStamped, TwistStamped, WrenchStamped.

    *Hide Small Values* stays on: rviz ignores it in a file until it is changed in the window.
    """

    def add(scene):
        topic = scene.topic('screw')
        linear, angular = words
        more = {f'{linear} Color': scene.color(), f'{angular} Color': scene.color(), 'Alpha': scene.alpha(),
                f'{linear} Arrow Scale': scene.uniform(0.3, 2), f'{angular} Arrow Scale': scene.uniform(0.3, 2),
                'Arrow Width': scene.uniform(0.1, 0.8), 'History Length': scene.rng.choice([1, 1, 2, 3])}
        scene.add_display(kind, Topic=topic, **scene.some(more))
        scene.publish_at_some(topic, lambda step: fill(scene.header(step), vector(scene), vector(scene)))

    return add


def vector(scene):
    if scene.chance(0.1):
        return Vector3()
    return Vector3(*(scene.uniform(-1, 1) for _ in range(3)))


def accel_message(header, linear, angular):
    message = AccelStamped(header=header)
    message.accel.linear, message.accel.angular = linear, angular
    return message


def twist_message(header, linear, angular):
    message = TwistStamped(header=header)
    message.twist.linear, message.twist.angular = linear, angular
    return message


def wrench_message(header, linear, angular):
    message = WrenchStamped(header=header)
    message.wrench.force, message.wrench.torque = linear, angular
    return message


accel_stamped = screw('AccelStamped', ('Linear', 'Angular'), accel_message)
twist_stamped = screw('TwistStamped', ('Linear', 'Angular'), twist_message)
wrench_stamped = screw('WrenchStamped', ('Force', 'Torque'), wrench_message)


def range_(scene):
    topic = scene.topic('range')
    more = {'Color': scene.color(), 'Alpha': scene.alpha(), 'Buffer Length': scene.rng.choice([1, 2, 4])}
    scene.add_display('Range', Topic=topic, **scene.some(more))

    def message(step):
        result = Range(header=scene.header(step), field_of_view=scene.uniform(0.05, 1.5), min_range=0.1, max_range=1.5)
        result.range = scene.rng.choice([scene.uniform(0.1, 1.5), scene.uniform(0.1, 1.5), 0.05, 1.6, float('inf')])
        if scene.chance(0.1):
            result.min_range = result.max_range = 0.8
            result.range = scene.rng.choice([float('-inf'), float('inf')])
        return result

    scene.publish_at_some(topic, message)


def grid_cells(scene):
    topic = scene.topic('cells')
    scene.add_display('GridCells', Topic=topic, **scene.some({'Color': scene.color(), 'Alpha': scene.alpha()}))

    def message(step):
        result = GridCells(header=scene.header(step), cell_width=scene.uniform(0.03, 0.2), cell_height=scene.uniform(0.03, 0.2))
        result.cells = [scene.point() for _ in range(scene.count([1, 10, 100]))]
        return result

    scene.publish_at_some(topic, message)


def map_(scene):
    topic = scene.topic('map')
    more = {'Alpha': scene.alpha(), 'Color Scheme': scene.rng.choice(['map', 'costmap', 'raw']),
            'Draw Behind': scene.chance(0.2), 'Use Timestamp': scene.chance(0.3)}
    scene.add_display('Map', Topic=topic, **scene.some(more))
    sent = []

    def grid(step):
        width, height = (scene.rng.choice([1, 7, 20, 63]) for _ in range(2))
        result = OccupancyGrid(header=scene.header(step))
        result.info.width, result.info.height = width, height
        result.info.resolution = scene.uniform(0.5, 2.0) / max(width, height)
        result.info.origin = Pose(Point(scene.uniform(-1, 0), scene.uniform(-1, 0), scene.uniform(-0.3, 0.3)),
                                  scene.quaternion() if scene.chance(0.3) else Pose().orientation)
        result.info.origin.orientation.w = result.info.origin.orientation.w or 1.0
        result.data = cells(scene, width * height)
        sent.append((width, height))
        return result

    scene.publish(0, topic, grid(0))
    for step in range(1, len(scene.times)):
        if scene.chance(0.3):
            scene.publish(step, topic, grid(step))
        elif scene.chance(0.5):
            scene.publish(step, topic + '_updates', map_update(scene, step, *sent[-1]))


def map_update(scene, step, width, height):
    x, y = scene.rng.randrange(width), scene.rng.randrange(height)
    update = OccupancyGridUpdate(header=scene.header(step), x=x, y=y)
    update.width, update.height = scene.rng.randint(1, width - x), scene.rng.randint(1, height - y)
    update.data = cells(scene, update.width * update.height)
    return update


def cells(scene, count):
    values = [-1, 0, 0, 100, 99, 50, scene.rng.randint(-128, 127), scene.rng.randint(0, 100)]
    return [scene.rng.choice(values) for _ in range(count)]


def effort(scene):
    """Efforts at the joints of a robot. They are shown where the joints are when they come, so transforms come first."""
    scene.transforms_first = True
    topic = scene.topic('efforts')
    robot = add_robot(scene)
    more = {'Width': scene.log_uniform(0.01, 0.1), 'Scale': scene.uniform(0.3, 2),
            'History Length': scene.rng.choice([1, 1, 2, 3]),
            'Joints': {name: {'Value': scene.chance(0.8)} for name in ARM_JOINTS if scene.chance(0.5)}}
    scene.add_display('Effort', Topic=topic, **robot, **scene.some(more))

    def message(step):
        names = [name for name in ARM_JOINTS if scene.chance(0.8)]
        result = JointState(name=names, position=[0.0] * len(names), velocity=[0.0] * len(names))
        result.header.stamp = scene.stamp(step)
        result.effort = [scene.uniform(-30, 30) for _ in names]
        return result

    scene.publish_at_some(topic, message)
