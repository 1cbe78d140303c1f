#!/usr/bin/env bash
# Makes docs/kinds.png: a picture of each kind of material, from the scene `kinds`.
#
# usage: scripts/kinds_sheet.sh [PT]
#
# PT is the program [default: target/release/pt]. SIZE and FRAMES set the size of a picture and the frames of which it is the last, for example
# SIZE=128x96 FRAMES=8 on a CPU.
set -euo pipefail

fail() {
    printf 'kinds_sheet: %s\n' "$*" >&2
    exit 2
}

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
pt=${1:-target/release/pt}
command -v "$pt" >/dev/null || fail "$pt is missing; build it with cargo build --release -p pt-app"
readonly size=${SIZE:-256x192} frames=${FRAMES:-64}
readonly kinds=(regular chrome chrome-model glass water slime lava sky invisible explosion transparent-wall transparent-model screen camera)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
pictures=()
for kind in "${kinds[@]}"; do
    "$pt" render kinds --camera "$kind" --size "$size" --frames "$frames" --accumulate -o "$work/$kind.png"
    pictures+=("$work/$kind.png")
done
"$pt" sheet "${pictures[@]}" --columns 5 --tile "$size" -o docs/kinds.png
