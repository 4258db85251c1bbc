"""Random displays of markers: Marker, MarkerArray, InteractiveMarkers."""


import rospy
from geometry_msgs.msg import Vector3
from visualization_msgs.msg import (InteractiveMarker, InteractiveMarkerControl, InteractiveMarkerInit, InteractiveMarkerPose,
                                    InteractiveMarkerUpdate, Marker, MarkerArray, MenuEntry)

MESHES = ['package://conformance_assets/meshes/' + name for name in ('cone.stl', 'crate.obj', 'gear.dae')]
TEXTS = ['text', 'Two\nlines', 'A longer line of text, 3.14 m', 'ÄÖ µ', ' x ', '']
SHAPES = [Marker.ARROW, Marker.CUBE, Marker.SPHERE, Marker.CYLINDER]
LISTS = [Marker.LINE_STRIP, Marker.LINE_LIST, Marker.CUBE_LIST, Marker.SPHERE_LIST, Marker.POINTS, Marker.TRIANGLE_LIST]


def marker(scene):
    """Markers one by one, and sometimes arrays on the topic with `_array` after its name."""
    topic = scene.topic('marker')
    scene.add_display('Marker', **{'Marker Topic': topic, 'Queue Size': 200, 'Namespaces': namespaces(scene)})
    for step in range(len(scene.times)):
        for _ in range(scene.rng.randint(0 if step else 1, 4)):
            scene.publish(step, topic, random_marker(scene, step))


def marker_array(scene):
    topic = scene.topic('array')
    scene.add_display('MarkerArray', **{'Marker Topic': topic, 'Queue Size': 200, 'Namespaces': namespaces(scene)})
    scene.publish_at_some(topic, lambda step: MarkerArray([random_marker(scene, step)
                                                           for _ in range(scene.rng.choice([1, 3, 8, 20]))]))


def namespaces(scene):
    return {'b': False} if scene.chance(0.2) else {}


def random_marker(scene, step):
    """A marker that adds, and in later steps also one that modifies or deletes what may be there."""
    rng = scene.rng
    message = Marker(header=scene.header(step), ns=rng.choice(['', 'a', 'b']), id=rng.randrange(12))
    if step and scene.chance(0.2):
        message.action = rng.choice([Marker.DELETE, Marker.DELETE, Marker.DELETEALL])
        return message
    message.type = rng.choice(SHAPES + LISTS + LISTS + [Marker.TEXT_VIEW_FACING, Marker.MESH_RESOURCE])
    message.pose = scene.pose()
    message.color = scene.rgba()
    message.scale = scale(scene, message.type)
    # A marker that is no longer locked to its frame ends rviz, so each id is locked or is not.
    message.frame_locked = message.id < 3
    if scene.chance(0.15):
        message.lifetime = rospy.Duration.from_sec(scene.age(scene.uniform(0.2, 3.0)))
    if message.type in LISTS:
        add_points(scene, message)
    elif message.type == Marker.ARROW and scene.chance(0.4):
        message.points = [scene.point(0.3), scene.point(0.5)]
        message.scale = Vector3(scene.uniform(0.02, 0.1), scene.uniform(0.05, 0.2), rng.choice([0.0, 0.1, 0.2]))
    elif message.type == Marker.TEXT_VIEW_FACING:
        message.text = rng.choice(TEXTS)
    elif message.type == Marker.MESH_RESOURCE:
        message.mesh_resource = rng.choice(MESHES)
        message.mesh_use_embedded_materials = scene.chance(0.6)
        size = scene.log_uniform(0.1, 0.5)
        message.scale = Vector3(size, size, size * rng.choice([1, 1, 0.5]))
    return message


