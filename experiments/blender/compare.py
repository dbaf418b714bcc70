"""Renders the scenes of scenes.py, compares them with Cycles' images, and makes the picture of docs/blender.md.

    python compare.py OUTPUT [--caustics PROGRAM] [--frames N]

Prints per scene the median ratio of the pixels' radiances, and the ratio of the images' means. Writes OUTPUT/blender.webp: Cycles on
the left, ours on the right.
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SCENES = ["glass-ball", "ring", "window"]


def radiance(path):
    channels = OpenEXR.File(str(path)).channels()
    layer = channels.get("RGB") or channels["RGBA"]
    return np.asarray(layer.pixels, float)[..., :3]


def shown(image, white):
    """Tone mapped and in sRGB's gamma."""
    scaled = image / white
    return np.clip(scaled / (1 + 0.3 * scaled), 0, 1) ** (1 / 2.2)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("output", type=Path)
    parser.add_argument("--caustics", default=str(ROOT / "target/release/caustics"), help="our program")
    parser.add_argument("--frames", default="256")
    options = parser.parse_args()
    rows = []
    print("scene median_ratio mean_ratio")
    for name in SCENES:
        ours = options.output / f"{name}.exr"
        scene = options.output / f"{name}.glb"
        size = ["--width", "320", "--height", "180", "--max-bounces", "12"]
        command = [options.caustics, "render", scene, "-o", ours, "--frames", options.frames, *size, "--force"]
        subprocess.run([*command, "--preset", "final", "--runner", "cpu"], check=True)
        cycles, image = radiance(options.output / f"{name}-cycles.exr"), radiance(ours)
        lit = cycles.min(axis=-1) > 0
        median = np.median(image[lit].mean(axis=-1) / cycles[lit].mean(axis=-1))
        print(name, f"{median:.4f} {image.mean() / cycles.mean():.4f}")
        white = 4 * np.median(cycles[lit])
        rows.append(np.concatenate([shown(cycles, white), shown(image, white)], axis=1))
    pixels = (np.concatenate(rows, axis=0) * 255).astype("uint8")
    Image.fromarray(pixels).save(options.output / "blender.webp", quality=90)


main()
