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
import hashlib
import json
import math
import os
import pathlib
import random
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, commit, machine  # noqa: E402


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

# Those that the data determine, away from their limits. kappa and k_fs are zero, where every interval with
# the limit in it holds the truth; k_fs' width and polarisation mean nothing without it; k_udf at 814 nm lies
# within a standard deviation of zero and has an upper limit only.
QUANTITIES = ([("n", None), ("sigma_um", None), ("tau_um", None), ("slope_2sigma_over_tau", None)] +
              [(name, i) for name in ("k_dd", "k_udf+k_uds", "k_uds") for i in range(3)] +
              [("k_udf", 0), ("k_udf", 1)] + [("dhr", i) for i in range(3)])


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
    known = {(name, None): value[name][0] for name in ("n", "sigma_um", "tau_um")}
    known["slope_2sigma_over_tau", None] = 2 * value["sigma_um"][0] / value["tau_um"][0]
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


def standard_draw(rng):
    """By how many standard deviations the standard's scale is off its certificate; a seed's first draw."""
    return rng.gauss(0, 1)


def one_seed(seed, folder, paint, plant, calibration):
    """Fits one emulated bench; returns {quantity: (value, lo, hi)} and chi2/dof."""
    rng = random.Random(seed)
    here = pathlib.Path(folder) / f"seed{seed}"
    here.mkdir()
    (here / "white.toml").write_text(WHITE)
    (here / "paint.toml").write_text(paint)
    scaled_certificate(pathlib.Path(folder) / "certificate.csv", here / "certificate.csv",
                       1 + calibration.standard_u * standard_draw(rng), calibration.standard_u)
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


class Store:
    """Fits of a case, a line a seed, so that a long study can be stopped and taken up again."""

    def __init__(self, path, case):
        self.path = path
        program = hashlib.sha256(pathlib.Path(UMOV).read_bytes()).hexdigest()
        head = {"case": case, "quantities": QUANTITIES, "program_sha256": program, "commit": commit()}
        head = json.loads(json.dumps(head))
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(head) + "\n", encoding="utf-8")
        kept = json.loads(path.read_text(encoding="utf-8").splitlines()[0])
        if {**kept, "commit": None} != {**head, "commit": None}:
            raise SystemExit(f"{path} holds fits of another case or program; remove it")
        self.commit = kept["commit"]

    def fits(self):
        """{seed: ({quantity: (value, lo, hi)}, chi2/dof)} of what is there."""
        rows = [json.loads(line) for line in self.path.read_text(encoding="utf-8").splitlines()[1:]]
        return {row["seed"]: (dict(zip(QUANTITIES, row["intervals"])), row["chi2_per_dof"]) for row in rows}

    def add(self, seed, found, ratio):
        row = {"seed": seed, "chi2_per_dof": ratio, "intervals": [found[quantity] for quantity in QUANTITIES]}
        with open(self.path, "a", encoding="utf-8") as out:
            out.write(json.dumps(row) + "\n")


def fitted(seeds, paint, plant, calibration, jobs, first, store=None):
    """Yields ({quantity: (value, lo, hi)}, chi2/dof) seed by seed."""
    known_fits = store.fits() if store else {}
    with tempfile.TemporaryDirectory(prefix="umov-coverage-") as folder:
        umov("emulator", "--certificate", "white-99", "-o", pathlib.Path(folder) / "certificate.csv")
        with open(pathlib.Path(folder) / "directions.csv", "w", encoding="utf-8") as out:
            out.write("theta_i_deg,theta_r_deg,phi_r_deg\n" + "".join("%g,%g,%g\n" % d for d in DIRECTIONS))

        def fit(seed):
            return known_fits.get(seed) or one_seed(seed, folder, paint, plant, calibration)

        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            numbers = range(first, first + seeds)
            for seed, (found, ratio) in zip(numbers, pool.map(fit, numbers)):
                if store and seed not in known_fits:
                    store.add(seed, found, ratio)
                yield found, ratio


