#!/usr/bin/python3
"""The inversion against the rivals of its trade, and from anywhere: a section of the benchmark page.

Red gloss paint is scanned on the emulated bench and reduced; bench_inversion then minimises one objective
from the same starts by this project's descent and by quasi-Newton BFGS with numeric and with exact
gradients, and follows uniformly random starts to their end.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, busy, commit, machine  # noqa: E402

BENCH = os.environ.get("UMOV_BENCH_INVERSION", str(pathlib.Path(UMOV).parent / "bench_inversion"))
HEADING = "## Inversion against BFGS, and from anywhere"

STATES = '[["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"], ["S", "open"]]'
WHITE = f"""
sample = "white-99"
role = "white"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [0, 45]
theta_r_deg = {{ from = -80, to = 80, step = 10 }}
states = {STATES}
dwell_ms = 50
"""
PAINT = f"""
sample = "red-gloss"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [30, 45, 60]
theta_r_deg = {{ from = -80, to = 80, step = 4, near = {{ within_deg = 8, step = 1 }} }}
states = {STATES}
dwell_ms = 50
"""
NAMES = {"paper": "(P12), relative deviations", "noise-weighted": "noise-weighted"}


def run(*arguments):
    done = subprocess.run([str(a) for a in arguments], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def measured(folder):
    """Red gloss paint on a bench with weak light: shot noise of .03 % on white, .5 % on black."""
    noise = ("--plant-set", "detector.shot_noise_v=4e-6")
    (folder / "white.toml").write_text(WHITE)
    (folder / "paint.toml").write_text(PAINT)
    run(UMOV, "emulator", "--certificate", "white-99", "-o", folder / "certificate.csv")
    run(UMOV, "scan", folder / "white.toml", "-o", folder / "white.h5", "--seed", 2, "--quiet", *noise)
    run(UMOV, "scan", folder / "paint.toml", "-o", folder / "scan.h5", "--seed", 3, "--quiet", *noise)
    run(UMOV, "calibrate", folder / "white.h5", "-o", folder / "cal.h5", "--reference-brdf", folder / "certificate.csv")
    run(UMOV, "reduce", folder / "scan.h5", "--calibration", folder / "cal.h5", "-o", folder / "brdf.h5")
    return folder / "brdf.h5"


def rivals_section(rows):
    lines = ["| objective | start | points | umov [ms] | BFGS, exact gradients | BFGS, numeric gradients | objective: umov | exact | numeric |",
             "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        own = row["umov"]
        cells = [NAMES[row["objective"]], str(row["start"] + 1), str(row["points"]), f"{1e3 * own['seconds']:.1f}"]
        for rival in ("bfgs_exact", "bfgs_numeric"):
            cells.append(f"{row[rival]['seconds'] / own['seconds']:.1f} ×")
        cells += [f"{row[m]['objective']:.6g}" for m in ("umov", "bfgs_exact", "bfgs_numeric")]
        lines.append("| " + " | ".join(cells) + " |")
    lines.append("")
    for objective, name in NAMES.items():
        mine = [r for r in rows if r["objective"] == objective]
        ratio = {m: statistics.median(r[m]["seconds"] / r["umov"]["seconds"] for r in mine) for m in ("bfgs_exact", "bfgs_numeric")}
        worse = sum(r["umov"]["objective"] > min(r[m]["objective"] for m in ("bfgs_exact", "bfgs_numeric")) * (1 + 1e-9) for r in mine)
        lines.append(f"- {name}: median **{ratio['bfgs_numeric']:.0f} ×** faster than BFGS with numeric gradients, "
                     f"**{ratio['bfgs_exact']:.1f} ×** than with exact ones, over {len(mine)} starts; "
                     f"a worse objective than the better rival in {worse} of them.")
    return lines


def starts_section(rows):
    methods = {"levenberg_marquardt": "Levenberg-Marquardt alone", "linear_eliminated": "the same, linear coefficients eliminated",
               "descent": "descent with line searches (`Descent::from`)"}
    lines = ["| starts drawn uniformly in | method | same optimum (1e-6) | within 1e-3 | seconds each |", "|---|---|---|---|---|"]
    for drawn in ("parameters", "coordinates"):
        mine = [r for r in rows if r["drawn"] == drawn]
        best = min(r[m]["objective"] for r in rows for m in methods)
        for method, name in methods.items():
            same = sum(r[method]["objective"] <= best * (1 + 1e-6) for r in mine)
            near = sum(r[method]["objective"] <= best * (1 + 1e-3) for r in mine)
            seconds = statistics.mean(r[method]["seconds"] for r in mine)
            lines.append(f"| {drawn} | {name} | **{same}/{len(mine)}** | {near}/{len(mine)} | {seconds:.3f} |")
    return lines


def replace_section(path, text):
    """Puts the section at its place in the page, or at the end."""
    page = path.read_text(encoding="utf-8") if path.exists() else "# Benchmarks\n"
    before, found, rest = page.partition(HEADING + "\n")
    after = ""
    if found:
        tail = rest.find("\n## ")
        after = rest[tail + 1:] if tail >= 0 else ""
    path.write_text(before.rstrip() + "\n\n" + text.rstrip() + "\n" + ("\n" + after if after else ""), encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page whose section is replaced")
    parser.add_argument("--starts", type=int, default=100, help="random starts of each kind")
    parser.add_argument("--rivals", type=int, default=6, help="starts of the race against BFGS")
    options = parser.parse_args()
    load = busy()
    with tempfile.TemporaryDirectory(prefix="umov-bench-") as name:
        data = measured(pathlib.Path(name))
        race = json.loads(run(BENCH, "rivals", data, options.rivals))
        starts = json.loads(run(BENCH, "starts", data, options.starts))
    page = [HEADING, "",
            "Red gloss paint at 532, 633 and 814 nm on the emulated bench (three incidences, six polarisation states), `li-torrance`,",
            f"20 free numbers. Command `./dev bench inversion --rivals {options.rivals} --starts {options.starts}`, commit {commit()},",
            f"{machine()}, {load}; processor time of one thread, all in the same run.", "",
            "The same objective, the same starts (those of `umov invert`) and the same stop rule (relative fall in one step below",
            "1e-9) for all. The rivals are Ceres' line-search BFGS, limits by the logistic substitution; numeric gradients are",
            "central differences. Where BFGS ends sooner with a worse objective, the ratio is to its time all the same.", ""]
    page += rivals_section(race)
    page += ["", "Single descents from starts drawn uniformly within the model's own limits, in the parameters themselves or in the",
             "fit's coordinates (lengths and n in logarithms, κ²). Objective: noise-weighted with Huber's loss at 4 σ and the",
             "calibration's factors.", ""]
    page += starts_section(starts)
    text = "\n".join(page) + "\n"
    print(text)
    if options.output:
        replace_section(pathlib.Path(options.output), text)


if __name__ == "__main__":
    main()
