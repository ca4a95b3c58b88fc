#!/usr/bin/python3
"""How many exit directions a second the samplers of the model library draw, on one thread.

Processor time, best of three, random numbers and weights (the whole Mueller matrix) included.
"""

import argparse
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, busy, commit, machine  # noqa: E402

INCIDENCES = (0, 60, 85)
MODELS = (
    ("lambertian", ()),
    ("nef", ("rho_d2=0.02",)),
    ("microfacet", ("slope_rms=0.2",)),
    ("microfacet:shadowing=vgroove", ("slope_rms=0.2",)),
    ("microfacet:slopes=exponential", ("slope_rms=0.2",)),
    ("ggx", ("alpha=0.2",)),
    ("he-torrance", ("sigma_um=0.2", "tau_um=3")),
    ("he-torrance", ("sigma_um=5", "tau_um=40")),
    ("li-torrance", ("k_fs=0.1",)),
    ("rayleigh-rice", ("sigma_um=0.02", "correlation_um=1")),
    ("beard-maxwell", ()),
    ("subsurface", ()),
    ("single-scatter", ()),
    ("phong", ()),
    ("ward", ()),
    ("microfacet+lambertian", ()),
)


def check(model, settings, draws):
    call = [UMOV, "model", "check", model, "--theta-i", ",".join(map(str, INCIDENCES)), "--draws", str(draws), "--geometries", "1",
            "--json", "--quiet"]
    for setting in settings:
        call += ["--set", setting]
    done = subprocess.run(call, text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(call)}: {done.stderr}")
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    parser.add_argument("--draws", type=int, default=300000, help="directions a measurement")
    options = parser.parse_args()
    page = ["# Benchmarks: sampling", "",
            "Million exit directions a second of processor time, one thread, best of three; random numbers (Philox) and the weight's whole",
            "Mueller matrix included. Preparation is what making a sampler costs once.", "",
            f"Command `./dev bench sampling`, commit {commit()}, {machine()}, {busy()}.", "",
            "| model | preparation [ms] | " + " | ".join(f"{a}°" for a in INCIDENCES) + " |", "|---" * (2 + len(INCIDENCES)) + "|"]
    for model, settings in MODELS:
        runs = [check(model, settings, options.draws) for _ in range(3)]
        speeds = [max(run["sampling"][i]["draws_per_cpu_s"] for run in runs) for i in range(len(INCIDENCES))]
        preparation = min(run["preparation_cpu_s"] for run in runs)
        name = model.replace("shadowing=", "").replace("slopes=", "").replace(":", ", ")
        if settings:
            name += f" ({', '.join(settings)})"
        page.append(f"| {name} | {1e3 * preparation:.0f} | " + " | ".join(f"{1e-6 * s:.2f}" for s in speeds) + " |")
        print(page[-1], flush=True)
    page += ["", "Where a mirror part takes most draws (a smooth he-torrance surface at 85°) they cost only its reflectance."]
    if options.output:
        pathlib.Path(options.output).write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
