#!/usr/bin/env bash
# Renders one small frame through the program, as a user does, and fails on any message of the validation layer.
#
# usage: scripts/check-frame.sh PT...      (the command that starts pt, for example: cargo run -p pt-app --)
set -euo pipefail

out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# Enabled from outside, so that the very program that users run is checked; older layers read the second line.
export VK_INSTANCE_LAYERS=VK_LAYER_KHRONOS_validation VK_KHRONOS_VALIDATION_VALIDATE_SYNC=true
export VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT

"$@" render cornell --size 160x90 --frames 2 -o "$out/frame.png" -o "$out/frame.exr" 2>&1 | tee "$out/log"

if grep -qE 'VUID-|SYNC-HAZARD|Validation (Error|Warning)' "$out/log"; then
    echo "check-frame: the validation layer complained (above)" >&2
    exit 1
fi
for image in frame.png frame.exr; do
    [[ -s $out/$image ]] || { echo "check-frame: pt wrote no $image" >&2; exit 1; }
done
