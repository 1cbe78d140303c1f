#!/usr/bin/env bash
# Makes sure that there is an X server without a screen for the tests of the window of pt view: Xvfb.
#
# usage: scripts/setup-xvfb.sh
#
# Where it cannot be installed, the script says so; the tests are ignored then.
set -euo pipefail

say() { printf 'setup-xvfb: %s\n' "$*"; }

# What winit opens at run time is part of it.
ready() { command -v Xvfb >/dev/null && ldconfig -p | grep -q libxkbcommon-x11.so.0 && ldconfig -p | grep -q libXcursor.so.1; }

ready && say "ready" && exit 0
if [[ $(id -u) -eq 0 ]]; then
    as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    say "no Xvfb, and neither root nor sudo without a password to install it: the tests of the window are ignored"
    exit 0
fi
install() {
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qy -o DPkg::Lock::Timeout=300 install \
        --no-install-recommends xvfb libxkbcommon-x11-0 libx11-xcb1 libxcursor1 libxi6 libxrandr2 >/dev/null 2>&1 </dev/null
}
if command -v apt-get >/dev/null; then
    install || {
        "${as_root[@]}" apt-get -qy update >/dev/null 2>&1 </dev/null || true
        install || true
    }
fi
if ready; then
    say "ready"
else
    say "Xvfb could not be installed: the tests of the window are ignored"
fi
