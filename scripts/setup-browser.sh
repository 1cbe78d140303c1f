#!/usr/bin/env bash
# Makes sure that there is a browser for the test of the report of a study: headless chromium.
#
# usage: scripts/setup-browser.sh
#
# Where it cannot be installed, the script says so; the test is ignored then.
set -euo pipefail

say() { printf 'setup-browser: %s\n' "$*"; }

for browser in chromium-headless-shell chromium chromium-browser google-chrome google-chrome-stable; do
    command -v "$browser" >/dev/null && say "ready: $browser" && exit 0
done
if [[ $(id -u) -eq 0 ]]; then
    as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    say "no chromium, and neither root nor sudo without a password to install it: the test of the report in a browser is ignored"
    exit 0
fi
# The shell alone is the smaller package; releases that lack it have the whole browser.
install() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qy -o DPkg::Lock::Timeout=300 install \
        --no-install-recommends "$1" >/dev/null 2>&1 </dev/null
}
if command -v apt-get >/dev/null; then
    install chromium-headless-shell || {
        "${as_root[@]}" apt-get -qy update >/dev/null 2>&1 </dev/null || true
        install chromium-headless-shell || install chromium || true
    }
fi
if command -v chromium-headless-shell >/dev/null || command -v chromium >/dev/null; then
    say "ready"
else
    say "chromium could not be installed: the test of the report in a browser is ignored"
fi
