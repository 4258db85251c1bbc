"""The displays Pose and PoseArray."""

import math

from geometry_msgs.msg import PoseArray

from ..common import rising_poses, turning_poses
from ..displays import display
from ..geometry import pose, quaternion
from ..messages import header, pose_stamped
from ..scene import LARGE


def pose_arrow(scene):
    scene.camera(**LARGE)
    scene.show(display("Pose", {"Color": "255; 25; 0", "Shape": "Arrow"}))
    scene.publish("/p", pose_stamped((-0.4, 0.2, 0.3), (0, -0.3, 0.5)))


def pose_axes_rotated_frame(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("Pose", {"Axes Length": 0.6, "Axes Radius": 0.07, "Shape": "Axes"}),
               display("Pose",
                       {"Alpha": 0.4, "Color": "60; 180; 255", "Head Length": 0.3, "Head Radius": 0.25, "Shaft Length": 0.5,
                        "Shaft Radius": 0.1}, name="q", topic="/q"))
    scene.publish("/p", pose_stamped((0.1, 0.2, 0.1), (0.4, -0.3, 0.8), frame="sensor"))
    scene.publish("/q", pose_stamped((-0.3, -0.5, 0.2), (0.5, -0.6, 0.9)))


def pose_negative_and_zero_sizes(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("Pose", {"Color": "0; 255; 255", "Head Length": 0.3, "Shaft Length": -0.5}, name="a", topic="/a"),
               display("Pose", {"Head Length": -0.3, "Shaft Length": 0.5}, name="b", topic="/b"),
               display("Pose", {"Color": "255; 255; 0", "Shaft Length": 0.5, "Shaft Radius": 0}, name="c", topic="/c"),
               display("Pose", {"Color": "0; 255; 0", "Head Length": 0.4, "Head Radius": -0.3, "Shaft Length": 0}, name="d",
                       topic="/d"),
               display("Pose", {"Alpha": 0}, name="e", topic="/e"),
               display("Pose", {"Axes Length": -0.4, "Axes Radius": 0.05, "Shape": "Axes"}, name="f", topic="/f"))
    scene.publish("/a", pose_stamped((0.4, 0.3, 0.2), (0.4, -0.3, 0.8)))
    scene.publish("/b", pose_stamped((-0.4, 0.3, 0.2), (0.4, -0.3, 0.8)))
    scene.publish("/c", pose_stamped((-0.2, -0.5, 0.1), (0.4, -0.3, 0.8)))
    scene.publish("/d", pose_stamped((0.4, -0.4, 0.2), (0.4, -0.3, 0.8)))
    scene.publish("/e", pose_stamped((0, 0, 0.1), (0.4, -0.3, 0.8)))
    scene.publish("/f", pose_stamped((-0.8, 0, 0.3), (0.4, -0.3, 0.8)))


def pose_quaternion_unnormalized_nan_zero(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("Pose", {"Head Length": 0.2, "Shaft Length": 0.5}),
               display("Pose", {"Axes Length": 0.4, "Axes Radius": 0.05, "Shape": "Axes"}, name="q", topic="/q"))
    scene.publish("/p",
                  pose_stamped((0.5, 0.5, 0.1)),
                  pose_stamped((0, -0.2, 0.3), quaternion(
                      0.475931549217439, -0.11680243104051477, 0.8094309783959814, 1.762006766098087)),
                  pose_stamped((math.nan, 0, 0), (0.4, -0.3, 0.8)))
    scene.publish("/q", pose_stamped((-0.4, 0.4, 0.1), quaternion(0, 0, 0, 0)))


def posearray_3d(scene):
    scene.camera(**LARGE)
    scene.show(display("PoseArray",
                       {"Color": "0; 200; 255", "Head Length": 0.06, "Head Radius": 0.03, "Shaft Length": 0.12,
                        "Shaft Radius": 0.015, "Shape": "Arrow (3D)"}, name="p", topic="/p"))
    scene.publish("/p", rising_poses())


def posearray_3d_translucent(scene):
    scene.show(display("Grid", {"Alpha": 0.4, "Cell Size": 0.4, "Plane Cell Count": 6}),
               display("PoseArray",
                       {"Alpha": 0.45, "Color": "255; 200; 0", "Head Length": 0.15, "Head Radius": 0.12, "Shaft Length": 0.2,
                        "Shaft Radius": 0.05, "Shape": "Arrow (3D)"}, name="a", topic="/a"))
    scene.publish("/a", turning_poses())


def posearray_axes_rotated_frame(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("PoseArray", {"Shape": "Axes"}, name="a", topic="/a"))
    scene.publish("/a", turning_poses(), PoseArray(header=header("sensor"), poses=[
        pose((0.5, 0, 0.1), (0, -0.3, 0)),
        pose((0.38242109364224425, 0.3221088436188455, 0.15), (0.2, -0.3, 0.7)),
        pose((0.08498357145012052, 0.49272486499423007, 0.2), (0.4, -0.3, 1.4)),
        pose((-0.2524230523, 0.43160468332443697, 0.25), (0.6, -0.3, 2.1)),
        pose((-0.47111117033432903, 0.16749407507795255, 0.3), (0.8, -0.3, 2.8))]))


def posearray_flat(scene):
    scene.camera(**LARGE)
    scene.show(display("PoseArray", {"Arrow Length": 0.2, "Color": "255; 25; 0", "Shape": "Arrow (Flat)"}, name="p", topic="/p"))
    scene.publish("/p", rising_poses())


def posearray_flat_alpha_without_effect(scene):
    scene.frame("sensor", at=(0.2, -0.1, 0.2), turned=(0.3, -0.2, 0.7))
    scene.show(display("PoseArray", {"Alpha": 0.3, "Arrow Length": 0.5, "Color": "90; 255; 180"}, name="a", topic="/a"))
    scene.publish("/a", PoseArray(header=header("sensor"), poses=[
        pose((0.5, 0, 0.1), quaternion(0, -0.22415719871039883, 0, 1.4831566169040633)),
        pose((0.38242109364224425, 0.3221088436188455, 0.15), quaternion(
            0.21557061247198675, -0.15874280143120936, 0.5270520532322402, 1.3786029766455257)),
        pose((0.08498357145012052, 0.49272486499423007, 0.2), quaternion(
            0.3668941903898539, 0.021796324042355965, 0.9704906645597298, 1.0830796107945289)),
        pose((-0.2524230523, 0.43160468332443697, 0.25), quaternion(
            0.40384158337378, 0.2736413588125088, 1.2620243856614086, 0.6475545013984124)),
        pose((-0.47111117033432903, 0.16749407507795255, 0.3), quaternion(
            0.3016260171, 0.534072781971368, 1.3610374974, 0.14616750676531537)),
        pose((-0.46822834364539817, -0.17539161384480992, 0.35), quaternion(
            0.06682201748132015, 0.7347400877391072, 1.2615931011247397, -0.33774941694001215)),
        pose((-0.2451304106703501, -0.4357878862067939, 0.4), quaternion(
            -0.26308701687336467, 0.8162964770610874, 0.992758590912237, -0.727238381316801)),
        pose((0.09325618471128744, -0.4912263063121663, 0.45), quaternion(
            -0.6265957721031249, 0.7414208980881469, 0.612241962521904, -0.9658325784461725)),
        pose((0, 0, 0.1), quaternion(0, 0, 0, 0))]))
