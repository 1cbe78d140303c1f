#!/usr/bin/env bash
# Compares the light samplers of pt-lights on one scene, and shows the result in pt-lights/README.md: writes docs/light_samplers_SCENE.svg and
# puts the table, with device, driver and command, between the README's markers for the scene.
#
# usage: scripts/light_samplers.sh [SCENE] [MORE ARGUMENTS OF PT-LIGHTS...]
#   SCENE        built-in scene or glTF file [default: lamps]
# environment: PT_LIGHTS the program [default: cargo run --release -p pt-lights --]; README the file with the markers
#   [pt-lights/README.md]; FIGURE the figure [docs/light_samplers_SCENE.svg]
set -euo pipefail

if [[ ${1-} = -h || ${1-} = --help ]]; then
    sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"
    exit 0
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scene=${1-lamps}
[[ $# -eq 0 ]] || shift
read -ra program <<<"${PT_LIGHTS:-cargo run --release -p pt-lights --}"
name=$(basename "${scene%.*}")
readme=${README:-pt-lights/README.md} figure=${FIGURE:-docs/light_samplers_$name.svg}
begin="<!-- samplers of $name: generated, see scripts/light_samplers.sh -->" end="<!-- end of samplers of $name -->"
for marker in "$begin" "$end"; do
    grep -qxF -- "$marker" "$readme" || { echo "light_samplers: $readme has no line \"$marker\"" >&2; exit 2; }
done

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"${program[@]}" "$scene" "$@" --figure "$figure" --markdown "$work/table.md" --json "$work/rows.json" | tee "$work/printed"

{
    echo "$begin"
    echo "\`pt-lights ${scene##*/}${*:+ $*}\`; $(sed -n '1p' "$work/printed")."
    echo
    echo "![Error and GPU time](../$figure)"
    echo
    cat "$work/table.md"
    echo "$end"
} >"$work/section.md"
awk -v begin="$begin" -v end="$end" -v section="$work/section.md" '
    $0 == begin { while ((getline line < section) > 0) print line; skip = 1 }
    !skip { print }
    $0 == end { skip = 0 }
' "$readme" >"$work/readme.md"
cp "$work/readme.md" "$readme"
echo "$readme and $figure are up to date"
