#!/usr/bin/env bash
# Measures the light samplers with pt-lights, and shows the results in pt-lights/README.md: puts tables, with device, driver and command, between the
# README's markers, and writes the figures docs/light_samplers_SCENE.svg. Run it on a GPU.
#
# usage: scripts/light_samplers.sh [PART...]
#   PART   lamps | gallery | room | window   ranking and figure of a scene
#          flicker                           frames until samplers have followed a change
#          sweep                             what choosing costs with more and more lights
#          blocks                            means of blocks against the reference, of lamps, cornell, gallery and Sponza
#          replay                            gradient pixels, bit for bit
#   [default: all]
# environment: PT_LIGHTS the program [default: cargo run --release -p pt-lights --]; README the file with the markers
#   [pt-lights/README.md]; FIGURES the folder of the figures [docs]; SPONZA the glTF file [../shared/scenes/Sponza/Sponza.gltf; without it that
#   part is left out]; QUICK=1 a few frames of small pictures, to try the script
set -euo pipefail

if [[ ${1-} = -h || ${1-} = --help ]]; then
    sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"
    exit 0
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
read -ra program <<<"${PT_LIGHTS:-cargo run --release -p pt-lights --}"
readme=${README:-pt-lights/README.md} figures=${FIGURES:-docs}
sponza=${SPONZA:-../shared/scenes/Sponza/Sponza.gltf}
parts=("$@")
[[ $# -gt 0 ]] || parts=(lamps gallery room window flicker sweep blocks replay)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Runs the program and puts what it says between the markers of a section.
# usage: section NAME TABLE FIGURE ARGUMENTS...
#   TABLE    table: the Markdown that the program writes; text: what it prints
#   FIGURE   file, or - without one
section() {
    local name=$1 table=$2 figure=$3
    shift 3
    local begin="<!-- $name: generated, see scripts/light_samplers.sh -->" end="<!-- end of $name -->" marker
    for marker in "$begin" "$end"; do
        grep -qxF -- "$marker" "$readme" || { echo "light_samplers: $readme has no line \"$marker\"" >&2; exit 2; }
    done
    local files=()
    [[ $table = text ]] || files+=(--markdown "$work/table.md")
    [[ $figure = - ]] || files+=(--figure "$figure")
    "${program[@]}" "$@" "${files[@]}" | tee "$work/printed"
    {
        echo "$begin"
        echo "\`pt-lights ${*/#*\/}\`; $(sed -n '1p' "$work/printed")."
        echo
        [[ $figure = - ]] || printf '![Error and GPU time](../docs/%s)\n\n' "${figure##*/}"
        if [[ $table = text ]]; then
            echo '```'
            sed '1d' "$work/printed"
            echo '```'
        else
            cat "$work/table.md"
        fi
        echo "$end"
    } >"$work/section.md"
    awk -v begin="$begin" -v end="$end" -v section="$work/section.md" '
        $0 == begin { while ((getline line < section) > 0) print line; skip = 1 }
        !skip { print }
        $0 == end { skip = 0 }
    ' "$readme" >"$work/readme.md"
    cp "$work/readme.md" "$readme"
    echo "$readme: $name is up to date"
}

# Arguments of a comparison, of a change, and of a test of blocks.
if [[ -n ${QUICK-} ]]; then
    compared=(--runs 2 --frames 2 --warm-up 2 --reference-spp 16)
    changed=("${compared[@]}") tested=("${compared[@]}")
    size=(--width 32) counts=64,256
else
    compared=(--runs 16 --frames 16 --reference-spp 4096)
    changed=(--runs 16 --frames 32 --reference-spp 4096)
    tested=(--runs 64 --frames 64 --reference-spp 16384)
    size=(--width 480) counts=64,1024,16384
fi
for part in "${parts[@]}"; do
    case $part in
    window)
        section "samplers of window" table "$figures/light_samplers_window.svg" window "${size[@]}" "${compared[@]}" \
            --samplers light-bvh:portal_share=0,light-bvh,light-bvh:portal_share=0.9 ;;
    lamps | gallery | room)
        section "samplers of $part" table "$figures/light_samplers_$part.svg" "$part" "${size[@]}" "${compared[@]}" ;;
    flicker)
        section "change of flicker" table - flicker --change 0.6:0.85 "${size[@]/480/160}" "${changed[@]}" ;;
    sweep) section "many lights" table - --lights-sweep "$counts" "${size[@]/480/1920}" ;;
    blocks)
        for scene in lamps cornell gallery; do
            section "blocks of $scene" table - "$scene" --blocks "${size[@]/480/96}" "${tested[@]}"
        done
        if [[ -f $sponza ]]; then
            section "blocks of Sponza" table - "$sponza" --lamps 400 --blocks "${size[@]/480/96}" "${tested[@]}"
        fi ;;
    replay) section "replay" text - lamps --replay "${size[@]}" --frames 8 ;;
    *) echo "light_samplers: no part is called $part" >&2; exit 2 ;;
    esac
done
