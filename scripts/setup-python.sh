#!/usr/bin/env bash
# Puts the Python modules of the example examples/read_capture.py into target/python, for its test.
#
# usage: scripts/setup-python.sh
#
# Without Python 3, pip or a package index it says so; the test is ignored then.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly folder=target/python modules=(OpenEXR==3.5.3 numpy)

say() { printf 'setup-python: %s\n' "$*"; }

[[ -d $folder/numpy ]] && PYTHONPATH=$folder python3 -c "import numpy, OpenEXR" 2>/dev/null && say "ready" && exit 0
python3 -m pip --version >/dev/null 2>&1 || [[ $(id -u) -ne 0 ]] || apt-get install -y -qq python3-pip >/dev/null 2>&1 || true
if python3 -m pip install -q --root-user-action ignore --target "$folder" "${modules[@]}" >/dev/null 2>&1; then
    say "ready"
else
    say "no Python 3 with pip, or no package index: the test of examples/read_capture.py is ignored"
fi
