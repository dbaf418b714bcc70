"""Two rooms that were used for no tuning, as folders with a scene.gltf.

    python rooms.py out/rooms
    python peers.py --scenes $PWD/out/rooms/corridor $PWD/out/rooms/gallery --output out

`corridor`: a lamp stands in the next room; its light comes through a door and over the walls. `gallery`: strips light the
ceiling from below, over glass balls and rough metal.
"""

import json
import sys
from pathlib import Path

import numpy as np

FLOAT, INTEGER = 5126, 5125


class Room:
    """A scene under construction: metres, y up."""

    def __init__(self):
        self.binary = b""
        self.document = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "extensionsUsed": [
                "KHR_materials_emissive_strength",
                "KHR_materials_ior",
                "KHR_materials_specular",
                "KHR_materials_transmission",
                "KHR_materials_volume",
            ],
        }
        for key in ["nodes", "meshes", "materials", "accessors", "bufferViews", "cameras"]:
            self.document[key] = []

    def add(self, key, entry):
        self.document[key].append(entry)
        return len(self.document[key]) - 1

    def material(self, name, color, metallic=0, roughness=1, emission=0, **extensions):
        return self.add("materials", {
            "name": name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [*color, 1],
                "metallicFactor": metallic,
                "roughnessFactor": roughness,
            },
            "emissiveFactor": [1, 1, 1] if emission else [0, 0, 0],
            "extensions": {f"KHR_materials_{name}": value for name, value in extensions.items()}
            | ({"KHR_materials_emissive_strength": {"emissiveStrength": emission}} if emission else {}),
        })

    def diffuse(self, name, color, emission=0):
        return self.material(name, color, emission=emission, specular={"specularFactor": 0})

    def metal(self, name, color, roughness):
        return self.material(name, color, metallic=1, roughness=roughness)

    def glass(self):
        return self.material(
            "glass", [1, 1, 1], roughness=0,
            transmission={"transmissionFactor": 1}, ior={"ior": 1.5}, volume={"thicknessFactor": 1},
        )

    def values(self, array, kind, component):
        data = np.ascontiguousarray(array, {FLOAT: np.float32, INTEGER: np.uint32}[component])
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.binary), "byteLength": data.nbytes})
        self.binary += data.tobytes()
        accessor = {"bufferView": view, "componentType": component, "count": len(data), "type": kind}
        if kind == "VEC3":
            accessor |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        return self.add("accessors", accessor)

    def mesh(self, material, points, normals, triangles):
        attributes = {
            "POSITION": self.values(points, "VEC3", FLOAT),
            "NORMAL": self.values(normals, "VEC3", FLOAT),
        }
        indices = self.values(np.ravel(triangles), "SCALAR", INTEGER)
        mesh = self.add("meshes", {
            "primitives": [{"attributes": attributes, "indices": indices, "material": material}]
        })
        self.node({"mesh": mesh})

    def node(self, node):
        self.document["scenes"][0]["nodes"].append(self.add("nodes", node))

    def panel(self, material, centre, right, up):
        """A parallelogram; its front is where right x up points."""
        centre, right, up = map(np.array, (centre, right, up))
        normal = np.cross(right, up)
        points = [centre + a * right + b * up for a, b in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]
        self.mesh(material, points, [normal / np.linalg.norm(normal)] * 4, [[0, 1, 2], [0, 2, 3]])

    def box(self, material, low, high, inwards=False, sides="xXyYzZ"):
        """A box, or some of its sides; a capital is the side of larger coordinates."""
        low, high = np.array(low), np.array(high)
        centre, half = 0.5 * (low + high), 0.5 * (high - low)
        for side in sides:
            axis, sign = "xyz".index(side.lower()), 1 if side.isupper() else -1
            out, right, up = (half * np.eye(3)[(axis + step) % 3] for step in range(3))
            self.panel(material, centre + sign * out, right * (sign if not inwards else -sign), up)

    def ball(self, material, centre, radius, columns=64, rows=32):
        theta, phi = np.meshgrid(
            np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns + 1), indexing="ij"
        )
        normals = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], axis=-1)
        normals = normals.reshape(-1, 3)
        first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
        next_row = first + columns + 1
        triangles = np.concatenate([
            np.stack([first, first + 1, next_row], axis=1)[columns:],
            np.stack([first + 1, next_row + 1, next_row], axis=1)[:-columns],
        ])
        self.mesh(material, np.array(centre) + radius * normals, normals, triangles)

    def camera(self, position, target, degrees):
        back = np.array(position, float) - target
        back /= np.linalg.norm(back)
        right = np.cross([0, 1, 0], back)
        right /= np.linalg.norm(right)
        pose = np.eye(4)
        pose[:3, :] = np.stack([right, np.cross(back, right), back, position], axis=1)
        self.add("cameras", {"type": "perspective", "perspective": {"yfov": np.radians(degrees), "znear": 0.01}})
        self.node({"camera": 0, "matrix": pose.T.ravel().tolist()})

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "scene.bin").write_bytes(self.binary)
        self.document["buffers"] = [{"uri": "scene.bin", "byteLength": len(self.binary)}]
        (folder / "scene.gltf").write_text(json.dumps(self.document, indent=1))


