#!/usr/bin/env bash
# Makes docs/caustics.png: sunlight through balls of glass and bowls of water, without caustics, with them, and as the reference. The frames are
# means of frames without denoiser, with direct light of the sun alone.
#
# usage: scripts/caustics_picture.sh [PT]
#
# PT is the program [default: target/release/pt]. SIZE, FRAMES and SPP set the size of a picture, the frames that are averaged, and the
# samples of the reference, which finds the small disc of the sun by chance.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} size=${SIZE:-480x270} frames=${FRAMES:-128} spp=${SPP:-65536}
command -v "$pt" >/dev/null || {
    printf 'caustics_picture: %s is missing; build it with cargo build --release -p pt-app\n' "$pt" >&2
    exit 2
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
view=(kinds --look 1.5,1.0,-6.3,2.35,0.15,-4.85 --vfov 24 --size "$size")
light=(--set lights.environment=false --set lights.emissive=false --set lights.positional=false --set indirect.bounces=0)
"$pt" render "${view[@]}" "${light[@]}" --profile still --accumulate --frames "$frames" -o "$work/without.exr"
"$pt" render "${view[@]}" "${light[@]}" --set lights.caustics=true --set lights.caustics_cell=0.01 --profile still --accumulate --frames "$frames" \
    -o "$work/with.exr"
"$pt" reference "${view[@]}" --light-types sun --max-bounces 12 --spp "$spp" -o "$work/reference.exr"
"$pt" sheet "$work/without.exr" "$work/with.exr" "$work/reference.exr" --columns 3 --tile "$size" -o docs/caustics.png
