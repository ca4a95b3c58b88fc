#!/usr/bin/env bash
# Benchmarks behind docs/benchmarks*.md: ./dev bench, or ./dev bench NAME [options] for one of them.
set -euo pipefail
cd "$(dirname "$0")/.."
name=${1:-all}
if (($# > 0)); then shift; fi

spine() { /usr/bin/python3 tools/benchmarks/spine.py -o docs/benchmarks.md "$@"; }
# A section of spine's page, which spine itself writes anew.
inversion() { /usr/bin/python3 tools/benchmarks/inversion.py -o docs/benchmarks.md "$@"; }
sampling() { /usr/bin/python3 tools/benchmarks/sampling.py -o docs/benchmarks_sampling.md "$@"; }
trace() { /usr/bin/python3 tools/benchmarks/trace.py -o docs/benchmarks_trace.md "$@"; }
chamber() { /usr/bin/python3 tools/benchmarks/chamber.py -o docs/benchmarks_chamber.md "$@"; }

# Fills in what docs/safety.md says of the safety matrix.
safety() { /usr/bin/python3 tools/benchmarks/safety.py -o docs/safety.md "$@"; }

controller() { /usr/bin/python3 tools/benchmarks/controller.py -o docs/benchmarks_controller.md "$@"; }

case "$name" in
  all) spine; inversion; sampling; controller; trace; chamber ;;
  spine) spine "$@"; inversion ;;
  inversion) inversion "$@" ;;
  starts) inversion --rivals 1 "$@" ;;
  sampling) sampling "$@" ;;
  controller) controller "$@" ;;
  safety) safety "$@" ;;
  trace) trace "$@" ;;
  chamber) chamber "$@" ;;
  *) echo "dev: there is no benchmark '$name'; there are spine, inversion, starts, sampling, controller, safety, trace, chamber" >&2; exit 2 ;;
esac
