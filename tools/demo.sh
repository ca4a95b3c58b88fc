#!/usr/bin/env bash
# The main job, end to end: an emulated scan of red gloss paint and the NIST measurement of PTFE,
# each calibrated or imported, inverted and put into one report.
set -euo pipefail
cd "$(dirname "$0")/.."
umov=build/release/bin/umov
out=build/demo
rm -rf "$out"
mkdir -p "$out"

run() { printf '\n$ umov %s\n' "$*"; "$umov" "$@"; }

# An instrument with real imperfections measures its white standard, then the paint.
run scan examples/plans/white.toml --sample white-99 --preset realistic --seed 1 -o "$out/white.h5"
run scan examples/plans/red-gloss.toml --sample red-gloss --preset realistic --seed 2 -o "$out/red-gloss.h5"
run calibrate "$out/white.h5" -o "$out/cal.h5"
run reduce "$out/red-gloss.h5" --calibration "$out/cal.h5" -o "$out/red-gloss-brdf.h5"
run invert "$out/red-gloss-brdf.h5" --model li-torrance -o "$out/red-gloss-fit.json"

# A real measurement: fitted in the plane of incidence, predicted out of it.
run import tests/data/nist_ptfe/PTFE.csv --kind nist-ptfe -o "$out/ptfe-brdf.h5"
run invert "$out/ptfe-brdf.h5" --model microfacet+nef --rows in-plane -o "$out/ptfe-fit.json"

run report "$out/red-gloss.h5" "$out/cal.h5" "$out/red-gloss-brdf.h5" "$out/red-gloss-fit.json" \
  "$out/ptfe-brdf.h5" "$out/ptfe-fit.json" --title "Umov demonstration" -o "$out/report.html"
printf '\nOpen %s/%s/report.html in a browser.\n' "$PWD" "$out"
