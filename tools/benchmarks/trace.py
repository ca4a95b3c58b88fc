#!/usr/bin/python3
"""The ray engine against bare Embree on the same rays, its growth with particles, threads and ranks, and the time a hemisphere takes."""

import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, UMOV, busy, commit, machine  # noqa: E402

BENCH = os.environ.get("UMOV_BENCH_TRACE", str(SOURCE / "build/release/bin/bench_trace"))

SURFACE = "[surface]\nwavelengths_um = { from = 0.40, to = 0.90, step = 0.05 }\n[substrate]\nmodel = \"lambertian\"\nrho = 0.04\n"
SCENES = {
    "soil, 1,000 spheres": SURFACE + "[[particles]]\nmaterial = \"dry_soil\"\nradius_um = 20\ncoverage = 0.3\n",
    "drops of 180°, 1,000": SURFACE + "[[drops]]\ncontact_angle_deg = 180\nradius_um = 30\ncoverage = 0.3\n",
}
# What is asked of the engine.
LEAST_SHARE = 0.40  # of bare Embree's rate, one band
LEAST_GAIN = 1.9  # of two threads
MOST_SECONDS = 60  # to 1 % of the DHR and 3 % of the cells
MOST_MISS = 0.20  # of a logarithm, of the time a ray takes


