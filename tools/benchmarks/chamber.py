#!/usr/bin/python3
"""The luminance camera and the goniophotometer on the mixing chamber: against bare Embree, and in processor seconds."""

import argparse
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import SOURCE, busy, commit, machine  # noqa: E402

BENCH = os.environ.get("UMOV_BENCH_CHAMBER", str(SOURCE / "build/release/bin/bench_chamber"))


def measure(*arguments):
    done = subprocess.run([BENCH, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{BENCH} {arguments}: {done.stderr}")
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    parser.add_argument("--paths", type=int, default=300000, help="paths a rate is measured with")
    parser.add_argument("--rays", type=int, default=1000, help="rays a pixel of the whole map")
    parser.add_argument("--noise", type=int, default=3000, help="rays a pixel of the maps whose noise is compared")
    parser.add_argument("--launches", type=int, default=2000000, help="rays of a distribution")
    options = parser.parse_args()
    load = busy()  # before this program adds its own
    page = ["# Benchmarks: luminance maps and intensity distributions", "",
            f"Command `./dev bench chamber`, commit {commit()}, {machine()}, {load}.", "",
            "The mixing chamber of `studies/chamber.md`: four sources, 43 mm wide, walls that reflect .984.", "",
            "## Rate", "",
            "One thread, processor time, best of five. *Bare Embree* gets the same rays in the same order, shadow rays included, in the same",
            "chamber made of triangles, and nothing is done with its answers. It has no faces with an exact circle, so its cylinders have 24 or",
            "256 sides. The camera's figure holds everything: circles decided in double precision, random numbers, values and draws of the wall.", "",
            "| wall | rays a path | million rays/s | bare Embree, 24 sides | share | bare Embree, 256 sides | share |", "|---|---|---|---|---|---|---|"]
    for row in measure("rate", options.paths):
        coarse, fine = (1e-6 * rate for rate in row["bare_rays_per_s"])
        page.append(f"| {row['wall']} | {row['rays_per_path']:.1f} | {1e-6 * row['rays_per_s']:.2f} | {coarse:.2f} | "
                    f"{100 * row['share'][0]:.0f} % | {fine:.2f} | {100 * row['share'][1]:.0f} % |")
        print(page[-1], flush=True)
    page += ["", "## A map", "",
             "125 × 300 pixels, all cores. Processor seconds are those of all threads together; wall clock is what the load of the machine left.", "",
             "| wall | rays a pixel | million paths | million rays | processor [s] | wall clock [s] | processor [µs] a path |",
             "|---|---|---|---|---|---|---|"]
    for rays in (max(2, options.rays // 100), max(2, options.rays // 10), options.rays):
        for row in measure("map", rays):
            page.append(f"| {row['wall']} | {rays} | {1e-6 * row['paths']:.3g} | {1e-6 * row['rays']:.3g} | {row['processor_s']:.1f} | "
                        f"{row['wall_s']:.1f} | {1e6 * row['processor_s'] / row['paths']:.2f} |")
            print(page[-1], flush=True)
    page += ["", "## A distribution", "", "8 planes of C, 37 angles γ, all cores.", "",
             "| wall | million launches | million rays | processor [s] | wall clock [s] | processor [µs] a launch |", "|---|---|---|---|---|---|"]
    for launches in (options.launches // 100, options.launches // 10, options.launches):
        for row in measure("lid", launches):
            page.append(f"| {row['wall']} | {1e-6 * row['launches']:.3g} | {1e-6 * row['rays']:.3g} | {row['processor_s']:.2f} | "
                        f"{row['wall_s']:.2f} | {1e6 * row['processor_s'] / row['launches']:.2f} |")
            print(page[-1], flush=True)
    page += ["", "## Noise", "",
             "Variance of a pixel times the rays it took, summed over a small map, over that of both samplings weighted (multiple importance",
             "sampling), which maps use; within 2 % counts as equal. *Paths alone* find sources by chance; *next event* aims at them at every bounce.", "",
             "| wall | paths alone | next event | both, weighted | no noisier than the best |", "|---|---|---|---|---|"]
    for row in measure("noise", options.noise):
        alone, aimed, both = (row[name] ** 2 for name in ("unidirectional", "next_event", "mis"))
        page.append(f"| {row['wall']} | {alone / both:.2f} | {aimed / both:.2f} | 1 | {'yes' if both <= 1.02 * min(alone, aimed) else '**no**'} |")
        print(page[-1], flush=True)
    page[2] = page[2].removesuffix(".") + f", {os.getloadavg()[0]:.1f} at the end with this program's own threads in it."
    if options.output:
        pathlib.Path(options.output).write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
