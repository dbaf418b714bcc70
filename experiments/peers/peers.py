"""Our renderer beside others at equal time: a table, and run results that `caustics report` draws.

    python peers.py --output results/peers

Each renderer works on a scene for the budgets (processor seconds over threads, without start and compilation), once a seed.
Its pictures are compared with one reference, many frames of our `progressive`, by `caustics compare`: over the whole picture and
over the caustic region, and after Open Image Denoise. README.md says what is compared, and what the figures cannot say.
"""

import argparse
import csv
import json
import multiprocessing
import platform
import resource
import statistics
import subprocess
import time
from pathlib import Path

import numpy as np
import OpenEXR
import pyoidn

import gltf
import renderers

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
# Ours, by what each has beyond the defaults.
WHOLE_PATHS = ["--indirect-end", "path"]
UNSHARED = ["--indirect-share", "none", *WHOLE_PATHS]
OURS = {
    "caustics progressive": [],
    "caustics progressive, no cache": WHOLE_PATHS,
    "caustics progressive, not shared": UNSHARED,
}
REFERENCE_SEED = 0x7472

# What `caustics compare` calls a metric, and what a run result does.
METRICS = {
    "relmse": "relmse",
    "relmse_trimmed": "relmse_trimmed",
    "flip_ldr": "flip",
    "relmse_trimmed_caustic_region": "relmse_trimmed_caustic_region",
    "flip_ldr_caustic_region": "flip_caustic_region",
    "energy_ratio": "energy_ratio",
}


# Metrics of pictures that Open Image Denoise has denoised, by their color alone.
DENOISED = ["relmse_trimmed", "flip_ldr", "energy_ratio"]


def main():
    options = parse()
    rows, bias = [], []
    for name in options.scenes:
        scene_rows, scene_bias = of_scene(name, options)
        rows += scene_rows
        bias += scene_bias
        # After every scene: a run of an hour must not be lost to its last minute.
        write(rows, bias, options)


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    scenes = ["mirror-room", "glossy-room", "ring", "cornell-box"]
    parser.add_argument("--scenes", nargs="+", default=scenes, help="folders below scenes/, or paths")
    parser.add_argument("--renderers", nargs="+", default=[*OURS, *renderers.PEERS], choices=[*OURS, *renderers.PEERS])
    parser.add_argument("--size", type=int, nargs=2, default=[320, 180], metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--budgets", type=float, nargs="+", default=[1, 5, 10], metavar="SECONDS")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=renderers.cores())
    parser.add_argument("--reference-frames", type=int, default=3000)
    parser.add_argument("--caustics", default=str(ROOT / "target/release/caustics"), help="our program")
    parser.add_argument("--output", type=Path, required=True, help="folder for images, table and run results")
    options = parser.parse_args()
    options.budgets.sort()
    options.output.mkdir(parents=True, exist_ok=True)
    return options


def of_scene(name, options):
    folder = options.output / "images" / Path(name).name
    folder.mkdir(parents=True, exist_ok=True)
    reference = folder / "reference.exr"
    if not reference.exists():
        render_ours(name, options, options.reference_frames, REFERENCE_SEED, reference, UNSHARED)
    rows, bias = [], []
    for renderer in options.renderers:
        runs = [images(renderer, name, seed, folder, options) for seed in range(options.seeds)]
        for index, budget in enumerate(options.budgets):
            of_budget = [run[index] for run in runs]
            errors = [errors_of(run["file"], reference, options) for run in of_budget]
            row = {"scene": Path(name).name, "renderer": renderer, "version": of_budget[0]["version"], "budget_s": budget}
            row["seconds"] = statistics.mean(run["seconds"] for run in of_budget)
            row["samples"] = statistics.mean(run["samples"] for run in of_budget)
            for metric in errors[0]:
                values = [error[metric] for error in errors if error[metric] is not None]
                row[metric] = statistics.mean(values) if values else None
                spread = statistics.stdev(values) / len(values) ** 0.5 if len(values) > 1 else None
                row[f"{metric}_standard_error"] = spread
            rows.append(row)
            print(name, renderer, budget, {metric: short(row[metric]) for metric in errors[0]}, flush=True)
        bias.append({"scene": name, "renderer": renderer, **far(runs, reference, options)})
        print(bias[-1], flush=True)
    return rows, bias


def short(value):
    return None if value is None else float(f"{value:.3g}")


def images(renderer, name, seed, folder, options):
    """An image for each budget; one run hands over all, and is kept for the next start of this script."""
    stem = f"{renderer.replace(',', '').replace(' ', '-')}-{seed}"
    known = folder / f"{stem}.json"
    if not known.exists():
        if renderer in OURS:
            runs = ours(renderer, name, seed, folder / stem, options)
        else:
            # A process of its own: libraries of the peers disturb each other, and its processor time is theirs alone.
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                runs = pool.apply(peer, (renderer, name, seed, folder / stem, options))
        known.write_text(json.dumps(runs))
    return json.loads(known.read_text())


def peer(renderer, name, seed, stem, options):
    scene = gltf.load(ROOT / "scenes" / name)
    render = renderers.PEERS[renderer]
    found, version = render(scene, options.size, options.budgets, seed, options.threads)
    runs = []
    for budget, (image, seconds, samples) in zip(options.budgets, found):
        file = f"{stem}-{budget:g}s.exr"
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": np.ascontiguousarray(image, np.float32)}).write(file)
        runs.append({"file": file, "seconds": seconds, "samples": samples, "version": version})
    return runs


def ours(renderer, name, seed, stem, options):
    """Frames that fill each budget by what a frame costs beyond the start, measured before."""
    more = OURS[renderer]
    few, many = 4, 24
    spent = [render_ours(name, options, count, seed, f"{stem}-trial.exr", more) for count in (few, many)]
    frame = (spent[1] - spent[0]) / (many - few)
    start = spent[0] - few * frame
    version = subprocess.run([options.caustics, "--version"], capture_output=True, text=True).stdout.strip()
    runs = []
    for budget in options.budgets:
        frames = max(1, round(budget * options.threads / frame))
        file = f"{stem}-{budget:g}s.exr"
        seconds = (render_ours(name, options, frames, seed, file, more) - start) / options.threads
        # A few frames do not tell well what many cost: what takes too long is rendered again, shorter.
        while seconds > 1.03 * budget and frames > 1:
            frames = max(1, min(frames - 1, int(frames * budget / seconds)))
            seconds = (render_ours(name, options, frames, seed, file, more) - start) / options.threads
        runs.append({"file": file, "seconds": seconds, "samples": frames, "version": version})
    return runs


def render_ours(name, options, frames, seed, file, more):
    """Renders, and says how much processor time it took (s)."""
    width, height = map(str, options.size)
    used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    before = used()
    command = [options.caustics, "render", str(ROOT / "scenes" / name), "-o", str(file), "--force"]
    command += ["--method", "progressive", "--pixel-filter", "box", "--width", width, "--height", height]
    command += ["--frames", str(frames), "--seed", str(seed), "--max-bounces", str(renderers.BOUNCES)]
    command += ["--runner", "cpu", "--threads", str(options.threads), *more]
    subprocess.run(command, check=True, capture_output=True)
    return used() - before


def compare(files, reference, options, layer=()):
    command = [options.caustics, "compare", *map(str, files), str(reference), "--json", "--exposure", "0", *layer]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["metrics"]


def errors_of(file, reference, options):
    """Metrics of an image, and of the same image denoised."""
    metrics = compare([file], reference, options)
    errors = {metric: metrics[metric] for metric in METRICS}
    denoised = compare([denoise(file)], reference, options)
    return errors | {f"{metric}_denoised": denoised[metric] for metric in DENOISED}


def denoise(file):
    """Writes the image as Open Image Denoise shows it, without normals and albedo, which not all renderers write."""
    channels = OpenEXR.File(str(file), separate_channels=True).channels()
    color = np.ascontiguousarray(np.stack([channels[name].pixels for name in "RGB"], -1), np.float32)
    shown = pyoidn.denoise(color, hdr=True)
    to = str(Path(file).with_suffix(".denoised.exr"))
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(shown, np.float32)}).write(to)
    return to


