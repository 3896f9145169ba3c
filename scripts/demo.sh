#!/usr/bin/env bash
# Sets up, then does the main job on the MY1016 example: builds the firmware and proves it equal to its reference.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bash scripts/setup.sh
set_up_s=$SECONDS
.venv/bin/gen build examples/my1016/coeffs.json --out build/my1016
.venv/bin/gen verify examples/my1016/coeffs.json --target all --compilers g++,clang++ --json build/verification.json
.venv/bin/gen build examples/my1016/coeffs.json --out build/my1016 --verification build/verification.json
echo "The project is in build/my1016; open build/my1016/report.html in a browser."
echo "It took $((SECONDS - set_up_s)) s after $set_up_s s of set-up."
