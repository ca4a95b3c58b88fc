#!/usr/bin/env bash
# Studies behind figures in docs/studies. ./dev study NAME [options]
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in
  coverage) /usr/bin/python3 tools/studies/coverage.py -o docs/studies/coverage.md "${@:2}" ;;
  dolp) /usr/bin/python3 tools/studies/dolp.py -o docs/studies/dolp.md "${@:2}" ;;
  "")
    echo "coverage   do the 95 % intervals of the inversion hold the truth? (100 seeds, some 10 minutes)"
    echo "dolp       degree of linear polarisation of four paints in the mirror direction (seconds)"
    ;;
  *) echo "dev: there is no study '$1'; ./dev study lists them" >&2; exit 2 ;;
esac
