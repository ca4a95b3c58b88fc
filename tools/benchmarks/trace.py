#!/usr/bin/python3
"""The ray engine against bare Embree on the same rays, and the time a whole hemisphere takes."""

import argparse
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, busy, commit, machine  # noqa: E402

BENCH = os.environ.get("UMOV_BENCH_TRACE", str(SOURCE / "build/release/bin/bench_trace"))


def measure(*arguments):
    done = subprocess.run([BENCH, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{BENCH} {arguments}: {done.stderr}")
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    parser.add_argument("--launches", type=int, default=100000, help="launches a rate is measured with")
    parser.add_argument("--hemisphere", type=int, default=1000000, help="launches of a hemisphere")
    options = parser.parse_args()
    page = ["# Benchmarks: ray tracing", "",
            f"Command `./dev bench trace`, commit {commit()}, {machine()}, {busy()}.", "",
            "## Rate", "",
            "One thread, processor time, best of five. *Bare Embree* gets the same rays in the same order, in a scene of its own",
            "single precision primitives, and nothing is done with its answers. The engine's figure holds everything: faces decided in double",
            "precision, random numbers, Mueller matrices, exits. Light from 30°; spheres touch the ground and cover 30 % of it.", "",
            "| scene | bands | tree [s] | rays a launch | million rays/s | bare Embree | share |", "|---|---|---|---|---|---|---|"]
    rates = measure("rate", options.launches)
    for row in rates:
        page.append(f"| {row['scene']} | {row['wavelengths']} | {row['build_s']:.3f} | {row['rays_per_launch']:.2f} | "
                    f"{1e-6 * row['rays_per_s']:.2f} | {1e-6 * row['bare_rays_per_s']:.2f} | {100 * row['share']:.0f} % |")
        print(page[-1], flush=True)
    page += ["", "## Cost against particles", "",
             "Time a ray on one thread, one band, from the table above; the last column is the engine's over that of a hundred spheres.", "",
             "| spheres | engine [µs] | bare Embree [µs] | engine, relative |", "|---|---|---|---|"]
    soil = [row for row in rates if row["scene"].startswith("soil") and row["wavelengths"] == 1]
    for row in soil:
        page.append(f"| {row['scene'].removeprefix('soil, ').removesuffix(' spheres')} | {1e6 / row['rays_per_s']:.3f} | "
                    f"{1e6 / row['bare_rays_per_s']:.3f} | {soil[0]['rays_per_s'] / row['rays_per_s']:.2f} |")
        print(page[-1], flush=True)
    page += ["", "## Threads", "", "The hemispheres below on one thread and on two, best of five, wall clock.", "",
             "| scene | one [s] | two [s] | gain |", "|---|---|---|---|"]
    for row in measure("threads", options.hemisphere // 4):
        page.append(f"| {row['scene']} | {row['one_s']:.2f} | {row['two_s']:.2f} | {row['gain']:.2f} |")
        print(page[-1], flush=True)
    page += ["", "## Glints", "",
             "Mirror spheres far from each other on black ground send light evenly all round, so the mean of every cell is known (one bounce). Found over",
             "expected, over all cells up to 80°, with the standard error of the counts, and the mean square deviation of a cell in its own errors",
             "(1 expected; a cell of few exits has errors that are themselves vague).", "",
             "| cells | of [sr] | number | found / expected | χ² a cell |", "|---|---|---|---|---|"]
    for row in measure("glints", 8 * options.hemisphere):
        page.append(f"| {row['cells']} | {row['solid_angle_sr']:.2e} | {row['number']} | {row['mean_ratio']:.4f} ± {row['error']:.4f} | "
                    f"{row['chi2_per_cell']:.2f} |")
        print(page[-1], flush=True)
    page += ["", "## A hemisphere", "",
             "11 bands from .40 to .90 µm, light from 20°, 827 cells of 5° and a strip of 180, all 16 elements; all cores, wall clock. Errors are",
             "1 σ of m00: the largest of all bands for the DHR, the median of all cells and bands for the cells. The last two columns are the",
             "time scaled with the square of the error.", "",
             "| scene | launches | wall [s] | DHR error | cell error | s to 1 % of DHR | s to 3 % of cells | light lost |",
             "|---|---|---|---|---|---|---|---|"]
    for row in measure("hemisphere", options.hemisphere):
        page.append(f"| {row['scene']} | {row['launches']} | {row['wall_s']:.1f} | {100 * row['dhr_relative_error']:.3f} % | "
                    f"{100 * row['cell_relative_error_median']:.1f} % | {row['wall_s_to_dhr_1_percent']:.2f} | "
                    f"{row['wall_s_to_cells_3_percent']:.0f} | {row['lost_share']:.1e} |")
        print(page[-1], flush=True)
    if options.output:
        pathlib.Path(options.output).write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
