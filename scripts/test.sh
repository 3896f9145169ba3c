#!/usr/bin/env bash
# Sets up, then runs every check: formatting, lint, types, tests. GEN_CAMPAIGN=full runs the long campaigns in full.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/setup.sh test
.venv/bin/ruff format --check .
.venv/bin/ruff check .
.venv/bin/mypy
# 3 on two cores: one often waits for a board that keeps real time, or for a task that is to hang.
# worksteal: after a worker's crash the run ends (with loadgroup it waits for ever, pytest-xdist issue 1378)
.venv/bin/python -m pytest -n 3 --dist worksteal "$@"
