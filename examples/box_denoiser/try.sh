#!/usr/bin/env bash
# Adds the denoiser `box` to this checkout, builds pt, shows that the frame has it, and takes it away again.
#
# usage: examples/box_denoiser/try.sh
#
# Changes nothing outside of pt-denoise, which must be as it was committed. Exit code 1: the variant does not do what the tutorial says.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
[[ -z $(git status --porcelain pt-denoise) ]] || { echo "try.sh: pt-denoise has changes that are not committed" >&2 && exit 2; }
work=$(mktemp -d)
undo() {
    git checkout -q -- pt-denoise
    rm -rf pt-denoise/src/variants/box_filter.rs pt-denoise/shaders/box_filter.comp "$work"
}
trap undo EXIT
examples/box_denoiser/add.sh
git diff --stat -- pt-denoise
pt=(cargo run -q -p pt-app --)
"${pt[@]}" knobs denoise.variant | grep -q 'box' || { echo "try.sh: pt knobs does not list it" >&2 && exit 1; }
small=(--size 96x54 --frames 4 --set indirect.bounces=0)
"${pt[@]}" passes --scene cornell --set denoise.variant=box | grep 'denoise box'
"${pt[@]}" reference lamps --size 96x54 --spp 256 --max-bounces 0 --no-aov -o "$work/truth.exr" >/dev/null
error() {
    "${pt[@]}" render lamps "${small[@]}" --set denoise.variant="$1" -o "$work/$1.exr" >/dev/null
    "${pt[@]}" compare "$work/$1.exr" "$work/truth.exr" --metric relmse | awk '$1 == "relmse" { print $2 }'
}
off=$(error off) box=$(error box)
echo "relMSE against the reference: off $off, box $box"
# As a row of the study, once there is one.
if [[ -e studies/denoiser.toml ]]; then
    sed '0,/"svgf"/s//"svgf", "box"/' studies/denoiser.toml >"$work/denoiser.toml"
    "${pt[@]}" study "$work/denoiser.toml" -o "$work/study" --dry-run | grep -q 'box' || { echo "try.sh: the study has no row of it" >&2 && exit 1; }
    echo "studies/denoiser.toml: with \"box\" among the values of denoise.variant it is a row of the study"
fi
awk -v off="$off" -v box="$box" 'BEGIN { exit !(box < off) }' || { echo "try.sh: the mean is not less noisy than the light" >&2 && exit 1; }
