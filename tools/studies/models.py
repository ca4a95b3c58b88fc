#!/usr/bin/python3
"""Energy, reciprocity, realisability and sampling of every model: the page docs/models.md.

Runs `umov model check` over models and roughness, with everything that a surface could absorb taken out.
"""

import argparse
import json
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, commit  # noqa: E402

INCIDENCES = (0, 30, 60, 75, 80, 85, 89)
SAMPLED = (0, 60, 85)

# How a surface without losses is made of a model.
CONDUCTOR = "conductor"  # n = 0.05, κ = 100: absorbs 2e-5
WHITE = "white"          # albedo or scale 1
SCALED = "scaled"        # divided by its reflectance at normal incidence

SHADOWINGS = ("none", "vgroove", "smith", "smith-correlated", "maxwell-beard")


def rows():
    """(model, {parameter: value}, how, what to call the roughness)"""
    for shadowing in SHADOWINGS:
        for slope in (0.05, 0.15, 0.3, 0.6):
            yield f"microfacet:shadowing={shadowing}", {"slope_rms": slope}, CONDUCTOR, f"σ = {slope}"
    for shadowing in ("none", "vgroove", "smith"):
        yield f"microfacet:shadowing={shadowing},slopes=exponential", {"slope_rms": 0.3}, CONDUCTOR, "σ = 0.3"
    for shadowing in SHADOWINGS[:4]:
        for alpha in (0.05, 0.2, 0.5, 1.0):
            yield f"ggx:shadowing={shadowing}", {"alpha": alpha}, CONDUCTOR, f"α = {alpha}"
    for sigma, tau in ((0.02, 2), (0.05, 1), (0.05, 50), (0.1, 2), (0.2, 3), (0.2, 1), (0.6, 6), (2, 10), (20, 200)):
        yield "he-torrance", {"sigma_um": sigma, "tau_um": tau}, CONDUCTOR, f"σ0 = {sigma} µm, τ = {tau} µm"
    for sigma, length in ((0.002, 1), (0.01, 1), (0.01, 0.2), (0.03, 1), (0.03, 20)):
        yield "rayleigh-rice", {"sigma_um": sigma, "correlation_um": length}, CONDUCTOR, f"σ = {sigma} µm, ℓ = {length} µm"
    yield "rayleigh-rice:psd=abc", {"abc_a": 1e-4, "abc_b": 3, "abc_c": 2.5}, CONDUCTOR, "A = 1e-4, B = 3, C = 2.5"
    forward = {"k_dd": 0, "k_udf": 0, "k_uds": 0, "k_fs": 1}
    for width in (5, 15, 40):
        yield "li-torrance", {**forward, "fs_width_deg": width}, WHITE, f"k_fs = 1 alone, w = {width}°"
    yield "li-torrance", {**forward, "k_fs": 0, "k_uds": 1}, WHITE, "k_uds = 1 alone, n = 1.5"
    yield "lambertian", {"rho": 1}, WHITE, ""
    for rho in (0.0, 0.01):
        yield "nef", {"rho_d1": 0.1, "rho_d2": rho}, SCALED, f"ρ_d1 = 0.1, ρ_d2 = {rho}"
    yield "beard-maxwell", {"slope_rms": 0.15, "rho_d": 0, "rho_v": 0}, SCALED, "first surface, σ = 0.15"
    yield "beard-maxwell", {"slope_rms": 0.15, "bias": 0, "rho_d": 0, "rho_v": 0.2}, SCALED, "volume, ρ_v = 0.2"
    yield "subsurface", {"rho": 1}, WHITE, "ρ = 1, n = 1.5"
    yield "single-scatter", {"albedo": 1}, WHITE, "albedo 1, n = 1.4"
    for exponent in (1, 20, 1000):
        yield "phong", {"ks": 1, "exponent": exponent}, WHITE, f"e = {exponent}"
    for x, y in ((0.1, 0.1), (0.3, 0.3), (0.1, 0.4)):
        yield "ward", {"ks": 1, "alpha_x": x, "alpha_y": y}, WHITE, f"α = {x}, {y}"


def arguments(model, values, how):
    call = ["model", "check", model, "--theta-i", ",".join(map(str, INCIDENCES)), "--wavelength-nm", "633"]
    for name, value in values.items():
        call += ["--set", f"{name}={value:g}"]
    return call + (["--lossless"] if how == CONDUCTOR else [])


