#!/usr/bin/python3
"""Do the 95 % intervals of the inversion hold the truth?

Every seed is an emulated bench that measures its white standard and red gloss paint in the plane of
incidence; the scans go through calibrate, reduce and invert, and each interval is compared with the
emulator's truth: parameters that the data can determine, reflectance, and BRDF and DOLP in directions in
and out of the plane of incidence. Where a calibration is uncertain, the bench is made wrong by what
its certificate admits: the standard's scale and the amplifier's ranges are drawn from their stated
uncertainties.
"""

import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import platform
import random
import shutil
import subprocess
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
UMOV = os.environ.get("UMOV_BINARY", str(SOURCE / "build/release/bin/umov"))

class Calibration:
    """What is known beforehand, relative, one sigma: the standard's certificate, amplifier ranges 10 to 1000."""

    def __init__(self, standard_u=0.0, range_u=0.0):
        self.standard_u = standard_u
        self.range_u = range_u


EXACT = Calibration()
CERTIFIED = Calibration(0.005, 0.001)

WHITE = """
sample = "white-99"
role = "white"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [0, 45]
theta_r_deg = { from = -80, to = 80, step = 20 }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"], ["S", "open"]]
dwell_ms = 20
"""

PAINT = """
sample = "red-gloss"
wavelengths_nm = [532, 633, 814]
theta_i_deg = %s
theta_r_deg = { from = -80, to = 80, step = %d, near = { within_deg = 8, step = %d } }
states = [["P", "P"], ["P", "S"], ["P", "open"], ["S", "S"], ["S", "P"], ["S", "open"]]
dwell_ms = 20
"""

# Determined by the data and away from their limits, judged by the truth: the slope instead of sigma
# and tau, sums where only sums are known; kappa, k_fs and its shape are zero or meaningless here.
QUANTITIES = ([("n", None), ("slope_2sigma_over_tau", None)] +
              [("k_dd", i) for i in range(3)] + [("k_udf+k_uds", i) for i in range(3)] +
              [("k_uds", 1), ("k_uds", 2), ("k_udf", 0)] + [("dhr", i) for i in range(3)])


# (theta_i, theta_r, phi_r): in and about the lobe, three of them off the plane that was scanned; and, where
# all light is diffuse and DOLP nought, for the BRDF alone.
LOBE = [(30, 22, 0), (45, 43, 0), (60, 70, 0), (30, 30, 15), (45, 45, 12), (60, 55, 10)]
DIRECTIONS = LOBE + [(60, -40, 0), (30, 40, 60), (60, 50, 120)]
WAVELENGTHS = (532, 633, 814)
# What the shares are counted over.
KINDS = {"parameters": lambda name: not isinstance(name, tuple) and name != "dhr", "DHR": lambda name: name == "dhr",
         "BRDF": lambda name: isinstance(name, tuple) and name[0] == "brdf",
         "DOLP": lambda name: isinstance(name, tuple) and name[0] == "dolp"}
QUANTITIES += [(("brdf", *direction), i) for direction in DIRECTIONS for i in range(3)]
QUANTITIES += [(("dolp", *direction), i) for direction in LOBE for i in range(3)]


