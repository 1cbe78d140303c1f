#!/usr/bin/env bash
# Renders every glTF scene below a folder, small, and puts the pictures on one sheet. A scene that is refused becomes a tile
# with the message.
#
# usage: scripts/contact_sheet.sh FOLDER OUT_FOLDER [PT...]
#   FOLDER       searched for .gltf and .glb files
#   OUT_FOLDER   gets one PNG (or .txt) a scene, and sheet.png
#   PT...        the command that starts pt [default: target/release/pt]
# environment: ENV lat-long image that lights the scenes [default: the sky that pt gives scenes without light];
#   SIZE [256x192], FRAMES [16], TIMEOUT seconds for one scene [300], ARGS more arguments of pt render
set -euo pipefail

[[ $# -ge 2 ]] || { sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0" >&2; exit 2; }
folder=$1 out=$2
shift 2
[[ $# -gt 0 ]] || set -- target/release/pt
[[ -d $folder ]] || { echo "contact_sheet: $folder is not a folder" >&2; exit 2; }
size=${SIZE:-256x192}
options=(--size "$size" --frames "${FRAMES:-16}" --accumulate --backend compute)
[[ -z ${ENV:-} ]] || options+=(--env "$ENV")
read -ra more <<<"${ARGS:-}"

mkdir -p "$out"
tiles=() shown=0 refused=0
while IFS= read -r -d '' file; do
    # Folders tell apart files of the same name.
    name=$(basename "$(dirname "$file")")_$(basename "${file%.*}")
    [[ $name != "${name%%_*}_${name%%_*}" ]] || name=${name%%_*}
    picture=$out/$name.png message=$out/$name.txt
    rm -f "$picture" "$message"
    if timeout "${TIMEOUT:-300}" "$@" render "$file" "${options[@]}" "${more[@]}" -o "$picture" >/dev/null 2>"$out/log"; then
        tiles+=("$picture") shown=$((shown + 1))
    else
        code=$?
        { grep '^error: ' "$out/log" || echo "exit code $code"; } >"$message"
        tiles+=("$message") refused=$((refused + 1))
        printf '%s: %s\n' "$name" "$(<"$message")"
    fi
done < <(find -L "$folder" -type f \( -name '*.gltf' -o -name '*.glb' \) -print0 | sort -z)
rm -f "$out/log"
[[ ${#tiles[@]} -gt 0 ]] || { echo "contact_sheet: no .gltf or .glb below $folder" >&2; exit 2; }
"$@" sheet "${tiles[@]}" -o "$out/sheet.png" --tile "$size"
echo "$shown shown, $refused refused"