def scale(scene, kind):
    if kind in (Marker.LINE_STRIP, Marker.LINE_LIST):
        return Vector3(scene.log_uniform(0.005, 0.08), 0, 0)
    if kind in (Marker.TRIANGLE_LIST,):
        return Vector3(1, 1, 1)
    if kind in (Marker.CUBE_LIST, Marker.SPHERE_LIST, Marker.POINTS):
        size = scene.log_uniform(0.02, 0.2)
        return Vector3(size, size * scene.rng.choice([1, 0.5, 2]), size * scene.rng.choice([1, 0.5]))
    if kind == Marker.TEXT_VIEW_FACING:
        return Vector3(0, 0, scene.log_uniform(0.05, 0.4))
    sizes = [scene.log_uniform(0.05, 0.6) for _ in range(3)]
    if scene.chance(0.05):
        sizes[scene.rng.randrange(3)] = 0.0
    return Vector3(*sizes)


def add_points(scene, message):
    count = scene.count([1, 2, 3, 3, 6, 30, 120])
    if message.type == Marker.TRIANGLE_LIST and scene.chance(0.9):
        count -= count % 3
    if message.type == Marker.LINE_LIST and scene.chance(0.9):
        count -= count % 2
    message.points = [scene.point(0.5) for _ in range(count)]
    if scene.chance(0.4):
        alpha = scene.alpha()
        message.colors = [scene.rgba(alpha) for _ in range(count)]


# --- interactive markers ----------------------------------------------------------------------------------------------


def interactive_markers(scene):
    """A server's markers; some of them are moved, replaced or erased later.

    Nothing translucent: rviz draws the handles of a marker in an arbitrary order.
    """
    topic = scene.topic('handles')
    scene.add_display('InteractiveMarkers', **{
        'Update Topic': topic + '/update', 'Show Descriptions': scene.chance(0.6), 'Show Axes': scene.chance(0.4),
        'Show Visual Aids': False, 'Enable Transparency': False})
    names = [f'marker {i}' for i in range(scene.rng.randint(1, 3))]
    markers = [interactive_marker(scene, name) for name in names]
    scene.publish(0, topic + '/update_full', InteractiveMarkerInit('/server', 1, markers))
    scene.publish(0, topic + '/update', InteractiveMarkerUpdate('/server', 1, InteractiveMarkerUpdate.KEEP_ALIVE, [], [], []))
    sequence = 1
    for step in range(1, len(scene.times)):
        sequence += 1
        update = InteractiveMarkerUpdate('/server', sequence, InteractiveMarkerUpdate.UPDATE, [], [], [])
        kind = scene.rng.choice(['pose', 'replace', 'erase'])
        if kind == 'pose' and names:
            pose = InteractiveMarkerPose(name=scene.rng.choice(names), pose=scene.pose(0.5))
            pose.header.frame_id = scene.frame(moving=False)
            update.poses = [pose]
        elif kind == 'replace':
            update.markers = [interactive_marker(scene, 'marker 0')]
            names = sorted({*names, 'marker 0'})
        elif kind == 'erase' and names:
            update.erases = [names.pop()]
        scene.publish(step, topic + '/update', update)


def interactive_marker(scene, name):
    marker = InteractiveMarker(name=name, description=scene.rng.choice([name, '', 'Two\nlines']), scale=scene.uniform(0.3, 1.0))
    marker.header.frame_id = scene.frame(moving=False)
    marker.pose = scene.pose(0.5)
    for i in range(scene.rng.randint(1, 4)):
        control = InteractiveMarkerControl(name=f'control {i}', always_visible=scene.chance(0.7))
        control.interaction_mode = scene.rng.randrange(1, 10)
        control.orientation_mode = scene.rng.randrange(2)
        control.orientation = scene.quaternion()
        if scene.chance(0.4):
            control.markers = [handle(scene) for _ in range(scene.rng.randint(1, 2))]
        marker.controls.append(control)
    if scene.chance(0.2):
        marker.menu_entries = [MenuEntry(id=1, title='entry')]
    return marker


def handle(scene):
    """A marker of a control: without frame, it belongs to the interactive marker."""
    message = Marker(type=scene.rng.choice(SHAPES), color=scene.rgba(1.0))
    message.pose = scene.pose(0.2)
    message.scale = Vector3(*(scene.uniform(0.05, 0.3) for _ in range(3)))
    return message