def check(model, values, how, draws):
    call = arguments(model, values, how) + ["--draws", str(draws), "--json", "--quiet"]
    done = subprocess.run([UMOV, *call], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"umov {' '.join(call)}: {done.stderr}")
    found = json.loads(done.stdout)
    scale = 1.0 / found["energy"][0]["total"] if how == SCALED else 1.0
    found["reflectance"] = [scale * row["total"] for row in found["energy"]]
    found["greatest"] = max(scale * max(row["total_s"], row["total_p"]) for row in found["energy"])
    return found


HOW = {CONDUCTOR: "n = 0.05, κ = 100", WHITE: "scale 1", SCALED: "÷ DHR(0°)"}


def short(model):
    text = model.replace("shadowing=none", "unshadowed").replace("shadowing=", "").replace("slopes=", "").replace("psd=", "")
    return ", ".join(text.replace(":", ",").split(","))


def worst_of(found):
    """One line a model: the roughness that is worst for energy."""
    groups = {}
    for (model, _, how, label), one in found:
        groups.setdefault(model, []).append((how, label, one))
    return groups


def sentence(label):
    return f" ({label})" if label else ""


def energy_verdicts(found):
    lines = ["| model | most light out, as a share of the light in | least |", "|---|---|---|"]
    for model, group in worst_of(found).items():
        above, least = max(group, key=lambda g: g[2]["greatest"]), min(group, key=lambda g: min(g[2]["reflectance"]))
        rows_of = [max(r["total_s"], r["total_p"]) for r in above[2]["energy"]]
        at = INCIDENCES[rows_of.index(max(rows_of))]
        most = above[2]["greatest"]
        verdict = f"**{most:.3g}** at {at}°{sentence(above[1])}" if most > 1.0 + 2e-5 else f"{most:.3f}: keeps to 1"
        low = min(least[2]["reflectance"])
        where = INCIDENCES[least[2]["reflectance"].index(low)]
        lines.append(f"| {short(model)} | {verdict} | {low:.3f} at {where}°{sentence(least[1])} |")
    return lines


