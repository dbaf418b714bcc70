"""The peers: each renders a scene for some seconds and hands its image over at the budgets.

Seconds are processor seconds over the threads: what other programs do at the same time does not count. Loading, building of
trees and compilation do not count either; caches of light that a renderer makes while it renders do.
"""

import os
import time

import numpy as np

from gltf import conductor

BOUNCES = 5


def mitsuba(scene, size, budgets, seed, threads):
    """Mitsuba's path tracer, compiled for vectors (LLVM)."""
    import drjit
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    drjit.set_thread_count(threads)

    def bsdf(material):
        rgb = {"type": "rgb", "value": material.color.tolist()}
        if material.kind == "diffuse":
            return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb}}
        if material.kind == "glass":
            return {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0}
        eta, k = zip(*map(conductor, material.color))
        spectrum = lambda values: {"type": "srgb", "color": mi.ScalarColor3d(values), "unbounded": True}
        of = {"eta": spectrum(eta), "k": spectrum(k)}
        of["type"] = "conductor"
        if material.roughness > 0.0:
            of |= {"type": "roughconductor", "distribution": "ggx", "alpha": material.roughness**2}
        return {"type": "twosided", "bsdf": of}

    pose = scene.camera.pose
    eye, forward, up = pose[:3, 3], -pose[:3, 2], pose[:3, 1]
    look_at = mi.ScalarTransform4f().look_at(origin=eye.tolist(), target=(eye + forward).tolist(), up=up.tolist())
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    world = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": BOUNCES + 1},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": float(np.degrees(scene.camera.fov_y)),
            "near_clip": 0.01,
            "far_clip": 1e4,
            "to_world": look_at,
            "film": film,
        },
    }
    for mesh in scene.meshes:
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf(mesh.material))
        if mesh.material.emission.any():
            radiance = {"type": "rgb", "value": mesh.material.emission.tolist()}
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
        shape = mi.Mesh(mesh.name, len(mesh.points), len(mesh.triangles), has_vertex_normals=True, props=properties)
        params = mi.traverse(shape)
        params["vertex_positions"] = mesh.points.astype(np.float32).ravel()
        params["vertex_normals"] = mesh.normals.astype(np.float32).ravel()
        params["faces"] = mesh.triangles.ravel()
        params.update()
        world[mesh.name] = shape
    world = mi.load_dict(world)

    spp, passes = 4, 0
    draw = lambda index: np.array(mi.render(world, spp=spp, seed=seed * 100003 + index), np.float64)
    draw(0)  # compiles
    total, start, images = 0.0, time.process_time(), []
    for budget in budgets:
        while time.process_time() - start < budget * threads:
            passes += 1
            total = total + draw(passes)
        images.append((total / passes, (time.process_time() - start) / threads, passes * spp))
    return images, f"Mitsuba {mi.__version__}"


