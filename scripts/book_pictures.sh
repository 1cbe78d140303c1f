#!/usr/bin/env bash
# Makes the pictures of the book that show a stage on (left) and off (right): docs/src/pictures/STAGE.png.
#
# usage: scripts/book_pictures.sh [PT] [STAGE...]
#
# PT is the program [default: target/release/pt]. SIZE, FRAMES and SPP set the size of a picture, the frames of which it is the last, and the
# samples of the ground truth, for example SIZE=320x180 FRAMES=8 SPP=64 on a CPU.
set -euo pipefail

fail() {
    printf 'book_pictures: %s\n' "$*" >&2
    exit 2
}

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
pt=${1:-target/release/pt}
shift || true
command -v "$pt" >/dev/null || fail "$pt is missing; build it with cargo build --release -p pt-app"
readonly all=(gbuffer light-sampling lights indirect denoise checkerboard post reference) size=${SIZE:-640x360} frames=${FRAMES:-32} spp=${SPP:-1024}
[[ $# -gt 0 ]] || set -- "${all[@]}"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# side on|off, then scene and options of pt render.
side() { "$pt" render "$2" --size "$size" --frames "$frames" "${@:3}" -o "$work/$1.png"; }
realtime=(--profile realtime)

for stage in "$@"; do
    rm -f "$work"/*
    case $stage in
        gbuffer)
            side on gallery "${realtime[@]}"
            side off gallery "${realtime[@]}" --set gbuffer.reflect_refract=0
            ;;
        light-sampling)
            side on lamps --set denoise.variant=off
            side off lamps --set denoise.variant=off --set lights.sampler=uniform
            ;;
        lights)
            side on gallery "${realtime[@]}" --set indirect.bounces=0
            # Lamps alone: without the sun and the sky.
            side off gallery "${realtime[@]}" --set indirect.bounces=0 --set lights.sun=false --set lights.environment=false
            ;;
        indirect)
            side on room "${realtime[@]}"
            side off room "${realtime[@]}" --set indirect.bounces=0
            ;;
        denoise)
            side on gallery "${realtime[@]}"
            side off gallery "${realtime[@]}" --set denoise.variant=off
            ;;
        checkerboard)
            side on glass "${realtime[@]}"
            side off glass "${realtime[@]}" --set checkerboard.blend_split=false
            ;;
        post)
            side on gallery "${realtime[@]}"
            side off gallery "${realtime[@]}" --set post.taa.enabled=false --set post.tonemap=none
            ;;
        reference)
            # Both through the same exposure and curve: a frame of the path tracer is one of the real-time frame's pictures.
            "$pt" reference gallery --size "$size" --spp "$spp" --no-aov -o "$work/on.exr"
            "$pt" render gallery --size "$size" --frames "$frames" "${realtime[@]}" -o "$work/off.exr"
            ;;
        *) fail "no stage is called $stage; there are ${all[*]}" ;;
    esac
    "$pt" sheet "$work"/on.* "$work"/off.* --columns 2 --tile "$size" -o "docs/src/pictures/$stage.png"
done
