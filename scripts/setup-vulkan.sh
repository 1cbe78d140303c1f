#!/usr/bin/env bash
# Makes sure that this machine has a Vulkan driver that can run the frame.
#
# usage: scripts/setup-vulkan.sh [--tests]
#
# Does nothing when a Vulkan 1.3 device is there. Otherwise installs the loader and lavapipe, Mesa's CPU driver
# (24.1 or newer), with apt on Debian 12, Debian 13 and Ubuntu 24.04; --tests adds the Khronos validation layer.
# Asks nothing. Exit code 0: ready; 2: this machine needs help, and the commands that help have been printed.
set -euo pipefail

readonly oldest_mesa=24.1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
readonly here work log=$work/log
trap 'rm -rf "$work"' EXIT

say() { printf 'setup-vulkan: %s\n' "$*"; }
fail() {
    printf 'setup-vulkan: %s\n' "$@" >&2
    exit 2
}

tests=no
case "$#:${1-}" in
    0:) ;;
    1:--tests) tests=yes ;;
    1:-h | 1:--help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;;
    *) fail "unknown arguments '$*'; usage: scripts/setup-vulkan.sh [--tests]" ;;
esac

# ---- What is there -------------------------------------------------------------------------------------------------

# Sets found (the probe's lines) and missing (what is still to be installed, in words; empty when ready).
look() {
    # A driver that crashes while it is probed is a driver that is not there.
    found=$("$work/probe" 2>/dev/null) || [[ $? -ne 126 ]] ||
        fail "no program can run in $work (mounted noexec?); set TMPDIR to a folder where one can"
    missing=()
    grep -q '^fit ' <<<"$found" || missing+=("a Vulkan 1.3 driver")
    [[ $tests = no ]] || grep -qx validation <<<"$found" || missing+=("the Vulkan validation layer")
}

finish_if_ready() {
    [[ ${#missing[@]} -eq 0 ]] || return 0
    local device
    device=$(grep -m1 '^fit ' <<<"$found")
    [[ $tests = no ]] || device+="; validation layer there"
    say "ready: ${device#fit }"
    exit 0
}

compiler=${CXX:-c++}
# CXX may hold flags or a launcher too ("ccache g++"), so it is split into words.
# shellcheck disable=SC2086
$compiler -std=c++17 -o "$work/probe" "$here/vulkan-probe.cpp" -ldl >"$log" 2>&1 || {
    tail -n 5 "$log" >&2
    fail "the C++ compiler '$compiler' is missing or does not work; on Debian or Ubuntu: apt-get install build-essential"
}

look
finish_if_ready
say "missing: $(printf '%s, ' "${missing[@]}" | sed 's/, $//')"
grep '^unfit ' <<<"$found" | sed 's/^un/setup-vulkan: found, but un/' || true

# ---- How it is installed -------------------------------------------------------------------------------------------

help_elsewhere() { # package manager, its command: what to install where this script has not been tried
    command -v "$1" >/dev/null || return 0
    fail "this system is not set up automatically; install a Vulkan 1.3 driver and the validation layer, for example:" \
        "    $2"
}
if ! command -v apt-get >/dev/null; then
    help_elsewhere dnf "sudo dnf install vulkan-loader mesa-vulkan-drivers vulkan-validation-layers"
    help_elsewhere pacman "sudo pacman -S vulkan-icd-loader vulkan-swrast vulkan-validation-layers"
    help_elsewhere apk "doas apk add vulkan-loader mesa-vulkan-swrast vulkan-validation-layers"
    help_elsewhere brew "brew install vulkan-loader molten-vk vulkan-validationlayers"
    fail "no known package manager here; install a Vulkan loader (libvulkan.so.1), a Vulkan 1.3 driver (your GPU's, or" \
        "lavapipe of Mesa $oldest_mesa or newer) and the Khronos validation layer, VK_LAYER_KHRONOS_validation"
fi
# shellcheck source=/dev/null
distribution=$(. /etc/os-release && printf '%s' "${ID-} ${VERSION_ID-}")

# Each step is "what it does|command for a root shell": run one after the other, or printed when root is out of reach.
steps=()
readonly apt="DEBIAN_FRONTEND=noninteractive apt-get -qy -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3"
readonly install="$apt install --no-install-recommends"

# Debian 12's own Mesa is 22.3. Its backports come from the mirror, and with the key, that its other packages come from.
add_backports() {
    local targets entry mirror file number keyring=/usr/share/keyrings/debian-archive-keyring.gpg
    # --no-release-info: the sources whose lists have not been read yet, too
    # shellcheck disable=SC2016 # the variables are apt's
    targets=$(apt-get indextargets --no-release-info --format '$(RELEASE) $(REPO_URI) $(SOURCESENTRY)' \
        'Created-By: Packages')
    ! grep -q '^bookworm-backports ' <<<"$targets" || return 0
    read -r _ mirror entry <<<"$(grep -m1 -E '^bookworm (https?:|mirror\+)' <<<"$targets")" || true
    if [[ -n ${mirror-} ]]; then
        # The entry is FILE:STANZA or FILE:LINE; without a key named there, apt's trusted ones do here too.
        file=${entry%:*} number=${entry##*:}
        case $file in
            *.sources) entry=$(awk -v RS= "/(^|\n)Types:/ && ++n == $number" "$file") ;;
            *) entry=$(sed -n "${number}p" "$file") ;;
        esac
        keyring=$(grep -m1 -ioE '(^|[[ ])signed-by[:=] *[^] ]+' <<<"$entry" | sed 's/^[^/]*//') || true
    fi
    local line="deb ${keyring:+[signed-by=$keyring] }${mirror:-http://deb.debian.org/debian} bookworm-backports main"
    steps+=("adding bookworm-backports|echo '$line' > /etc/apt/sources.list.d/pt-bookworm-backports.list")
}

[[ $distribution != "debian 12" ]] || add_backports
steps+=("reading the package lists|$apt update")
for item in "${missing[@]}"; do
    case "$item:$distribution" in
        *driver:"debian 12")
            steps+=("installing the loader and lavapipe|$install -t bookworm-backports libvulkan1 mesa-vulkan-drivers") ;;
        *driver:*)
            steps+=("installing the loader and lavapipe|$install libvulkan1 mesa-vulkan-drivers") ;;
        *layer:*)
            steps+=("installing the validation layer|$install libvulkan1 vulkan-validationlayers") ;;
    esac
done

# ---- Doing it ------------------------------------------------------------------------------------------------------

if [[ $(id -u) -eq 0 ]]; then
    as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    fail "neither root nor sudo without a password here; run this in a root shell, then try again:" "${steps[@]/#*|/    }"
fi
for step in "${steps[@]}"; do
    say "${step%%|*}"
    # One log for all: when the lists could not be read, apt says why there and fails only at the installation.
    "${as_root[@]}" sh -c "${step#*|}" >>"$log" 2>&1 </dev/null || {
        tail -n 15 "$log" >&2
        fail "that did not work (its last lines are above); run this in a root shell, then try again:" "${steps[@]/#*|/    }"
    }
done

look
finish_if_ready
if [[ -n ${VK_DRIVER_FILES-}${VK_ICD_FILENAMES-} ]]; then
    fail "still missing: ${missing[*]}. VK_DRIVER_FILES or VK_ICD_FILENAMES is set, and the loader sees only the" \
        "drivers named there: name one that exists, or unset it."
fi
fail "installed what $distribution offers, but still missing: ${missing[*]}." \
    "A newer release of the system, or the GPU vendor's driver, is needed: Vulkan 1.3, and for lavapipe Mesa $oldest_mesa."
