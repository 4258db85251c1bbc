"""Random displays of robots (RobotModel), and of what has no messages: Grid, Axes, TF."""

import os

from .poses import offset
from .scene import Frame

ROBOTS = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', 'golden', 'robots', 'urdf')
# The robot of the file arm.urdf.
ARM_LINKS = ['root', 'shoulder', 'upper', 'lower', 'hand']
ARM_JOINTS = ['turn', 'lift', 'bend', 'roll']


def add_robot(scene):
    """A description as a parameter, and the frames of its links. Returns the properties that name them."""
    parameter, prefix = f'/{scene.prefix}/robot{len(scene.displays)}', scene.name(f'arm{len(scene.displays)}')
    with open(os.path.join(ROBOTS, 'arm.urdf')) as file:
        scene.parameters[parameter] = file.read()
    parent = scene.frame()
    for link in ARM_LINKS:
        name = f'{prefix}/{link}'
        moves = scene.chance(0.3)
        poses = [scene.pose(0.35) for _ in range(len(scene.times) if moves else 1)]
        scene.frames.append(Frame(name, parent, poses))
        parent = name
    return {'Robot Description': parameter, 'TF Prefix': prefix}


def robot_model(scene):
    """Settings of links count in rviz because the description is there before the config is loaded."""
    shown = {name: {'Value': scene.chance(0.8), 'Alpha': scene.alpha(), 'Show Axes': scene.chance(0.3), 'Show Trail': False}
             for name in ARM_LINKS if scene.chance(0.5)}
    links = {'All Links Enabled': True, 'Expand Joint Details': False, 'Expand Link Details': False, 'Expand Tree': False,
             'Link Tree Style': 'Links in Alphabetic Order', **shown}
    more = {'Alpha': scene.alpha(), 'Visual Enabled': scene.chance(0.8), 'Collision Enabled': scene.chance(0.3),
            'Links': links}
    robot = add_robot(scene)
    chosen = scene.some(more)
    if chosen.get('Collision Enabled'):
        # A link's shapes of both kinds may have the same origin, and the order of translucent ones is that of addresses then.
        chosen['Visual Enabled'] = False
    scene.add_display('RobotModel', **robot, **chosen)


def grid(scene):
    more = {'Plane': scene.rng.choice(['XY', 'XZ', 'YZ']), 'Plane Cell Count': scene.rng.randint(1, 12),
            'Normal Cell Count': scene.rng.choice([0, 0, 1, 3]), 'Cell Size': scene.log_uniform(0.05, 1),
            'Color': scene.color(),
            'Line Style': {'Value': scene.rng.choice(['Lines', 'Billboards']), 'Line Width': scene.log_uniform(0.005, 0.06)},
            'Alpha': scene.alpha(), 'Offset': offset(scene), 'Reference Frame': scene.frame()}
    scene.add_display('Grid', **scene.some(more))


def axes(scene):
    """Without a trail: where it begins depends on when each program has seen the frame first."""
    more = {'Reference Frame': scene.frame(), 'Length': scene.uniform(0.1, 1.0), 'Radius': scene.log_uniform(0.005, 0.15),
            'Alpha': scene.alpha()}
    scene.add_display('Axes', **scene.some(more))


def tf(scene):
    """All frames of the scene; those of other scenes have no transform to this one's, and are hidden."""
    frames = {frame.name: {'Value': scene.chance(0.6)} for frame in scene.frames if scene.chance(0.3)}
    more = {'Show Names': scene.chance(0.7), 'Show Axes': scene.chance(0.8), 'Show Arrows': scene.chance(0.8),
            'Marker Scale': scene.log_uniform(0.2, 2.0), 'Marker Alpha': scene.alpha(),
            'Frames': {'All Enabled': True, **frames}}
    scene.add_display('TF', **{'Update Interval': 0}, **scene.some(more))
