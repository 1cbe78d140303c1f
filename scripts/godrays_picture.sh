#!/usr/bin/env bash
# Makes docs/godrays.png: sunlight in the hazy air of a hall, as the last of some real-time frames, as the mean of frames, and as the reference.
# Sun and sky give light, with four bounces.
#
# usage: scripts/godrays_picture.sh [PT]
#
# PT is the program [default: target/release/pt]. SIZE, FRAMES and SPP set the size of a picture, the frames that are averaged, and the
# samples of the reference.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} size=${SIZE:-480x270} frames=${FRAMES:-256} spp=${SPP:-256}
command -v "$pt" >/dev/null || {
    printf 'godrays_picture: %s is missing; build it with cargo build --release -p pt-app\n' "$pt" >&2
    exit 2
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
view=(gallery --look 0,1.5,8,-4,3.5,-6 --size "$size")
light=(--set lights.positional=false --set lights.emissive=false --set indirect.bounces=4)
air=() truth=()
for value in density=0.06 albedo=0.9 anisotropy=0.5 max_distance=60; do
    air+=(--set "gbuffer.godrays.$value")
    truth+=(--set "reference.medium.$value")
done
"$pt" render "${view[@]}" "${light[@]}" "${air[@]}" --profile realtime --frames 16 -o "$work/frame.exr"
"$pt" render "${view[@]}" "${light[@]}" "${air[@]}" --profile unbiased --frames "$frames" --accumulate -o "$work/mean.exr"
"$pt" reference "${view[@]}" "${truth[@]}" --light-types sun,environment --max-bounces 4 --spp "$spp" -o "$work/reference.exr"
"$pt" sheet "$work/frame.exr" "$work/mean.exr" "$work/reference.exr" --columns 3 --tile "$size" -o docs/godrays.png