def umov(*arguments):
    done = subprocess.run([UMOV, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"umov {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def scaled_certificate(source, target, scale, relative_u):
    with open(source, encoding="utf-8") as lines, open(target, "w", encoding="utf-8") as out:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        out.write(",".join(rows.fieldnames) + ",brdf_u\n")
        for row in rows:
            value = scale * float(row["brdf_per_sr"])
            row["brdf_per_sr"] = f"{value:.9g}"
            out.write(",".join(row.values()) + f",{relative_u * value:.4g}\n")


def truth():
    parameters = json.loads(umov("emulator", "--describe", "red-gloss", "--json"))["parameters"]
    value = {name: parameter["value"] for name, parameter in parameters.items()}
    known = {("n", None): value["n"][0],
             ("slope_2sigma_over_tau", None): 2 * value["sigma_um"][0] / value["tau_um"][0]}
    for i, wavelength in enumerate((532, 633, 814)):
        known["k_dd", i] = value["k_dd"][i]
        known["k_udf", i] = value["k_udf"][i]
        known["k_uds", i] = value["k_uds"][i]
        known["k_udf+k_uds", i] = value["k_udf"][i] + value["k_uds"][i]
        known["dhr", i] = model_dhr(parameters, i)
        for direction in DIRECTIONS:
            brdf, dolp = model_direction(parameters, i, direction)
            known[("brdf", *direction), i] = brdf
            if direction in LOBE:
                known[("dolp", *direction), i] = dolp
    return known


def settings_of(parameters, wavelength_index):
    names = ("n", "kappa", "sigma_um", "tau_um", "k_dd", "k_udf", "k_uds", "k_fs", "fs_width_deg", "fs_polarization")
    return [word for name in names for word in ("--set", f"{name}={parameters[name]['value'][wavelength_index]:.17g}")]


def model_direction(parameters, wavelength_index, direction):
    """BRDF and DOLP (P4) of the true parameters."""
    theta_i, theta_r, phi_r = direction
    out = umov("model", "eval", "li-torrance", *settings_of(parameters, wavelength_index), "--wavelength-nm",
               WAVELENGTHS[wavelength_index], "--theta-i", theta_i, f"--theta-r={theta_r}", "--phi-r", phi_r, "--json")
    m = json.loads(out)["mueller"]
    pp = 0.5 * (m[0] - m[1] - m[4] + m[5])
    ps = 0.5 * (m[0] - m[1] + m[4] - m[5])
    return m[0], (pp - ps) / (pp + ps)


def model_dhr(parameters, wavelength_index):
    """Reflectance of the true parameters at 30 degrees, mirror part included as in fit.json, by the program's own integration."""
    settings = settings_of(parameters, wavelength_index)
    wavelength = (532, 633, 814)[wavelength_index]
    out = umov("model", "dhr", "li-torrance", *settings, "--wavelength-nm", wavelength, "--theta-i", 30, "--json")
    return json.loads(out)["total"]


def one_seed(seed, folder, paint, plant, calibration):
    """Fits one emulated bench; returns {quantity: (value, lo, hi)} and chi2/dof."""
    rng = random.Random(seed)
    here = pathlib.Path(folder) / f"seed{seed}"
    here.mkdir()
    (here / "white.toml").write_text(WHITE)
    (here / "paint.toml").write_text(paint)
    scaled_certificate(pathlib.Path(folder) / "certificate.csv", here / "certificate.csv",
                       1 + rng.gauss(0, calibration.standard_u), calibration.standard_u)
    bench = []
    for gain in (10, 100, 1000):
        bench += ["--plant-set", f"amplifier.gain_error_{gain}={rng.gauss(0, calibration.range_u):.6g}"]
    for setting in plant:
        bench += ["--plant-set", setting]
    umov("scan", here / "white.toml", "-o", here / "white.h5", "--seed", 2 * seed, "--quiet", *bench)
    umov("scan", here / "paint.toml", "-o", here / "scan.h5", "--seed", 2 * seed + 1, "--quiet", *bench)
    umov("calibrate", here / "white.h5", "-o", here / "cal.h5", "--reference-brdf", here / "certificate.csv",
         "--range-tolerance", calibration.range_u)
    umov("reduce", here / "scan.h5", "--calibration", here / "cal.h5", "-o", here / "brdf.h5")
    umov("invert", here / "brdf.h5", "--model", "li-torrance", "-o", here / "fit.json", "--theta-i", 30,
         "--no-held-out", "--starts", 4, "--threads", 1, "--quiet",
         "--predict", pathlib.Path(folder) / "directions.csv", "--predict-output", here / "prediction.csv")
    fit = json.loads((here / "fit.json").read_text())
    with open(here / "prediction.csv", encoding="utf-8") as lines:
        predicted = {}
        for row in csv.DictReader(lines):
            row = {key: float(value) for key, value in row.items()}
            predicted[row["wavelength_nm"], row["theta_i_deg"], row["theta_r_deg"], row["phi_r_deg"]] = row
    found = {}
    for name, index in QUANTITIES:
        if isinstance(name, tuple):
            row = predicted[(WAVELENGTHS[index], *name[1:])]
            column = "brdf_per_sr" if name[0] == "brdf" else "dolp"
            found[name, index] = (row[column], row[f"{name[0]}_lo"], row[f"{name[0]}_hi"])
            continue
        if name == "dhr":
            entry = next(d for d in fit["dhr"] if d["wavelength_nm"] == (532, 633, 814)[index] and d["theta_i_deg"] == 30)
        else:
            group = fit["derived"] if name in fit["derived"] else fit["parameters"]
            entry = group[name] if index is None else group[name][index]
        found[name, index] = (entry["value"], entry["lo"], entry["hi"])
    shutil.rmtree(here)
    return found, fit["chi2"] / fit["dof"]


def clopper_pearson(k, n, level=0.95):
    """Exact binomial interval by bisection on the tail sums."""
    def tail(p, low):
        terms = range(k, n + 1) if low else range(0, k + 1)
        return sum(math.exp(math.lgamma(n + 1) - math.lgamma(j + 1) - math.lgamma(n - j + 1)
                            + j * math.log(p) + (n - j) * math.log1p(-p)) for j in terms)

    def bisect(low):
        a, b = 1e-12, 1 - 1e-12
        for _ in range(80):
            mid = 0.5 * (a + b)
            if (tail(mid, low) > (1 - level) / 2) == low:
                b = mid
            else:
                a = mid
        return 0.5 * (a + b)

    return (0.0 if k == 0 else bisect(True)), (1.0 if k == n else bisect(False))


def run(seeds, paint, plant=(), calibration=EXACT, jobs=os.cpu_count(), first=1):
    """Returns how often each quantity was covered, its relative errors, and chi2/dof of each seed."""
    known = truth()
    covered = {quantity: 0 for quantity in QUANTITIES}
    errors = {quantity: [] for quantity in QUANTITIES}
    chi2 = []
    with tempfile.TemporaryDirectory(prefix="umov-coverage-") as folder:
        umov("emulator", "--certificate", "white-99", "-o", pathlib.Path(folder) / "certificate.csv")
        with open(pathlib.Path(folder) / "directions.csv", "w", encoding="utf-8") as out:
            out.write("theta_i_deg,theta_r_deg,phi_r_deg\n" + "".join("%g,%g,%g\n" % d for d in DIRECTIONS))
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            for found, ratio in pool.map(lambda s: one_seed(s, folder, paint, plant, calibration), range(first, first + seeds)):
                chi2.append(ratio)
                for quantity, (value, low, high) in found.items():
                    covered[quantity] += low <= known[quantity] <= high
                    errors[quantity].append(value / known[quantity] - 1)
    return covered, errors, chi2


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def commit():
    done = subprocess.run(["git", "-C", SOURCE, "rev-parse", "--short", "HEAD"], text=True, capture_output=True, check=False)
    return done.stdout.strip() or "unknown"


def table(seeds, covered, errors):
    lines = ["| quantity | nm | covered | rms relative error |", "|---|---|---|---|"]
    for (name, index), count in covered.items():
        wavelength = "all" if index is None else (532, 633, 814)[index]
        if isinstance(name, tuple):
            label = "%s(%g°; %g°, %g°)" % (name[0].upper(), *name[1:])
        else:
            label = "DHR(30°)" if name == "dhr" else f"`{name}`"
        lines.append(f"| {label} | {wavelength} | {count}/{seeds} | {100 * rms(errors[name, index]):.3g} % |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("-o", "--output", help="Markdown page to write")
    options = parser.parse_args()
    paint = PAINT % ("[30, 45, 60]", 5, 2)
    page = ["# Do the 95 % intervals hold the truth?", "",
            "Emulated red gloss paint at 532, 633 and 814 nm, incidences 30, 45 and 60° in the plane of incidence, six polarisation",
            "states. Truth: `umov emulator --describe red-gloss`, and of it `umov model dhr` and `umov model eval`. Directions are",
            "(incidence; exit, azimuth); azimuths other than 0° lie out of the plane that was scanned.", "",
            f"Command `./dev study coverage --seeds {options.seeds}`, commit {commit()}, {platform.machine()}, {os.cpu_count()} cores.", ""]
    weak_light = ("detector.shot_noise_v=4e-6",)
    cases = (("Weak light, standard known exactly: shot noise of .03 % on white, .5 % on black", weak_light, EXACT),
             ("Ideal bench, standard known exactly: 2e-5 on white", (), EXACT),
             ("Weak light, standard's scale drawn within .5 %, amplifier ranges within .1 %", weak_light, CERTIFIED))
    for title, plant, calibration in cases:
        covered, errors, chi2 = run(options.seeds, paint, plant, calibration, options.jobs)
        page += [f"## {title}", "", "| 95 % intervals of | cover | of | share | if all were independent |", "|---|---|---|---|---|"]
        for kind, belongs in KINDS.items():
            mine = [count for (name, _), count in covered.items() if belongs(name)]
            hits, trials = sum(mine), options.seeds * len(mine)
            low, high = clopper_pearson(hits, trials)
            page.append(f"| {kind} | {hits} | {trials} | **{100 * hits / trials:.1f} %** | {100 * low:.1f}–{100 * high:.1f} % |")
        page += ["", f"Target 92–97 %. "
                 f"χ²/dof {sum(chi2) / len(chi2):.3f} on average, {min(chi2):.3f} to {max(chi2):.3f}.", ""]
        page += table(options.seeds, covered, errors) + [""]
        print("\n".join(page[-(len(covered) + 11):]), flush=True)
    page += ["Quantities of one seed are correlated, so the binomial intervals are too narrow; in the last case nearly all of",
             "them share the standard's scale, and the share covered is little more than the share of seeds whose draw lay",
             "within two standard deviations."]
    if options.output:
        pathlib.Path(options.output).write_text("\n".join(page) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
