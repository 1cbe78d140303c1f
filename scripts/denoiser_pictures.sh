#!/usr/bin/env bash
# Makes docs/denoisers.png: four sequences (rows), each without a denoiser, with svgf, with asvgf, and as the path tracer has it (columns).
#
#   still     gallery while nothing moves, after FRAMES frames: what should be smooth and sharp (R1)
#   switched  flicker, 4 frames after the red lamp has gone out: what should be gone (R3)
#   moving    gallery along its camera path: what a column uncovers (R5), mirrors (R20)
#   hidden    lamps, a flat of many rooms: what should not come through a wall (R19)
#
# usage: scripts/denoiser_pictures.sh [PT] [PT_DENOISE]
#
# The programs are those of target/release. SIZE, FRAMES and SPP set the size of a picture, the frames of a sequence, and the samples of the
# ground truth, for example SIZE=160x90 FRAMES=16 SPP=64 on a CPU.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} denoise=${2:-target/release/pt-denoise}
readonly size=${SIZE:-240x135} frames=${FRAMES:-32} spp=${SPP:-256}
for program in "$pt" "$denoise"; do
    command -v "$program" >/dev/null || {
        printf 'denoiser_pictures: %s is missing; build it with cargo build --release -p pt-app -p pt-denoise\n' "$program" >&2
        exit 2
    }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
last=$(printf %06d $((frames - 1)))
pictures=()

# row NAME SCENE TIME FPS [OPTIONS]: the last frame of a sequence that starts at TIME, seconds.
row() {
    local name=$1 scene=$2 time=$3 fps=$4 dir=$work/$1
    "$pt" capture "$scene" --profile realtime --size "$size" --frames "0..$frames" --time "$time" --fps "$fps" "${@:5}" -o "$dir"
    "$denoise" "$dir" --variant off,svgf,asvgf --dump "$dir/out" >/dev/null
    local end
    end=$(awk -v t="$time" -v n="$frames" -v fps="$fps" 'BEGIN { printf "%.9f", t + (n - 1) / fps }')
    local camera=()
    [[ $* = *--camera* ]] && camera=(--camera tour)
    "$pt" reference "$scene" --size "$size" --spp "$spp" --max-bounces 1 --time "$end" "${camera[@]}" --no-aov -o "$work/$name reference.exr"
    for variant in off svgf asvgf; do
        mv "$dir/out/${variant}_$last.exr" "$work/$name $variant.exr"
        pictures+=("$work/$name $variant.exr")
    done
    pictures+=("$work/$name reference.exr")
}

row still gallery 0 1000000000
row switched flicker "$(awk -v n="$frames" 'BEGIN { printf "%.9f", 0.4 - (n - 5) / 60000 }')" 60000
row moving gallery 0 30 --camera tour
row hidden lamps 0 1000000000
"$pt" sheet "${pictures[@]}" --columns 4 --tile "$size" -o docs/denoisers.png
