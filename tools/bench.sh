#!/usr/bin/env bash
# Benchmarks behind docs/benchmarks.md.
set -euo pipefail
cd "$(dirname "$0")/.."
/usr/bin/python3 tools/benchmarks/spine.py -o docs/benchmarks.md "$@"