def measure(*arguments):
    done = subprocess.run([BENCH, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{BENCH} {arguments}: {done.stderr}")
    return json.loads(done.stdout)


def simulated(scene, *options, ranks=1):
    """What umov simulate surface says of the scene file, without its own name and time; wall clock."""
    command = [UMOV, "simulate", "surface", scene, "--theta-i", "20", "--json", "--quiet", *map(str, options)]
    environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    if ranks > 1:
        command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *command]
    start = time.monotonic()
    done = subprocess.run(command, text=True, capture_output=True, check=False, env=environment)
    if done.returncode != 0:
        raise RuntimeError(f"{command}: {done.stderr}")
    return json.loads(done.stdout), time.monotonic() - start


class Page:
    """Lines of Markdown, told as they come."""

    def __init__(self):
        self.lines, self.targets = [], []

    def add(self, *lines):
        self.lines += lines

    def row(self, *cells):
        self.lines.append("| " + " | ".join(map(str, cells)) + " |")
        print(self.lines[-1], flush=True)

    def target(self, what, required, found, met):
        self.targets.append(f"| {what} | {required} | {found} | {'yes' if met else '**no**'} |")
        print(self.targets[-1], flush=True)


def rate(page, launches):
    page.add("## Rate", "",
             "One thread, processor time, best of five. *Bare Embree* gets the same rays in the same order, in a scene of its own",
             "single precision primitives, and nothing is done with its answers. The engine's figure holds everything: faces decided in double",
             "precision, random numbers, Mueller matrices, exits. Light from 30°; spheres touch the ground and cover 30 % of it. Launches follow each",
             f"other along a Hilbert curve, as in a block of a simulation; there are {launches:,} of them, or as many as faces where these are more.", "",
             "| scene | bands | tree [s] | rays a launch | million rays/s | bare Embree | share |", "|---|---|---|---|---|---|---|")
    rates = measure("rate", launches)
    for row in rates:
        page.row(row["scene"], row["wavelengths"], f"{row['build_s']:.3f}", f"{row['rays_per_launch']:.2f}", f"{1e-6 * row['rays_per_s']:.2f}",
                 f"{1e-6 * row['bare_rays_per_s']:.2f}", f"{100 * row['share']:.0f} %")
    worst = min((row for row in rates if row["wavelengths"] == 1), key=lambda row: row["share"])
    page.target("rate beside bare Embree, one band", f"{100 * LEAST_SHARE:.0f} %", f"{100 * worst['share']:.0f} % and more ({worst['scene']})",
                worst["share"] >= LEAST_SHARE)
    return rates


def fitted(counts, times):
    """Least squares of relative misses: a and b of a + b·log10 N with its largest relative miss, and the power of N."""
    x = [math.log10(n) for n in counts]
    # Weights 1/t²: relative misses.
    w = [1 / t**2 for t in times]
    total = sum(w)
    mx = sum(a * b for a, b in zip(w, x)) / total
    mt = sum(a * b for a, b in zip(w, times)) / total
    slope = sum(a * (b - mx) * (t - mt) for a, b, t in zip(w, x, times)) / sum(a * (b - mx) ** 2 for a, b in zip(w, x))
    start = mt - slope * mx
    miss = max(abs(start + slope * b - t) / t for b, t in zip(x, times))
    mean = sum(x) / len(x)
    logs = [math.log10(t) for t in times]
    power = sum((b - mean) * t for b, t in zip(x, logs)) / sum((b - mean) ** 2 for b in x)
    return start, slope, miss, power


def growth(page, rates):
    page.add("", "## Cost against particles", "",
             "Time a ray on one thread, one band, from the table above; the last column is the engine's over that of a hundred spheres.", "",
             "| spheres | engine [µs] | bare Embree [µs] | engine, relative |", "|---|---|---|---|")
    soil = [row for row in rates if row["scene"].startswith("soil") and row["wavelengths"] == 1]
    for row in soil:
        page.row(row["scene"].removeprefix("soil, ").removesuffix(" spheres"), f"{1e6 / row['rays_per_s']:.3f}",
                 f"{1e6 / row['bare_rays_per_s']:.3f}", f"{soil[0]['rays_per_s'] / row['rays_per_s']:.2f}")
    counts = (100, 1024, 10**4, 316**2, 10**6)
    page.add("")
    for who, key in (("engine", "rays_per_s"), ("bare Embree", "bare_rays_per_s")):
        start, slope, miss, power = fitted(counts, [1e6 / row[key] for row in soil])
        page.add(f"- {who}: {start:.3f} + {slope:.3f} log₁₀ N µs, off by {100 * miss:.0f} % at most; as a power N^{power:.2f}")
        print(page.lines[-1], flush=True)
        if key == "rays_per_s":
            page.target("time a ray, 10² to 10⁶ particles, as a logarithm", f"off by {100 * MOST_MISS:.0f} % at most",
                        f"{100 * miss:.0f} %; as a power N^{power:.2f}", miss <= MOST_MISS)
    page.add("", "Beyond 10⁵ spheres tree and faces no longer fit into the processor's caches. That launches are in order keeps what is needed next",
             "there where a block has as many launches as there are faces: in runs of 128 times as many. Blocks of shorter runs are smaller.")


def threads(page, launches):
    page.add("", "## Threads", "", "The hemispheres below on one thread and on two, best of five, wall clock.", "",
             "| scene | one [s] | two [s] | gain |", "|---|---|---|---|")
    rows = measure("threads", launches)
    for row in rows:
        page.row(row["scene"], f"{row['one_s']:.2f}", f"{row['two_s']:.2f}", f"{row['gain']:.2f}")
    least = min(row["gain"] for row in rows)
    page.target("two threads beside one", f"{LEAST_GAIN} times as fast", f"{least:.2f} times and more", least >= LEAST_GAIN)


def ranks(page, folder, samples):
    page.add("", "## Ranks", "",
             f"`umov simulate surface` with {samples:.0g} launches alone and as several processes (`mpirun -n N`), a thread each: all that it says of",
             "DHR, degrees of polarisation, losses and rays, digit by digit, beside what one process says.", "",
             "| scene | ranks | wall [s] | the same |", "|---|---|---|---|")
    if shutil.which("mpirun") is None:
        page.add("| mpirun is not installed | | | |")
        return
    same = True
    for name, scene in SCENES.items():
        (folder / "scene.toml").write_text(scene, encoding="utf-8")
        alone, wall = simulated(folder / "scene.toml", "--samples", samples, "--threads", 1)
        page.row(name, 1, f"{wall:.2f}", "")
        for count in (2, 4):
            team, wall = simulated(folder / "scene.toml", "--samples", samples, "--threads", 1, ranks=count)
            same = same and team == alone
            page.row(name, count, f"{wall:.2f}", "yes" if team == alone else "**no**")
    page.target("results of 1, 2 and 4 ranks", "the same bits", "the same" if same else "different", same)


def glints(page, launches):
    page.add("", "## Glints", "",
             "Mirror spheres far from each other on black ground send light evenly all round, so the mean of every cell is known (one bounce). Found over",
             "expected, over all cells up to 80°, with its standard error from those of the cells, and the mean square deviation of a cell in its own errors",
             "(1 expected; a cell of few exits has errors that are themselves vague).", "",
             "| cells | of [sr] | number | found / expected | χ² a cell |", "|---|---|---|---|---|")
    for row in measure("glints", launches):
        page.row(row["cells"], f"{row['solid_angle_sr']:.2e}", row["number"], f"{row['mean_ratio']:.4f} ± {row['error']:.4f}",
                 f"{row['chi2_per_cell']:.2f}")


def hemisphere(page, launches):
    page.add("", "## A hemisphere", "",
             "11 bands from .40 to .90 µm, light from 20°, 827 cells of 5° and a strip of 180, all 16 elements; all cores, wall clock, one lay. Errors are",
             "1 σ of m00: the largest of all bands for the DHR, the median of all cells and bands for the cells. The last two columns are the",
             "time scaled with the square of the error.", "",
             "| scene | launches | wall [s] | DHR error | cell error | s to 1 % of DHR | s to 3 % of cells | light lost |",
             "|---|---|---|---|---|---|---|---|")
    for row in measure("hemisphere", launches):
        page.row(row["scene"], row["launches"], f"{row['wall_s']:.1f}", f"{100 * row['dhr_relative_error']:.3f} %",
                 f"{100 * row['cell_relative_error_median']:.1f} %", f"{row['wall_s_to_dhr_1_percent']:.2f}",
                 f"{row['wall_s_to_cells_3_percent']:.0f}", f"{row['lost_share']:.1e}")


def to_an_error(page, folder, dhr_percent, cell_percent):
    page.add("", "## To an error asked for", "",
             f"The same cells and bands by the program from scene file to result: `umov simulate surface` that stops when the DHR of every band is known to",
             f"{dhr_percent:g} % and the median cell of every band to {cell_percent:g} % (1 σ), particles laid anew all along, so that both errors hold where they",
             "lie. All cores, wall clock. A run that stops by its errors has 64 lays at least.", "",
             "| scene | until | launches | lays | wall [s] |", "|---|---|---|---|---|")
    slowest = 0.0
    for name, scene in SCENES.items():
        (folder / "scene.toml").write_text(scene, encoding="utf-8")
        for what, options in ((f"DHR {dhr_percent:g} %", ("--relative-error", dhr_percent)),
                              (f"DHR {dhr_percent:g} %, cells {cell_percent:g} %",
                               ("--relative-error", dhr_percent, "--cell-error", cell_percent))):
            said, wall = simulated(folder / "scene.toml", *options)
            slowest = max(slowest, wall)
            page.row(name, what, said["samples"], said["lays"], f"{wall:.1f}")
    page.target(f"{dhr_percent:g} % of the DHR and {cell_percent:g} % of the median cell", f"{MOST_SECONDS} s", f"{slowest:.0f} s and less",
                slowest <= MOST_SECONDS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    parser.add_argument("--launches", type=int, default=100000, help="launches a rate is measured with")
    parser.add_argument("--hemisphere", type=int, default=1000000, help="launches of a hemisphere")
    parser.add_argument("--quick", action="store_true", help="a tenth of all launches and vaguer errors, no page: does it run?")
    options = parser.parse_args()
    scale = 10 if options.quick else 1
    page = Page()
    head = ["# Benchmarks: ray tracing", "", f"Command `./dev bench trace`, commit {commit()}, {machine()}, {busy()}", ""]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        rates = rate(page, options.launches // scale)
        growth(page, rates)
        threads(page, 2 * options.hemisphere // scale)
        ranks(page, folder, options.hemisphere // scale)
        glints(page, 32 * options.hemisphere // scale)
        hemisphere(page, options.hemisphere // scale)
        to_an_error(page, folder, *((3, 12) if options.quick else (1, 3)))
    head[2] += f", {os.getloadavg()[0]:.1f} at the end with this program's own threads in it."
    targets = ["| what | required | found | met |", "|---|---|---|---|", *page.targets, ""]
    if options.output and not options.quick:
        pathlib.Path(options.output).write_text("\n".join(head + targets + page.lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
