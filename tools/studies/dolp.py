#!/usr/bin/python3
"""Degree of linear polarisation in the mirror direction of four emulated paints, as measured.

Scan, calibration and reduction on the ideal bench; DOLP = (PP - PS)/PU for P-polarised light (P4).
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from provenance import UMOV, commit  # noqa: E402

PAINTS = ("black-matte", "black-semi-gloss", "black-gloss", "red-gloss")
INCIDENCES = (10, 30, 45, 56, 65)
WAVELENGTHS = (532, 633, 814)

WHITE = """
sample = "white-99"
role = "white"
wavelengths_nm = [532, 633, 814]
theta_i_deg = [0]
theta_r_deg = { from = -80, to = 80, step = 10 }
states = [["P", "P"], ["P", "S"], ["P", "open"]]
dwell_ms = 50
"""

PAINT = """
sample = "paint"
wavelengths_nm = [532, 633, 814]
theta_i_deg = %s
theta_r_deg = "mirror"
states = [["P", "P"], ["P", "S"], ["P", "open"]]
dwell_ms = 100
""" % list(INCIDENCES)


def umov(*arguments):
    done = subprocess.run([UMOV, *map(str, arguments)], text=True, capture_output=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"umov {' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def measure():
    """{(paint, wavelength, incidence): (DOLP, one-sigma uncertainty)}"""
    import h5py  # Debian's python3-h5py

    found = {}
    with tempfile.TemporaryDirectory(prefix="umov-dolp-") as name:
        here = pathlib.Path(name)
        (here / "white.toml").write_text(WHITE)
        (here / "paint.toml").write_text(PAINT)
        umov("emulator", "--certificate", "white-99", "-o", here / "white.csv")
        umov("scan", here / "white.toml", "-o", here / "white.h5", "--quiet")
        umov("calibrate", here / "white.h5", "--reference-brdf", here / "white.csv", "-o", here / "cal.h5")
        for seed, paint in enumerate(PAINTS):
            scan, brdf = here / f"{paint}.h5", here / f"{paint}-brdf.h5"
            umov("scan", here / "paint.toml", "--sample", paint, "--seed", 10 + seed, "-o", scan, "--quiet")
            umov("reduce", scan, "--calibration", here / "cal.h5", "-o", brdf)
            with h5py.File(brdf) as file:
                dolp = {column: file["dolp"][column][()] for column in file["dolp"]}
            for i, value in enumerate(dolp["dolp"]):
                key = (paint, round(dolp["wavelength_nm"][i]), round(dolp["theta_i_deg"][i]))
                found[key] = (float(value), float(dolp["dolp_u"][i]))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", help="Markdown page to write")
    options = parser.parse_args()
    found = measure()
    page = ["# Polarisation in the mirror direction", "",
            "DOLP (P4) of emulated paints for P-polarised light at θr = θi, measured on the ideal bench and reduced with a",
            "white standard; ± is one sigma. The rougher and brighter the paint, the less of the light keeps its",
            "polarisation: black paints order matte < semi-gloss < gloss, the red paint is as polarised as gloss black where",
            "it absorbs (532 nm) and less where light comes back from under its surface (633 and 814 nm). Towards Brewster's",
            "angle (56° for n = 1.5) the surface reflects no P light and the depolarised light remains.", "",
            f"Command `./dev study dolp`, commit {commit()}.", "",
            "| paint | nm | " + " | ".join(f"θi = {t}°" for t in INCIDENCES) + " |",
            "|---|---|" + "---|" * len(INCIDENCES)]
    for paint in PAINTS:
        for wavelength in WAVELENGTHS:
            cells = [f"{found[paint, wavelength, t][0]:.4f} ± {found[paint, wavelength, t][1]:.4f}" for t in INCIDENCES]
            page.append(f"| {paint} | {wavelength} | " + " | ".join(cells) + " |")
    text = "\n".join(page) + "\n"
    print(text)
    if options.output:
        pathlib.Path(options.output).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
