"""A scene of this project as other renderers take it: triangles, what they are made of, and a camera.

Read is what the scenes of the comparison hold: positions and normals, materials of plain factors that are diffuse, metal or
clear glass, emission, one camera. What would be dropped without a word is refused.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
LANES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}
KNOWN = {
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
}


@dataclass
class Material:
    """A surface: `kind` is diffuse, metal or glass."""

    name: str
    kind: str
    color: np.ndarray
    roughness: float
    ior: float
    emission: np.ndarray


@dataclass
class Mesh:
    """Triangles in the world, right-handed, y up, metres."""

    name: str
    points: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    material: Material


@dataclass
class Camera:
    """Columns of `pose`: right, up, backwards, position; `fov_y` in radians."""

    pose: np.ndarray
    fov_y: float


@dataclass
class Scene:
    name: str
    meshes: list
    camera: Camera


def load(folder):
    folder = Path(folder)
    document = json.loads((folder / "scene.gltf").read_text())
    unknown = set(document.get("extensionsUsed", [])) - KNOWN
    if unknown:
        raise SystemExit(f"{folder.name}: {', '.join(sorted(unknown))} cannot be given to other renderers")
    buffers = [(folder / buffer["uri"]).read_bytes() for buffer in document["buffers"]]

    def values(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        lanes, kind = LANES[accessor["type"]], COMPONENTS[accessor["componentType"]]
        if view.get("byteStride", 0) not in (0, lanes * np.dtype(kind).itemsize):
            raise SystemExit(f"{folder.name}: interleaved vertices are not read")
        flat = np.frombuffer(buffers[view["buffer"]], kind, accessor["count"] * lanes, start)
        return flat.reshape(-1, lanes)

    materials = [material(source) for source in document["materials"]]
    meshes, camera = [], None
    for node in document["nodes"]:
        pose = transform(node)
        if "children" in node:
            raise SystemExit(f"{folder.name}: nodes below nodes are not read")
        if "camera" in node:
            camera = Camera(pose, document["cameras"][node["camera"]]["perspective"]["yfov"])
        for primitive in document["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            points = values(primitive["attributes"]["POSITION"]) @ pose[:3, :3].T + pose[:3, 3]
            normals = values(primitive["attributes"]["NORMAL"]) @ np.linalg.inv(pose[:3, :3])
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            triangles = values(primitive["indices"]).reshape(-1, 3).astype(np.uint32)
            name = f"mesh{len(meshes)}"
            meshes.append(Mesh(name, points, normals, triangles, materials[primitive["material"]]))
    return Scene(folder.name, meshes, camera)


def transform(node):
    if "matrix" in node:
        return np.array(node["matrix"]).reshape(4, 4).T
    pose = np.eye(4)
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    pose[:3, :3] = rotation * np.array(node.get("scale", [1, 1, 1]))
    pose[:3, 3] = node.get("translation", [0, 0, 0])
    return pose


def material(source):
    of = source.get("pbrMetallicRoughness", {})
    extensions = source.get("extensions", {})
    if any("Texture" in key for key in [*of, *source]):
        raise SystemExit(f"material {source['name']}: textures are not read")
    transmission = extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0)
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    roughness = of.get("roughnessFactor", 1.0)
    kinds = {
        "metal": of.get("metallicFactor", 1.0) == 1.0,
        "glass": transmission == 1.0 and roughness == 0.0 and of.get("metallicFactor", 1.0) == 0.0,
        "diffuse": specular == 0.0 and of.get("metallicFactor", 1.0) == 0.0,
    }
    kind = next((kind for kind, fits in kinds.items() if fits), None)
    color = np.array(of.get("baseColorFactor", [1, 1, 1, 1])[:3])
    volume = extensions.get("KHR_materials_volume", {})
    if kind is None or (kind == "glass" and (color.min() < 1.0 or "attenuationDistance" in volume)):
        raise SystemExit(f"material {source['name']} is neither diffuse, metal nor clear glass")
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    emission = np.array(source.get("emissiveFactor", [0, 0, 0])) * strength
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    return Material(source["name"], kind, color, roughness, ior, emission)


def conductor(reflectance):
    """Index and extinction of a conductor that reflects nearly as glTF's metal of this colour does: the same head on, and by
    least squares at the other angles (Schlick's curve)."""
    cos = np.linspace(0.02, 1.0, 99)
    target = reflectance + (1 - reflectance) * (1 - cos) ** 5
    # Head on ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2) is given: of n there is a choice, k follows.
    least = (1 - np.sqrt(reflectance)) / (1 + np.sqrt(reflectance))
    n = np.geomspace(least * 1.0001, (1 / least) * 0.9999, 2000)[:, None]
    k2 = np.maximum((reflectance * (n + 1) ** 2 - (n - 1) ** 2) / (1 - reflectance), 0.0)
    sin2 = 1 - cos**2
    inner = n**2 - k2 - sin2
    a2b2 = np.sqrt(inner**2 + 4 * n**2 * k2)
    a = np.sqrt(np.maximum(0.5 * (a2b2 + inner), 0.0))
    s = (a2b2 + cos**2 - 2 * a * cos) / (a2b2 + cos**2 + 2 * a * cos)
    p = s * (cos**2 * a2b2 + sin2**2 - 2 * a * cos * sin2) / (cos**2 * a2b2 + sin2**2 + 2 * a * cos * sin2)
    best = np.argmin(((0.5 * (s + p) - target) ** 2).mean(axis=1))
    return float(n[best, 0]), float(np.sqrt(k2[best, 0]))
