#!/usr/bin/env bash
# Checks `pt bench compare` on a device: pairs of runs of one program must show no regression, and a pass that is slower by some 5 % must be found.
#
# usage: scripts/bench_check.sh [PT [PAIRS [DIR]]]
#
# PT is the program [default: target/release/pt], PAIRS the number of pairs [default: 20], DIR the folder for files [default: out/bench_check].
# The slower pass is `choose lights`, with a further candidate of resampling (`lights.ris_candidates`, 16 instead of 15).
# Ends with both counts. Exit code 0: at most one false alarm in 20, and every slower pass found; 1: not so.
set -euo pipefail

case ${1-} in -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;; esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly pt=${1:-target/release/pt} pairs=${2:-20} dir=${3:-out/bench_check}
mkdir -p "$dir"
bench=("$pt" bench frame --scene "${SCENE:-lamps}" --size "${SIZE:-1920x1080}" --backend "${BACKEND:-compute}" --frames "${FRAMES:-16}"
    --rounds "${ROUNDS:-10}" --times-only --set lights.sampler=ris --set lights.ris_candidates=15)
alarms=0 found=0
for ((pair = 1; pair <= pairs; pair++)); do
    "${bench[@]}" --json "$dir/a.json" >/dev/null
    "${bench[@]}" --json "$dir/b.json" >/dev/null
    "${bench[@]::${#bench[@]}-1}" lights.ris_candidates=16 --json "$dir/slow.json" >/dev/null
    "$pt" bench compare "$dir/a.json" "$dir/b.json" >"$dir/equal_$pair.txt" 2>&1 || {
        [[ $? -eq 1 ]] || { cat "$dir/equal_$pair.txt" && exit 2; }
        alarms=$((alarms + 1))
        tail -n 1 "$dir/equal_$pair.txt"
    }
    "$pt" bench compare "$dir/a.json" "$dir/slow.json" >"$dir/slow_$pair.txt" 2>&1 || [[ $? -eq 1 ]] || { cat "$dir/slow_$pair.txt" && exit 2; }
    grep -E "choose lights  " "$dir/slow_$pair.txt" | sed "s/^/pair $pair: /"
    ! grep -qE "choose lights .* regression" "$dir/slow_$pair.txt" || found=$((found + 1))
done
echo "$alarms of $pairs pairs of equal runs with an alarm, the slower pass found in $found of $pairs"
[[ $((20 * alarms)) -le $pairs && $found -eq $pairs ]]