def corridor():
    room = Room()
    white, red = room.diffuse("white", [0.75, 0.75, 0.72]), room.diffuse("red", [0.6, 0.15, 0.1])
    lamp, wood = room.diffuse("lamp", [0.5] * 3, emission=200), room.diffuse("wood", [0.45, 0.3, 0.18])
    # The near room, whose wall to the next room has a door
    room.box(white, [-2, 0, -2], [2, 2.6, 2], inwards=True, sides="xyYZ")
    room.box(red, [-2, 0, -2], [2, 2.6, 2], inwards=True, sides="z")
    room.box(white, [2, 0, -2], [2.1, 2.6, -0.2])
    room.box(white, [2, 0, 0.8], [2.1, 2.6, 2])
    room.box(white, [2, 2.1, -0.2], [2.1, 2.6, 0.8])
    # The next room, with the lamp beside the door
    room.box(white, [2.1, 0, -2], [5, 2.6, 2], inwards=True, sides="XyYzZ")
    room.box(wood, [2, -0.05, -0.2], [2.1, 0, 0.8])
    room.panel(lamp, [3.2, 2.59, -1.2], [0.35, 0, 0], [0, 0, 0.35])
    # Objects in the near room
    room.box(wood, [-1.4, 0, -1.5], [0.2, 0.7, -0.7])
    room.ball(room.glass(), [-0.2, 0.95, -1.1], 0.25)
    room.box(room.metal("steel", [0.7, 0.7, 0.72], 0.3), [-1.2, 0.7, -1.4], [-0.7, 1.3, -1.0])
    room.ball(white, [0.9, 0.35, -0.6], 0.35)
    room.camera([-1.2, 1.5, 1.8], [0.3, 0.8, -1.0], 55)
    return room


def gallery():
    room = Room()
    white, floor = room.diffuse("white", [0.8] * 3), room.diffuse("floor", [0.35, 0.3, 0.25])
    blue, strip = room.diffuse("blue", [0.15, 0.25, 0.6]), room.diffuse("strip", [0.5] * 3, emission=12)
    room.box(white, [-2, 0, -5], [2, 3, 1], inwards=True, sides="XYZ")
    room.box(blue, [-2, 0, -5], [2, 3, 1], inwards=True, sides="x")
    room.box(floor, [-2, 0, -5], [2, 3, 1], inwards=True, sides="y")
    # The end wall is rough metal, which shows the room
    room.box(room.metal("plate", [0.8, 0.75, 0.7], 0.15), [-2, 0, -5], [2, 3, 1], inwards=True, sides="z")
    for side in [-1, 1]:
        # A ledge hides the strip from below
        room.box(white, [side * 2 - 0.35 * (side > 0), 2.2, -5], [side * 2 + 0.35 * (side < 0), 2.3, 1])
        room.panel(strip, [side * 1.85, 2.32, -2], [0, 0, 2.5], [0.05, 0, 0])
    glass, gold = room.glass(), room.metal("gold", [0.9, 0.7, 0.35], 0.2)
    for place, (material, x) in enumerate([(glass, -0.7), (gold, 0.7), (glass, 0.6), (white, -0.6)]):
        z = -1.2 - 0.8 * place
        room.box(white, [x - 0.2, 0, z - 0.2], [x + 0.2, 0.8, z + 0.2])
        room.ball(material, [x, 1.02, z], 0.22)
    room.camera([0, 1.5, 0.8], [0, 0.9, -3], 55)
    return room


if __name__ == "__main__":
    for make in [corridor, gallery]:
        make().write(Path(sys.argv[1]) / make.__name__)