def far(runs, reference, options):
    """How far the expected picture of a renderer is from the reference: squared bias, noise taken off, of the longest runs."""
    metrics = compare([run[-1]["file"] for run in runs], reference, options)
    return {"relmse_bias2": metrics["relmse_bias2"], "energy_ratio": metrics["energy_ratio"]}


def write(rows, bias, options):
    with (options.output / "table.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys())
        table.writeheader()
        table.writerows(rows)
    with (options.output / "bias.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, bias[0].keys())
        table.writeheader()
        table.writerows(bias)
    cells = options.output / "cells"
    cells.mkdir(exist_ok=True)
    for number, row in enumerate(rows):
        identity = f"{number:016x}"
        (cells / f"{identity}.json").write_text(json.dumps(run_result(identity, row, options), indent=1))


def run_result(identity, row, options):
    """The row as a run result of `caustics report`; its time is that of the whole picture."""
    width, height = options.size
    ms = 1e3 * row["seconds"]
    known = {ours: row[name] for name, ours in METRICS.items() if name != "energy_ratio"}
    off = {ours: row[f"{name}_standard_error"] for name, ours in METRICS.items() if name != "energy_ratio"}
    size = {"width": width, "height": height, "light_paths": 0}
    config = {"scene": row["scene"], "camera": "main", "method": row["renderer"], "paths_per_pixel": row["samples"]}
    time_of = size | {"frames": 1, "total_ms": {"lower": ms, "median": ms, "upper": ms}, "ratio_to_first": None}
    time_of |= {"first": "", "pass_ms": {}, "rays": 0, "rays_per_s": 0, "points_per_s": None}
    time_of |= {"light_paths_per_s": None, "memory_bytes": {}}
    error = size | {"seeds": options.seeds, "reference_frames": options.reference_frames, "image": None}
    error |= {"error_map": None, "reference": None} | known
    error["standard_errors"] = {key: value for key, value in off.items() if value is not None}
    # One machine, one run: the renderers' versions do not tell results apart.
    provenance = {"commit": "", "kernels": "", "device": f"{options.threads} threads", "seed": 0}
    provenance |= {"machine": platform.platform(), "wall_s": row["seconds"] * options.seeds, "unix_s": int(time.time())}
    return {"identity": identity, "cell": config, "time": time_of, "error": error, "frames": [], "provenance": provenance, "note": row["version"]}


if __name__ == "__main__":
    main()
