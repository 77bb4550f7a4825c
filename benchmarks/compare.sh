#!/bin/sh
# Times whole commands of another revision and of this tree in turn, and prints the ratios:
#
#   benchmarks/compare.sh REVISION [--only NAME]... [--repeats N] [--json]
#
# For instance `benchmarks/compare.sh HEAD~10 --only train`; `benchmarks/compare.sh --help` lists the names.
set -eu
cd "$(dirname "$0")/.."
exec "${PYTHON:-.venv/bin/python}" benchmarks/commands.py "$@"
