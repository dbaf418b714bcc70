"""Makes the golden files of tests/tests/architecture/flip.rs with NVIDIA's own HDR-FLIP:

    pip install flip-evaluator==1.7 numpy
    python tests/golden/flip/make.py

Each file holds an image (image.R, .G, .B) and a reference (reference.R, .G, .B) as half floats, and NVIDIA's error map
(flip). Made once; nothing runs this again.
"""

import os
import struct

import flip_evaluator
import numpy as np


def noise(width, height):
    """Independent pixels over 12 stops, and the same with other noise."""
    random = np.random.default_rng(1)
    reference = np.exp2(random.uniform(-9, 3, (height, width, 3)))
    return reference * random.uniform(0.8, 1.25, reference.shape), reference


def structure(width, height):
    """A gradient with edges and bright points; the image is shifted by a pixel, 3 % brighter and more yellow."""
    def at(x, y):
        base = 0.02 + 0.6 * x / width
        wall = np.where((x // 9 + y // 7) % 2 == 0, 1.0, 0.3)
        point = np.where((x % 11 == 5) & (y % 8 == 3), 40.0, 0.0)
        return np.stack([base * wall + point, base * wall * 0.8 + point, base * 0.5 + 0.2 * point], -1)

    y, x = np.mgrid[0:height, 0:width].astype(np.float64)
    return at(x + 1, y) * [1.03, 1.03, 0.9], at(x, y)


def write(name, image, reference):
    image, reference = (np.ascontiguousarray(p.astype(np.float16)) for p in (image, reference))
    parameters = {}
    pair = (p.astype(np.float32) for p in (reference, image))
    error, mean, parameters = flip_evaluator.evaluate(*pair, "HDR", applyMagma=False, parameters=parameters)
    error = np.squeeze(error).astype(np.float32)
    print(name, "mean", mean, parameters)
    channels = {"flip": error.reshape(image.shape[:2])}
    for prefix, pixels in (("image", image), ("reference", reference)):
        for channel, letter in enumerate("RGB"):
            channels[f"{prefix}.{letter}"] = pixels[..., channel]
    exr(os.path.join(os.path.dirname(os.path.abspath(__file__)), name), channels)


def exr(path, channels):
    """Writes an uncompressed scan-line EXR file."""
    names = sorted(channels)
    height, width = channels[names[0]].shape
    kind = {np.dtype(np.float16): 1, np.dtype(np.float32): 2}
    text = lambda value: value.encode() + b"\0"
    attribute = lambda name, type, data: text(name) + text(type) + struct.pack("<i", len(data)) + data
    rows = [text(n) + struct.pack("<iBxxxii", kind[channels[n].dtype], 0, 1, 1) for n in names]
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2)
    header += attribute("channels", "chlist", b"".join(rows) + b"\0")
    header += attribute("compression", "compression", b"\0")
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    lines = [b"".join(channels[n][y].tobytes() for n in names) for y in range(height)]
    first = len(header) + 8 * height
    offsets = [first + sum(8 + len(line) for line in lines[:y]) for y in range(height)]
    with open(path, "wb") as file:
        file.write(header + struct.pack(f"<{height}Q", *offsets))
        for y, line in enumerate(lines):
            file.write(struct.pack("<ii", y, len(line)) + line)


write("noise.exr", *noise(41, 30))
write("structure.exr", *structure(48, 31))
write("small.exr", *noise(7, 3))
