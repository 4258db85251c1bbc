"""Markers of meshes: STL, Collada, OBJ with textures, PLY, glTF."""

from ..displays import display
from ..messages import CUBE, MESH, header, marker, markers
from ..scene import LARGE, Scene, family


def marker_mesh_dae(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(MESH, at=(-0.4, 0, 0.1), turned=(0, 0, 0.3), size=1, paint=(0.3, 0.7, 1), header=header(), mesh="gear.dae"),
        marker(MESH, at=(0.5, 0, 0.1), turned=(0.2, 0, 0), size=(1.2, 0.8, 1), header=header(), id=1, mesh="gear.dae",
               mesh_use_embedded_materials=True))


def marker_mesh_dae_close_up(scene):
    scene.camera(eye=(0.8, 0.5, 0.7), target=(0, 0, 0.1))
    scene.show_markers(marker(
        MESH, at=(0, 0, 0.1), turned=(0.3, -0.2, 0.4), size=1.5, id=8, mesh="gear.dae", mesh_use_embedded_materials=True))


def marker_mesh_embedded_tint_changes(scene):
    scene.show(display("MarkerArray"))
    scene.publish("/m",
                  markers(marker(MESH, at=(-0.4, -0.2, 0.2), turned=(0.4, 0.3, 0.8), size=1, paint=(1, 0.2, 0.2), id=1,
                                 mesh="gear.dae", mesh_use_embedded_materials=True),
                          marker(MESH, at=(0.4, -0.2, 0.2), turned=(0.4, 0.3, 0.8), size=1, id=2, mesh="gear.dae",
                                 mesh_use_embedded_materials=True),
                          marker(MESH, at=(0, 0.5, 0.2), turned=(0.4, 0.3, 0.8), size=1, id=3, mesh="crate.obj",
                                 mesh_use_embedded_materials=True)),
                  markers(marker(MESH, at=(-0.4, -0.2, 0.2), turned=(0.4, 0.3, 0.8), size=1, id=1, mesh="gear.dae",
                                 mesh_use_embedded_materials=True),
                          marker(MESH, at=(0.4, -0.2, 0.2), turned=(0.4, 0.3, 0.8), size=1, paint=(0.2, 0.4, 1, 0.8), id=2,
                                 mesh="gear.dae", mesh_use_embedded_materials=True),
                          marker(MESH, at=(0, 0.6, 0.3), turned=(0.4, 0.3, 0.8), size=(1, 1, 1.5), id=3, mesh="crate.obj",
                                 mesh_use_embedded_materials=True)))


def marker_mesh_obj_texture_close_up(scene):
    scene.camera(eye=(0.7, 0.6, 0.7), target=(0, 0, 0.2))
    scene.show_markers(marker(
        MESH, at=(0, 0, 0.2), turned=(0.2, 0.3, 0.4), size=1.5, id=58, mesh="crate.obj", mesh_use_embedded_materials=True))


def marker_mesh_obj_texture_minified(scene):
    scene.camera(eye=(2.4, 1.8, 1.2))
    scene.show_markers(*(marker(
        MESH, at=(-1.2 * i, 0.3 - 0.8 * i, 0.2), turned=(0, 0, 0.3 * i), size=1, id=59 + i, mesh="crate.obj",
        mesh_use_embedded_materials=True) for i in range(6)))


def marker_mesh_stl(scene):
    scene.camera(**LARGE)
    scene.show_markers(
        marker(MESH, at=(-0.4, 0, 0.1), turned=(0, 0, 0.3), size=1, paint=(0.3, 0.7, 1), header=header(), mesh="cone.stl"),
        marker(MESH, at=(0.5, 0, 0.1), turned=(0.2, 0, 0), size=(1.2, 0.8, 1), header=header(), id=1, mesh="cone.stl",
               mesh_use_embedded_materials=True))


def of_mesh(name, place, number, **rest):
    """A marker of a mesh file with its own materials."""
    return marker(MESH, at=place, size=1, id=number, mesh=name, mesh_use_embedded_materials=True, **rest)


def marker_mesh_ply(scene):
    scene.camera(eye=(1.5, 0.4, 1.1), target=(0, 0, 0.2))
    scene.show_markers(
        of_mesh("gem.ply", (0, -0.45, 0.3), 1, turned=(0.3, 0.2, 0.5)),
        of_mesh("bowl.ply", (0, 0.05, 0.25), 2, turned=(0.2, 0.4, 0)),
        of_mesh("gem.ply", (0, 0.5, 0.3), 3, turned=(3, 0.2, 0.5), paint=(0.2, 0.6, 1)),
        marker(MESH, at=(-0.5, 0.3, 0.2), size=1, paint=(0.9, 0.8, 0.1), id=4, mesh="bowl.ply"))


