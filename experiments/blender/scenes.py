"""Three scenes made in Blender: exported as glTF, and rendered by Cycles for comparison.

    python scenes.py OUTPUT [--samples N]

Writes OUTPUT/NAME.glb and OUTPUT/NAME-cycles.exr. Lights, camera and materials are those that a person would set in Blender.
What the export needs besides is in `solid` and in the options of `export`; docs/blender.md explains both.
"""

import argparse
import math
from pathlib import Path

import bpy
from mathutils import Vector

SIZE = (320, 180)


def reset():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.cycles.device = "CPU"
    # Bounces as `caustics render --max-bounces 12`, and no clamping or blurring that would change the light.
    cycles = scene.cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 12
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.use_denoising = False
    cycles.use_adaptive_sampling = False
    # Cycles' filter is wider than a pixel by default.
    cycles.pixel_filter_type = "BOX"
    return scene


def material(name, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made


def solid(made, thickness):
    """Marks transmitting glass as solid: the exporter writes KHR_materials_volume where this group has a thickness."""
    tree = bpy.data.node_groups.get("glTF Material Output")
    if tree is None:
        tree = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
        tree.interface.new_socket("Thickness", in_out="INPUT", socket_type="NodeSocketFloat")
    group = made.node_tree.nodes.new("ShaderNodeGroup")
    group.node_tree = tree
    group.inputs["Thickness"].default_value = thickness
    return made


def place(made, smooth=False):
    """Gives the mesh that was just added a material."""
    bpy.context.object.data.materials.append(made)
    if smooth:
        bpy.ops.object.shade_smooth()


def plane(made, size, location=(0, 0, 0), rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    place(made)


def camera(scene, location, target, fov):
    bpy.ops.object.camera_add(location=location)
    made = bpy.context.object
    made.data.sensor_fit = "VERTICAL"
    made.data.angle = math.radians(fov)
    made.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = made


def light(kind, location, rotation=(0, 0, 0), **settings):
    bpy.ops.object.light_add(type=kind, location=location, rotation=rotation)
    data = bpy.context.object.data
    for key, value in settings.items():
        setattr(data, key, value)


def glass_ball(scene):
    """A solid glass ball on a floor, a square emitter above it."""
    plane(material("floor", Base_Color=(0.6, 0.6, 0.6, 1), Roughness=1.0, Specular_IOR_Level=0.0), 4)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.3, location=(0, 0, 0.32))
    glass = material("glass", Base_Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5, Transmission_Weight=1.0)
    place(solid(glass, 0.6), smooth=True)
    glow = material("glow", Base_Color=(0, 0, 0, 1), Emission_Color=(1, 1, 1, 1), Emission_Strength=40.0)
    plane(glow, 0.3, (0.5, 0, 1.8), (math.pi, 0, 0))
    camera(scene, (0.2, -1.9, 1.1), (0.1, 0, 0.1), 35)


def ring(scene):
    """A gold ring in the sun."""
    plane(material("floor", Base_Color=(0.6, 0.55, 0.5, 1), Roughness=1.0, Specular_IOR_Level=0.0), 4)
    bpy.ops.mesh.primitive_cylinder_add(vertices=256, radius=0.4, depth=0.3, location=(0, 0, 0.15), end_fill_type="NOTHING")
    gold = material("gold", Base_Color=(1.0, 0.77, 0.34, 1), Metallic=1.0, Roughness=0.05)
    place(gold, smooth=True)
    light("SUN", (0, 0, 2), (math.radians(50), 0, math.radians(30)), energy=3.0, angle=0.0)
    camera(scene, (0, -1.7, 1.3), (0, 0, 0.05), 35)


def window(scene):
    """A pane before a lamp, a mirror, and a spot light. A single plane of glass is solid behind it in Cycles, a thin wall in glTF."""
    wall = material("wall", Base_Color=(0.7, 0.68, 0.64, 1), Roughness=1.0, Specular_IOR_Level=0.0)
    plane(wall, 4)
    plane(wall, 4, (0, 2, 1), (math.pi / 2, 0, 0))
    pane = material("pane", Base_Color=(1, 1, 1, 1), Roughness=0.0, IOR=1.5, Transmission_Weight=1.0)
    plane(pane, 1.0, (-0.6, 0.6, 0.7), (math.pi / 2, 0, math.radians(30)))
    mirror = material("mirror", Base_Color=(0.9, 0.9, 0.9, 1), Metallic=1.0, Roughness=0.0)
    plane(mirror, 0.9, (0.8, 1.4, 0.6), (math.pi / 2, 0, math.radians(-35)))
    light("POINT", (-1.0, 1.4, 1.2), energy=20.0, shadow_soft_size=0.0)
    spot = {"spot_size": math.radians(40), "spot_blend": 0.3}
    light("SPOT", (0.2, -0.8, 2.0), (math.radians(25), 0, 0), energy=60.0, shadow_soft_size=0.0, **spot)
    camera(scene, (0, -2.2, 1.2), (0, 0.8, 0.5), 40)


def export(path):
    bpy.ops.export_scene.gltf(
        filepath=str(path),
        export_format="GLB",
        export_cameras=True,
        export_lights=True,
        # "Unitless" in the dialog: W sr^-1 instead of candela, as caustics reads the numbers.
        export_import_convert_lighting_mode="COMPAT",
        export_apply=True,
    )


def render(scene, path, samples):
    scene.cycles.samples = samples
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("output", type=Path)
    parser.add_argument("--samples", type=int, default=4096)
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    for make in (glass_ball, ring, window):
        scene = reset()
        make(scene)
        name = make.__name__.replace("_", "-")
        export(options.output / f"{name}.glb")
        render(scene, options.output / f"{name}-cycles.exr", options.samples)


main()