class Outcome:
    """How often each quantity was covered, its errors, relative and in stated standard deviations, and chi2/dof, by seed."""

    def __init__(self):
        self.hits = {quantity: [] for quantity in QUANTITIES}
        self.errors = {quantity: [] for quantity in QUANTITIES}
        self.deviations = {quantity: [] for quantity in QUANTITIES}
        self.chi2 = []

    def add(self, found, ratio, known):
        self.chi2.append(ratio)
        for quantity, (value, low, high) in found.items():
            self.hits[quantity].append(low <= known[quantity] <= high)
            self.errors[quantity].append(value / known[quantity] - 1)
            self.deviations[quantity].append((value - known[quantity]) / ((high - low) / (2 * 1.96)))

    def of_kind(self, kind):
        """Hits of the quantities of a kind, a list over seeds each."""
        return [hits for (name, _), hits in self.hits.items() if KINDS[kind](name)]


def run(seeds, paint, plant=(), calibration=EXACT, jobs=os.cpu_count(), first=1):
    """Returns how often each quantity was covered, its relative errors, and chi2/dof of each seed."""
    known = truth()
    outcome = Outcome()
    for found, ratio in fitted(seeds, paint, plant, calibration, jobs, first):
        outcome.add(found, ratio, known)
    return {quantity: sum(hits) for quantity, hits in outcome.hits.items()}, outcome.errors, outcome.chi2


def worth(hits):
    """How many independent intervals these are worth: as many as would have a mean share that scatters like theirs.

    `hits` has a list over seeds for each quantity; quantities of one seed share its draws. At least one a seed.
    """
    seeds, trials = len(hits[0]), len(hits) * len(hits[0])
    shares = [sum(column) / len(hits) for column in zip(*hits)]
    mean = sum(shares) / seeds
    variance = sum((share - mean) ** 2 for share in shares) / max(seeds - 1, 1) / seeds
    return trials if variance == 0 else min(trials, max(seeds, math.floor(mean * (1 - mean) / variance)))


def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))


def label(name):
    if isinstance(name, tuple):
        return "%s(%g°; %g°, %g°)" % (name[0].upper(), *name[1:])
    return "DHR(30°)" if name == "dhr" else f"`{name}`"


def band(index):
    return "all" if index is None else str(WAVELENGTHS[index])


def kinds_table(outcome):
    lines = ["| 95 % intervals of | hold the truth | of | share | worth independent ones | so the true share lies in |",
             "|---|---|---|---|---|---|"]
    for kind in KINDS:
        hits = outcome.of_kind(kind)
        found, trials, independent = sum(map(sum, hits)), len(hits) * len(hits[0]), worth(hits)
        low, high = clopper_pearson(round(found / trials * independent), independent)
        lines.append(f"| {kind} | {found} | {trials} | **{100 * found / trials:.1f} %** | {independent} | "
                     f"{100 * low:.1f}–{100 * high:.1f} % |")
    return lines


def extremes(outcome):
    """The single quantities that are covered least and most often, and how many lie within the target."""
    seeds = len(outcome.chi2)
    counts = sorted(((sum(hits), quantity) for quantity, hits in outcome.hits.items()), key=lambda pair: pair[0])
    within = sum(0.92 * seeds <= count <= 0.97 * seeds for count, _ in counts)
    said = []
    for count, (name, index) in (counts[0], counts[-1]):
        low, high = clopper_pearson(count, seeds)
        said.append(f"{label(name)} {band(index)} nm {100 * count / seeds:.1f} % ({100 * low:.1f}–{100 * high:.1f} %)")
    return f"{within} of {len(counts)} single quantities lie within 92–97 %; least: {said[0]}, most: {said[1]}."


def quantities_table(outcome):
    seeds = len(outcome.chi2)
    lines = ["| quantity | nm | covered | rms relative error | mean error / u | spread / u |", "|---|---|---|---|---|---|"]
    for (name, index), hits in outcome.hits.items():
        deviations = outcome.deviations[name, index]
        lines.append(f"| {label(name)} | {band(index)} | {sum(hits)}/{seeds} | {100 * rms(outcome.errors[name, index]):.3g} % | "
                     f"{statistics.mean(deviations):+.2f} | {statistics.stdev(deviations):.2f} |")
    return lines


