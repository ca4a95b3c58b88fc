#!/usr/bin/env bash
# Studies behind figures in docs/studies. ./dev study NAME [options]
set -euo pipefail
cd "$(dirname "$0")/.."
umov=build/release/bin/umov

# A study of the program itself: page, figures and numbers go to build/studies/NAME, the page and its
# figures as SVG to docs/studies.
program_study() {
  local name=$1 folder=build/studies/$1; shift
  "$umov" study "$name" -o "$folder" "$@"
  /usr/bin/python3 tools/studies/figures.py "$folder/figures.json" -o docs/studies --prefix "$name-" >/dev/null
  { cat "$folder/$name.md"; echo; /usr/bin/python3 tools/provenance.py "./dev study $name${*:+ $*}"; } >"docs/studies/$name.md"
  echo "page: docs/studies/$name.md; with moving figures: $folder/index.html"
}

# The catalogue of effects is a page of the documentation by itself.
effects_study() {
  local folder=build/studies/effects
  "$umov" study effects -o "$folder" "$@"
  /usr/bin/python3 tools/studies/figures.py "$folder/figures.json" -o docs/effects >/dev/null
  cp "$folder/effects.md" docs/effects/README.md
  echo "page: docs/effects/README.md; with moving figures: $folder/index.html"
}

case "${1:-}" in
  blind) /usr/bin/python3 tools/studies/blind.py -o docs/studies/gap.md "${@:2}" ;;
  effects) effects_study "${@:2}" ;;
  coverage) /usr/bin/python3 tools/studies/coverage.py -o docs/studies/coverage.md "${@:2}" ;;
  dolp) /usr/bin/python3 tools/studies/dolp.py -o docs/studies/dolp.md "${@:2}" ;;
  models) /usr/bin/python3 tools/studies/models.py -o docs/models.md "${@:2}" ;;
  "")
    "$umov" study
    echo "blind            are effects named that the diagnosis is not told? (2000 cases, hours, goes on where it stopped; --cases 40)"
    echo "coverage         do the 95 % intervals of the inversion hold the truth? (100 seeds, some ten minutes; --seeds 500 --keep FOLDER)"
    echo "dolp             degree of linear polarisation of four paints in the mirror direction (seconds)"
    echo "models           energy, reciprocity and sampling of every model of the library"
    ;;
  *)
    # A study by file: tools/studies/NAME.py writes its page, and its figures where it has any.
    if [[ -f tools/studies/$1.py && $1 != figures ]]; then
      /usr/bin/python3 "tools/studies/$1.py" -o "docs/studies/$1.md" "${@:2}"
    elif "$umov" study | grep "^$1 " >/dev/null; then
      program_study "$@"
    else
      echo "dev: there is no study '$1'; ./dev study lists them" >&2
      exit 2
    fi
    ;;
esac
