#!/usr/bin/env bash
# Makes docs/sky.png: the physical sky in the morning, at noon and in a hazy evening (columns), as frames and as the reference (rows).
#
# usage: scripts/sky_picture.sh [PT]
#
# PT is the program [default: target/release/pt]. SIZE, FRAMES and SPP set the size of a picture, the frames that are averaged, and the
# samples of the reference.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} size=${SIZE:-320x180} frames=${FRAMES:-64} spp=${SPP:-64}
command -v "$pt" >/dev/null || {
    printf 'sky_picture: %s is missing; build it with cargo build --release -p pt-app\n' "$pt" >&2
    exit 2
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
frame=() truth=()
# Name, elevation, azimuth and turbidity.
for sky in morning=6,115,2 noon=60,100,3 evening=5,80,6; do
    name=${sky%%=*}
    view=(textures --look 0,1.6,6,0,2.6,-4 --sky "${sky#*=}" --size "$size")
    "$pt" render "${view[@]}" --profile unbiased --frames "$frames" --accumulate -o "$work/$name.exr"
    "$pt" reference "${view[@]}" --max-bounces 1 --spp "$spp" -o "$work/$name, reference.exr"
    frame+=("$work/$name.exr")
    truth+=("$work/$name, reference.exr")
done
"$pt" sheet "${frame[@]}" "${truth[@]}" --columns 3 --tile "$size" -o docs/sky.png
