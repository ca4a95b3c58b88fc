#!/usr/bin/env bash
# The main job, end to end, into one report: red gloss paint on an ideal and on a realistic emulated
# bench, and two real measurements, each fitted to one part of the data and tested on the rest. Then
# a bench with an error that nobody declared, and the diagnosis that finds it.
set -euo pipefail
cd "$(dirname "$0")/.."
umov=build/release/bin/umov
out=build/demo
rm -rf "$out"
mkdir -p "$out"
start=$SECONDS

run() { printf '\n$ umov %s\n' "$*"; "$umov" "$@"; }
step() { printf '\n== %s\n' "$*"; }

files=()
run emulator --certificate white-99 -o "$out/white-99.csv"
for bench in ideal realistic; do
  step "red gloss paint on the $bench emulated bench: white standard, scan, calibration, BRDF, model"
  run scan examples/plans/white.toml --sample white-99 --preset "$bench" --seed 1 -o "$out/white-$bench.h5"
  run scan examples/plans/red-gloss.toml --sample red-gloss --preset "$bench" --seed 2 \
    --name "red gloss, $bench bench" -o "$out/scan-$bench.h5"
  run calibrate "$out/white-$bench.h5" --reference-brdf "$out/white-99.csv" -o "$out/cal-$bench.h5"
  run reduce "$out/scan-$bench.h5" --calibration "$out/cal-$bench.h5" -o "$out/brdf-$bench.h5"
  run invert "$out/brdf-$bench.h5" --model li-torrance -o "$out/fit-$bench.json"
  files+=("$out/scan-$bench.h5" "$out/cal-$bench.h5" "$out/brdf-$bench.h5" "$out/fit-$bench.json")
done

step "sintered PTFE measured by NIST: fitted in the plane of incidence, foretold out of it"
run import tests/data/nist_ptfe/ptfe_532_633.csv --kind nist-ptfe -o "$out/ptfe.h5"
run invert "$out/ptfe.h5" --rows in-plane --model li-torrance --bound n=1.2:2 -o "$out/ptfe.json"

step "sandblasted aluminium in the mid infrared (JSSS): fitted without two camera angles, which are foretold"
run import tests/data/jsss_mwir/inplane.csv --kind jsss --material "aluminium sandblasted" -o "$out/aluminium.h5"
run invert "$out/aluminium.h5" --rows theta_r_deg!=30,60 --model microfacet+nef \
  --fix 0.n=5.5 --fix 0.kappa=37 --free 0.bias -o "$out/aluminium.json"

step "the incidence stage is off by 0.1 deg: where does the simulation miss the scan, and why?"
wrong=(--sample red-gloss --preset ideal --plant-set axis.incidence.zero_deg=0.1 --seed 3)
run scan examples/plans/red-gloss.toml "${wrong[@]}" --name "red gloss, a stage is off" -o "$out/scan-off.h5"
run diagnose "$out/scan-off.h5" --calibration "$out/cal-ideal.h5" --follow-up emulator "${wrong[@]}" \
  --report "$out/diagnosis.html"

step "report"
run report "${files[@]}" "$out/ptfe.h5" "$out/ptfe.json" "$out/aluminium.h5" "$out/aluminium.json" \
  --title "Umov demonstration" -o "$out/report.html"
printf '\nDone in %d s. Open these files in a browser:\n' $((SECONDS - start))
printf '  %s\n' "$PWD/$out/report.html" "$PWD/$out/diagnosis.html"