def page(found, commit, draws):
    text = [
        "# The models: energy, reciprocity, realisability, sampling", "",
        f"Command `./dev study models`, commit {commit}. For one model with parameters of your own: `umov model check NAME`.", "",
        "A formula for a rough surface needn't keep the laws that light keeps. This page says which models break which law,",
        "and by how much. Formulas and parameters: [physics.md](physics.md), `umov model show NAME`.", "",
        "## Energy", "",
        "The reflectance DHR(θi) of a surface that absorbs nothing, its mirror part included, for unpolarised light of 633 nm.",
        "Above 1 the model makes light; below 1 it loses light that a real lossless surface would reflect (mostly what meets a",
        "second facet, which no single-bounce model follows). How losses were taken out: an interface of *n = 0.05, κ = 100*, which",
        "reflects all but 2e-5 at normal incidence (and all but 1e-3 of p-polarised light at 89.4°, its worst); *scale 1*, albedos",
        "and weights set to 1; *÷ DHR(0°)*, for models whose parameters don't say what is absorbed: divided by the reflectance",
        "at normal incidence. `li-torrance` has the energy of its parts: its lobe is that of `he-torrance`, its weights may add up to",
        "anything.", ""]
    text += energy_verdicts(found)
    text += ["", "Most light: over all roughnesses below and both linear polarisations. In full, unpolarised:", "",
             "| model | roughness | lossless by | " + " | ".join(f"{a}°" for a in INCIDENCES) + " |",
             "|---" * (3 + len(INCIDENCES)) + "|"]
    for (model, _, how, label), one in found:
        cells = [f"{r:.3f}" if r <= 1.0 + 2e-5 else f"**{r:.4f}**" if r < 1.01 else f"**{r:.3f}**" for r in one["reflectance"]]
        text.append(f"| {short(model)} | {label} | {HOW[how]} | " + " | ".join(cells) + " |")

    text += ["", "## Reciprocity and realisability", "",
             "Reciprocity: the largest element of |f(i→r) - D f(r→i)ᵀ D| over m00 (P6), the larger of both m00, over 2000 directions, half of",
             "them near the mirror direction. Realisability: minus the smallest eigenvalue of the coherency matrix, over m00; 0 for a matrix",
             "that some optics could have. Each model's worst roughness.", "",
             "| model | reciprocity violated by | unrealisable share |", "|---|---|---|"]
    for model, group in worst_of(found).items():
        back = max((g[2]["reciprocity"] for g in group), key=lambda r: r["violation"])
        real = max(g[2]["realisability"]["violation"] for g in group)
        worst = "no" if back["violation"] < 1e-6 else (
            f"**{back['violation']:.2g}** at θi {back['theta_i_deg']:.0f}°, θr {back['theta_r_deg']:.0f}°, φ {back['phi_r_deg']:.0f}°")
        text.append(f"| {short(model)} | {worst} | {'0' if real < 1e-9 else f'**{real:.2g}**'} |")
    text += ["", "`ward` as it is defined here ties its two widths to the plane of incidence; with equal widths it is reciprocal. A `tabulated` model is",
             "what its file is: `umov model check tabulated --set file=PATH` gives the figures of a measurement.", "",
             "## Sampling", "",
             "How `host/brdf/sampler.hpp` draws exit directions. The density of what is drawn is known exactly (tested by χ² in",
             "`tests/unit/brdf/sampling_test.cpp`), so the scheme decides only how much the weights f cos θr/density scatter.", "",
             "| part | drawn from |", "|---|---|",
             "| lambertian, subsurface, uniform parts of li-torrance, ρ_d | cosine |",
             "| nef: ρ_d2; beard-maxwell: ρ_v | even over the hemisphere |",
             "| microfacet, Gaussian slopes; ward | facets that the light sees, Gaussian slopes |",
             "| ggx | facets that the light sees, Trowbridge–Reitz slopes |",
             "| V-groove shadowing, any slopes; exponential slopes without Smith shadowing | V-groove walls that the light sees |",
             "| phong | cosine power about the mirror direction |",
             "| li-torrance: k_fs | exp(-chord²/2w²) about the mirror direction |",
             "| he-torrance lobe, rayleigh-rice lobe, exponential slopes with Smith shadowing, beard-maxwell's first surface, single-scatter, tabulated | a table in facet slopes (36 incidences × 24 × 48 cells), 2 % cosine |",
             "| mirror part | the mirror direction itself, with the share it has of the reflectance |",
             "| sums | all parts, each as often as its share of the reflectance at that incidence |", "",
             "A draw that a facet sends below the horizon gives nothing and counts as 0: that is the light the model loses there. Facet",
             "proposals don't follow the Fresnel factor, tables do.", "",
             f"Weights of {draws} draws of the surfaces above: relative standard error of the reflectance that 1e5 draws would give; greatest weight over the mean;",
             "share of draws that give nothing.", "",
             "| model | roughness | " + " | ".join(f"error {a}° | greatest {a}° | nothing {a}°" for a in SAMPLED) + " |",
             "|---" * (2 + 3 * len(SAMPLED)) + "|"]
    for (model, _, _, label), one in found:
        by_angle = {row["theta_i_deg"]: row for row in one["sampling"]}
        cells = []
        for angle in SAMPLED:
            row = by_angle[angle]
            cells += [f"{100 * row['relative_standard_error_1e5']:.3f} %", f"{row['greatest_weight_over_mean']:.3g}", f"{row['nothing']:.3f}"]
        text.append(f"| {short(model)} | {label} | " + " | ".join(cells) + " |")
    pulls = [(row["mean"] - energy["total"]) / row["standard_error"]
             for _, one in found for row, energy in zip(one["sampling"], one["energy"])
             if row["standard_error"] > 1e-6 * row["mean"]]
    rms = (sum(p * p for p in pulls) / len(pulls)) ** 0.5
    text += ["", f"The {len(pulls)} reflectances found by drawing differ from the integrated ones by {rms:.2f} standard errors (root mean square),",
             f"{max(map(abs, pulls)):.1f} at most. All use the same random numbers, so that they scatter together."]
    return "\n".join(text) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    parser.add_argument("--draws", type=int, default=100000, help="directions drawn at each incidence")
    options = parser.parse_args()
    found = []
    for row in rows():
        found.append((row, check(row[0], row[1], row[2], options.draws)))
        print(short(row[0]), row[3], " ".join(f"{r:.3f}" for r in found[-1][1]["reflectance"]), flush=True)
    text = page(found, commit(), options.draws)
    if options.output:
        pathlib.Path(options.output).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