def case_section(title, outcome, calibration):
    chi2 = outcome.chi2
    lines = [f"## {title}", "", *kinds_table(outcome), "", extremes(outcome),
             f"χ²/dof {sum(chi2) / len(chi2):.3f} on average, {min(chi2):.3f} to {max(chi2):.3f}."]
    if calibration.standard_u > 0:
        draws = [standard_draw(random.Random(seed)) for seed in range(1, len(chi2) + 1)]
        inside = sum(abs(draw) < 1.96 for draw in draws)
        lines += ["", f"One draw of the standard's scale a seed moves all k, BRDF and DHR together: {inside} of {len(draws)} draws "
                  f"({100 * inside / len(draws):.1f} %) lay within 1.96 standard deviations, and so do the intervals."]
    return lines + ["", *quantities_table(outcome), ""]


def studied(number, title, paint, plant, calibration, options):
    """The section of one case and the commit of its fits."""
    known = truth()
    outcome = Outcome()
    case = {"paint": paint, "white": WHITE, "plant": plant, "standard_u": calibration.standard_u,
            "range_u": calibration.range_u}
    store = Store(pathlib.Path(options.keep) / f"case{number}.jsonl", case) if options.keep else None
    for found, ratio in fitted(options.seeds, paint, plant, calibration, options.jobs, 1, store):
        outcome.add(found, ratio, known)
        if len(outcome.chi2) % 50 == 0 and len(outcome.chi2) < options.seeds:
            print(f"{title}, {len(outcome.chi2)} seeds:", *kinds_table(outcome)[2:], extremes(outcome), sep="\n", flush=True)
    return case_section(title, outcome, calibration), store.commit if store else commit()


WEAK_LIGHT = ("detector.shot_noise_v=4e-6",)
CASES = (("Weak light, standard known exactly: shot noise of .03 % on white, .5 % on black", WEAK_LIGHT, EXACT),
         ("Ideal bench, standard known exactly: 2e-5 on white", (), EXACT),
         ("Weak light, standard's scale drawn within .5 %, amplifier ranges within .1 %", WEAK_LIGHT, CERTIFIED))


def introduction(seeds, commits):
    return ["# Do the 95 % intervals hold the truth?", "",
            "Emulated red gloss paint at 532, 633 and 814 nm, incidences 30, 45 and 60° in the plane of incidence, six polarisation",
            "states. Truth: `umov emulator --describe red-gloss`, and of it `umov model dhr` and `umov model eval`. Directions are",
            "(incidence; exit, azimuth); azimuths other than 0° lie out of the plane that was scanned. Target: 92–97 %.", "",
            f"Command `./dev study coverage --seeds {seeds}`, commit {', '.join(sorted(commits))}, {machine()}.", "",
            "Quantities of one seed are correlated: they share its noise, and where the standard is uncertain its scale. *Worth",
            "independent ones* says how many independent intervals would have a share that scatters as much from sample to sample;",
            "the last column is the exact binomial (Clopper–Pearson) 95 % interval for that many. Left out are parameters whose truth",
            "lies on a limit (κ, k_fs) or within the noise of one (k_udf at 814 nm): the interval begins at the limit there and holds",
            "the truth nearly always. *u* is the stated standard deviation, the interval's width over 3.92: the spread of the errors",
            "should be 1 of it. n and DOLP come out up to half a u high: κ and k_fs, whose truth is 0, can only err upwards. Held at 0",
            "(`umov invert --fix kappa=0 --fix k_fs=0`) they leave no such offset.", ""]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder for the fits of each seed; a study that was stopped goes on from there")
    parser.add_argument("-o", "--output", help="Markdown page to write")
    options = parser.parse_args()
    paint = PAINT % ("[30, 45, 60]", 5, 2)
    sections, commits = [], set()
    for number, (title, plant, calibration) in enumerate(CASES, 1):
        section, at = studied(number, title, paint, plant, calibration, options)
        print("\n".join(section), flush=True)
        sections += section
        commits.add(at)
    if options.output:
        page = introduction(options.seeds, commits) + sections
        pathlib.Path(options.output).write_text("\n".join(page).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
