#!/usr/bin/python3
"""How long the way from a scan to a model takes, and how that grows.

Times whole commands, best of three: an emulated scan of 50 ms dwell, and the joint inversion of three
wavelengths by Levenberg-Marquardt beside the paper's way (quasi-Newton BFGS on relative deviations, P12).
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, busy, commit, machine  # noqa: E402

PLAN = """
sample = "%s"
role = "%s"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [30, 55]
theta_r_deg = { from = -80, to = %.6g, step = %.6g }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"]]
dwell_ms = 50
"""
LINES = 3 * 2 * 5


def plan(rows, sample="red-gloss", role="sample"):
    count = rows // LINES
    step = 160 / count
    return PLAN % (sample, role, -80 + step * (count - 1), step)


def umov(*arguments):
    done = subprocess.run([UMOV, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"umov {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def best_of(times, *arguments):
    best = float("inf")
    for _ in range(times):
        start = time.monotonic()
        umov(*arguments)
        best = min(best, time.monotonic() - start)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    options = parser.parse_args()
    page = ["# Benchmarks", "", "Whole commands, best of three, one thread.", "",
            "Other pages: [controller](benchmarks_controller.md), [sampling](benchmarks_sampling.md),",
            "[ray tracing](benchmarks_trace.md), [chamber](benchmarks_chamber.md); over USB: [usb.md](usb.md#figures).", "",
            f"Command `./dev bench spine`, commit {commit()}, {machine()}, {busy()}.", "",
            "| records | scan [s] | instrument time [s] | inversion [s] | χ²/dof | BFGS, paper's objective [s] |", "|---|---|---|---|---|---|"]
    with tempfile.TemporaryDirectory(prefix="umov-bench-") as name:
        here = pathlib.Path(name)
        (here / "white.toml").write_text(plan(300, "white-99", "white"))
        umov("emulator", "--certificate", "white-99", "-o", here / "white.csv")
        umov("scan", here / "white.toml", "-o", here / "white.h5")
        umov("calibrate", here / "white.h5", "--reference-brdf", here / "white.csv", "-o", here / "cal.h5")
        for rows in (600, 1500, 3000, 6000, 12000):
            (here / "plan.toml").write_text(plan(rows))
            scan_s = best_of(3, "scan", here / "plan.toml", "-o", here / "scan.h5", "--force", "--quiet")
            emulated_s = json.loads(umov("scan", here / "plan.toml", "-o", here / "scan.h5", "--force", "--json"))["instrument_time_s"]
            umov("reduce", here / "scan.h5", "--calibration", here / "cal.h5", "-o", here / "brdf.h5")
            common = ("invert", here / "brdf.h5", "--model", "li-torrance", "--threads", 1, "--quiet", "-o", here / "fit.json")
            fit_s = best_of(3, *common)
            fit = json.loads((here / "fit.json").read_text())
            paper_s = best_of(1, *common, "--objective", "paper")
            page.append(f"| {rows} | {scan_s:.2f} | {emulated_s:.0f} | {fit_s:.2f} | {fit['chi2'] / fit['dof']:.3f} | {paper_s:.2f} |")
            print(page[-1], flush=True)
    page += ["", "The scan runs the controller's own firmware core step by step and sample by sample (100 kS/s, two channels) in",
             "virtual time and syncs its journal to the disk as it goes. The inversion has 12 starting points, held-out rows,",
             "intervals and reflectance in its time."]
    text = "\n".join(page) + "\n"
    if options.output:
        pathlib.Path(options.output).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
