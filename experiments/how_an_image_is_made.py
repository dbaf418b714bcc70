"""The images and times of docs/how-an-image-is-made.md.

    python experiments/how_an_image_is_made.py target/release/caustics docs/how-an-image-is-made

Renders one raw frame of `still-life`, 16 frames, and a reference of 256 frames at 480x270 on the CPU. Writes each layer as WebP, and prints the
milliseconds of the passes. Needs numpy, OpenEXR and Pillow.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

SIZE = ["--width", "480", "--height", "270", "--runner", "cpu"]
# Crop of the reference and of the frame: the mirror's upper right (left, top, right, bottom; px).
CROP = (200, 50, 320, 118)
CROP_SCALE = 2


def render(program, folder, name, *options):
    """Renders still-life; its channels by name, and what --json printed."""
    file = folder / f"{name}.exr"
    command = [program, "render", "still-life", "--output", file, "--json", "--force", *SIZE, *options]
    run = subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True)
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        channels = {key: np.array(channel.pixels) for key, channel in exr.channels().items()}
    return channels, json.loads(run.stdout)


def color(channels, layer):
    """A layer of three channels, as an array of rows, columns and channels."""
    names = [f"{layer}.{channel}" if layer else channel for channel in "RGB"]
    return np.stack([channels[name] for name in names], axis=-1)


def tone_mapped(radiance, exposure):
    """8-bit sRGB of radiance: x / (1 + x) after exposure."""
    exposed = np.maximum(radiance, 0.0) * exposure
    mapped = exposed / (1.0 + exposed)
    encoded = np.where(mapped <= 0.0031308, 12.92 * mapped, 1.055 * mapped ** (1 / 2.4) - 0.055)
    return (255.0 * np.clip(encoded, 0.0, 1.0) + 0.5).astype(np.uint8)


def gray(values, largest):
    """8-bit gray of values from 0 to the largest."""
    shares = np.clip(values / largest, 0.0, 1.0)
    return np.repeat((255.0 * shares + 0.5).astype(np.uint8)[..., None], 3, axis=-1)


def by_depth(depth):
    """A colour for the depth of each collection point: 1 grey, 2 blue, 3 green, 4 orange, deeper red; none black."""
    colors = [(0, 0, 0), (150, 150, 150), (70, 130, 220), (80, 180, 90), (240, 160, 50), (210, 60, 50)]
    return np.array(colors, np.uint8)[np.clip(depth, 0, len(colors) - 1).astype(int)]


def save(folder, name, pixels):
    Image.fromarray(pixels).save(folder / f"{name}.webp", quality=82, method=6)


def main():
    program, output = sys.argv[1], Path(sys.argv[2])
    output.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        frame, report = render(program, scratch, "frame", "--preset", "frame", "--aov", "normal,albedo")
        mean, _ = render(program, scratch, "mean", "--preset", "preview")
        reference, _ = render(
            program, scratch, "reference", "--method", "progressive", "--frames", "256", "--seed", "7", "--pixel-filter", "box",
            "--indirect-share", "none",
            "--indirect-end", "path",
        )
    image = color(reference, "")
    exposure = 0.35 / np.exp(np.log(image.mean(axis=-1) + 1e-4).mean())

    save(output, "depth", by_depth(frame["points.depth"]))
    save(output, "albedo", tone_mapped(color(frame, "albedo"), 1.0))
    save(output, "path", tone_mapped(color(frame, "path"), exposure))
    save(output, "photons", gray(np.log1p(frame["photons.count"]), np.log1p(frame["photons.count"]).max()))
    save(output, "caustics", tone_mapped(color(frame, "caustics"), exposure))
    save(output, "frame", tone_mapped(color(frame, ""), exposure))
    save(output, "mean", tone_mapped(color(mean, ""), exposure))

    # One frame, 16 frames and the reference, side by side, enlarged
    left, top, right, bottom = CROP
    crops = [tone_mapped(color(channels, ""), exposure)[top:bottom, left:right] for channels in (frame, mean, reference)]
    gap = np.full((bottom - top, 4, 3), 255, np.uint8)
    row = np.concatenate([crops[0], gap, crops[1], gap, crops[2]], axis=1)
    save(output, "crop", row.repeat(CROP_SCALE, axis=0).repeat(CROP_SCALE, axis=1))

    for name, ms in sorted(report["pass_ms"].items(), key=lambda item: -item[1]):
        print(f"{name} {ms:.2f} ms")
    print(f"frame {report['frame_ms']:.1f} ms, light paths {report.get('light_paths')}")
    for name, channels in (("frame", frame), ("mean", mean)):
        for layer in ("", "path", "caustics"):
            off = color(channels, layer) - color(reference, layer)
            relmse = (off**2 / (color(reference, layer) ** 2 + 0.01)).mean()
            energy = color(channels, layer).sum() / color(reference, layer).sum()
            print(f"{name} {layer or 'image'}: relMSE {relmse:.4f}, energy {energy:.3f}")


main()