def luxcore(scene, size, budgets, seed, threads, engine):
    """LuxCore: path tracing with a cache of caustics (PhotonGI), or bidirectional path tracing."""
    import pyluxcore as lux

    lux.Init()
    world, properties = lux.Scene(), lux.Properties()

    def give(key, value):
        properties.Set(lux.Property(f"scene.{key}", value))

    pose = scene.camera.pose
    eye, forward = pose[:3, 3], -pose[:3, 2]
    give("camera.type", "perspective")
    give("camera.lookat.orig", eye.tolist())
    give("camera.lookat.target", (eye + forward).tolist())
    give("camera.up", pose[:3, 1].tolist())
    # Its field of view is that of the longer side.
    half = np.tan(scene.camera.fov_y / 2) * max(size[0] / size[1], 1.0)
    give("camera.fieldofview", float(np.degrees(2 * np.arctan(half))))
    give("camera.cliphither", 0.01)
    for mesh in scene.meshes:
        points, triangles, normals = mesh.points.tolist(), mesh.triangles.tolist(), mesh.normals.tolist()
        rows = [list(map(tuple, of)) for of in (points, triangles, normals)]
        world.DefineMesh(mesh.name, *rows, None, None, None)
        material, name = mesh.material, f"materials.{mesh.name}"
        if material.kind == "diffuse":
            give(f"{name}.type", "matte")
            give(f"{name}.kd", material.color.tolist())
        elif material.kind == "glass":
            give(f"{name}.type", "glass")
            give(f"{name}.kr", [1.0, 1.0, 1.0])
            give(f"{name}.kt", [1.0, 1.0, 1.0])
            give(f"{name}.interiorior", material.ior)
            give(f"{name}.exteriorior", 1.0)
        elif material.roughness < 0.05:
            # Its metals are rough: what is nearly smooth is a mirror, without a Fresnel term.
            give(f"{name}.type", "mirror")
            give(f"{name}.kr", material.color.tolist())
        else:
            eta, k = zip(*map(conductor, material.color))
            give(f"textures.{mesh.name}.type", "fresnelconst")
            give(f"textures.{mesh.name}.n", list(eta))
            give(f"textures.{mesh.name}.k", list(k))
            give(f"{name}.type", "metal2")
            give(f"{name}.fresnel", mesh.name)
            give(f"{name}.uroughness", material.roughness**2)
            give(f"{name}.vroughness", material.roughness**2)
        if material.emission.any():
            give(f"{name}.emission", material.emission.tolist())
            give(f"{name}.emission.normalizebycolor", False)
        give(f"objects.{mesh.name}.ply", mesh.name)
        give(f"objects.{mesh.name}.shape", mesh.name)
        give(f"objects.{mesh.name}.material", mesh.name)
    world.Parse(properties)

    settings = {
        "film.width": size[0],
        "film.height": size[1],
        "film.filter.type": "NONE",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "unused.exr",
        "native.threads.count": threads,
        "renderengine.seed": seed + 1,
        "sampler.type": "SOBOL",
        "path.pathdepth.total": BOUNCES + 1,
        "path.pathdepth.diffuse": BOUNCES,
        "path.pathdepth.glossy": BOUNCES,
        "path.pathdepth.specular": BOUNCES,
        "path.clamping.variance.maxvalue": 0.0,
    }
    if engine == "bidir":
        settings |= {
            "renderengine.type": "BIDIRCPU",
            "path.maxdepth": BOUNCES + 1,
            "light.maxdepth": BOUNCES + 1,
        }
    else:
        settings |= {
            "renderengine.type": "PATHCPU",
            "path.photongi.photon.maxcount": 200_000,
            "path.photongi.photon.maxdepth": BOUNCES,
            "path.photongi.photon.time.start": 0.0,
            "path.photongi.photon.time.end": -1.0,
            "path.photongi.caustic.enabled": True,
            "path.photongi.caustic.maxsize": 50_000,
            "path.photongi.caustic.lookup.radius": 0.05,
            "path.photongi.caustic.updatespp": 8,
            "path.photongi.indirect.enabled": False,
        }
    config = lux.Properties()
    for key, value in settings.items():
        config.Set(lux.Property(key, value))

    session = lux.RenderSession(lux.RenderConfig(config, world))
    start = time.process_time()
    session.Start()
    images, width, height = [], *size
    for budget in budgets:
        while time.process_time() - start < budget * threads:
            time.sleep(0.01)
        spent = (time.process_time() - start) / threads
        session.UpdateStats()
        samples = session.GetStats().Get("stats.renderengine.pass").GetInt()
        rgb = np.zeros((height, width, 3), np.float32)
        session.GetFilm().GetOutputFloat(lux.FilmOutputType.RGB, rgb, 0, False)
        # From the bottom up, and a row too low: found by shifting it over the reference of `ring`.
        upright = np.concatenate([rgb[::-1][1:], rgb[:1]]).astype(np.float64)
        images.append((upright, spent, samples))
    session.Stop()
    return images, f"LuxCore {lux.Version()}"


PEERS = {
    "mitsuba path": mitsuba,
    "luxcore photongi": lambda *of: luxcore(*of, "photongi"),
    "luxcore bidir": lambda *of: luxcore(*of, "bidir"),
}


def cores():
    return len(os.sched_getaffinity(0))
