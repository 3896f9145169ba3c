#!/usr/bin/env bash
# Sets up everything that the project needs on a Debian machine: toolchain packages, then a Python environment in .venv.
# Sourced or run by demo.sh and test.sh; run again, it only does what is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

packages=(g++ clang gcc-avr avr-libc binutils-avr simavr libsimavr-dev arduino-core-avr libelf-dev pkg-config python3 python3-venv)
[ "${1:-}" != test ] || packages+=(chromium) # the page of gen live is tested in a browser
missing=()
for package in "${packages[@]}"; do
    status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
    [ "$status" = installed ] || missing+=("$package")
done
if [ ${#missing[@]} -gt 0 ]; then
    echo "Installing: ${missing[*]}"
    sudo=()
    [ "$(id -u)" = 0 ] || sudo=(sudo)
    if ! { "${sudo[@]}" apt-get update -qq && DEBIAN_FRONTEND=noninteractive "${sudo[@]}" apt-get install -y -qq "${missing[@]}"; } >/tmp/gen-setup-$$.log 2>&1; then
        tail -n 5 "/tmp/gen-setup-$$.log" >&2
        echo "These packages are missing and could not be installed: ${missing[*]}" >&2
        echo "Install them with: sudo apt-get install ${missing[*]}" >&2
        exit 2
    fi
    rm -f "/tmp/gen-setup-$$.log"
fi

python=python3
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Python 3.11 or later is needed, found $("$python" --version)" >&2; exit 2; }
extras=${1:-}
stamp=.venv/.gen-setup-${extras:-run}
if [ ! -e "$stamp" ] || [ pyproject.toml -nt "$stamp" ]; then
    [ -x .venv/bin/python ] || "$python" -m venv .venv
    .venv/bin/pip install --quiet --disable-pip-version-check --editable ".${extras:+[$extras]}"
    touch "$stamp"
fi
