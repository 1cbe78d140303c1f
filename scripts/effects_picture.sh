#!/usr/bin/env bash
# Makes docs/effects.png: the scene `effects` as the last of some real-time frames.
#
# usage: scripts/effects_picture.sh [PT]
#
# PT is the program [default: target/release/pt]. SIZE and FRAMES set the size of the picture and the number of frames.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} size=${SIZE:-480x270} frames=${FRAMES:-16}
command -v "$pt" >/dev/null || {
    printf 'effects_picture: %s is missing; build it with cargo build --release -p pt-app\n' "$pt" >&2
    exit 2
}
"$pt" render effects --profile realtime --size "$size" --frames "$frames" -o docs/effects.png