def marker_mesh_gltf(scene):
    scene.camera(eye=(1.1, 0.5, 0.8), target=(0, 0, 0.15))
    scene.show_markers(of_mesh("tower.gltf", (0, 0, 0.1), 1, turned=(0, 0, 0.4)))


family(Scene.show_markers, {
    "marker_mesh_dae_embedded_tint_and_alpha": [
        marker(MESH, at=(-0.4, -0.2, 0.2), turned=(0.4, 0.3, 0.8), size=1, paint=(1, 0.2, 0.2), id=55, mesh="gear.dae",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0.4, -0.2, 0.2), turned=(0.5, 0, 0), size=1, paint=(0.2, 0.4, 1), id=56, mesh="gear.dae",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0, 0.5, 0.1), turned=(0, 0, 0.2), size=1, paint=(1, 1, 1, 0.6), id=57, mesh="gear.dae")],
    "marker_mesh_embedded_translucent_overlapping": [
        marker(MESH, at=(-0.2, -0.1, 0.2), turned=(0.4, 0.3, 0.8), size=1, paint=(1, 0.2, 0.2, 0.5), mesh="gear.dae",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0.2, 0.1, 0.2), turned=(0.5, 0.1, 0), size=1, paint=(0.2, 0.4, 1, 0.3), id=1, mesh="gear.dae",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0.1, 0.4, 0.1), turned=(0, 0, 0.2), size=1, paint=(0, 1, 0, 0.7), id=2, mesh="crate.obj",
               mesh_use_embedded_materials=True),
        marker(CUBE, at=(0.3, 0.3, 0.3), turned=(0.4, 0.3, 0.8), size=0.3, paint=(1, 1, 0, 0.5), id=3)],
    "marker_mesh_file_missing": [
        marker(MESH, at=(0, 0, 0.2), size=1, paint=(1, 1, 1), id=66, mesh="none.stl"),
        marker(CUBE, at=(0, 0, 0.2), size=0.4, paint=(0.7, 0.2, 0.9), id=67)],
    "marker_mesh_obj_tinted_textured_translucent": [
        marker(MESH, at=(-0.4, -0.3, 0.2), turned=(0, 0, 0.4), size=1, paint=(0.9, 0.4, 0.2), id=6, mesh="crate.obj"),
        marker(MESH, at=(0.35, -0.25, 0.2), turned=(0.2, 0.1, 0.9), size=(1, 0.7, 1.3), id=7, mesh="crate.obj",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0, 0.45, 0.2), turned=(0, 0, 0.2), size=(1.2, 1, 1), paint=(0.2, 0.6, 1, 0.5), id=8, mesh="crate.obj",
               mesh_use_embedded_materials=True)],
    "marker_mesh_obj_tints_opaque_and_translucent": [
        marker(MESH, at=(-0.45, -0.3, 0.2), turned=(0, 0, 0.3), size=0.8, paint=(1, 0, 0), id=37, mesh="crate.obj",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0.35, -0.3, 0.2), turned=(0, 0, 0.7), size=0.8, paint=(0, 1, 0, 0.3), id=38, mesh="crate.obj",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0, 0.4, 0.2), turned=(0.3, 0, 1), size=0.8, paint=(0.3, 0.3, 1, 0.9), id=39, mesh="crate.obj")],
    "marker_mesh_obj_without_embedded_materials": [marker(
        MESH, at=(0, 0, 0.2), turned=(0.2, 0.3, 0.4), size=1.5, paint=(0.8, 0.8, 0.3), id=65, mesh="crate.obj")],
    "marker_mesh_stl_embedded_materials_absent": [
        marker(MESH, at=(-0.3, 0, 0.1), turned=(0.4, 0.3, 0.8), size=1, paint=(0.9, 0.6, 0.1), id=68, mesh="cone.stl",
               mesh_use_embedded_materials=True),
        marker(MESH, at=(0.4, 0, 0.1), turned=(0.4, 0.3, 0.8), size=1, id=69, mesh="cone.stl", mesh_use_embedded_materials=True),
        marker(MESH, at=(0, 0.6, 0.1), turned=(0.4, 0.3, 0.8), size=1, paint=(0.2, 0.6, 1, 0.5), id=70, mesh="cone.stl",
               mesh_use_embedded_materials=True)],
    "marker_mesh_stl_translucent_unequal_scale": [
        marker(MESH, at=(-0.3, -0.2, 0.1), turned=(0.4, 0.3, 0.8), size=(1, 1, 2), paint=(0.9, 0.3, 0.3, 0.5), id=53,
               mesh="cone.stl"),
        marker(MESH, at=(0.4, 0.2, 0.1), size=(1.5, 0.5, 1), paint=(0.4, 0.9, 0.5), id=54, mesh="cone.stl")]})
