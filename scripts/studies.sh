#!/usr/bin/env bash
# Runs the studies that ship with pt, and writes what they found into the book: docs/src/generated/findings/NAME.md and NAME.svg. Run it on a GPU.
#
# usage: scripts/studies.sh [-o DIR] [NAME...]
#   -o DIR   folder of the results, which also keeps references for all studies [default: out/studies]; a run that was stopped goes on there
#   NAME     studies/NAME.toml [default: all]
# environment: PT the program [default: cargo run --release -p pt-app --]; FINDINGS the folder written to; JOBS how many studies run at a time
#   [default: 1]; STUDY_ARGS more arguments of pt study, such as "--filter seed=0"
set -euo pipefail

if [[ ${1-} = -h || ${1-} = --help ]]; then
    sed -n '2,/^set/{/^#/s/^# \{0,1\}//p}' "$0"
    exit 0
fi
cd "$(dirname "${BASH_SOURCE[0]}")/.."
results=out/studies
if [[ ${1-} = -o ]]; then
    results=${2:?"-o needs a folder"}
    shift 2
fi
names=("$@")
if [[ $# -eq 0 ]]; then
    for file in studies/*.toml; do
        name=${file##*/}
        names+=("${name%.toml}")
    done
fi
export results findings=${FINDINGS:-docs/src/generated/findings} PT=${PT:-cargo run --release -p pt-app --} STUDY_ARGS=${STUDY_ARGS-}
mkdir -p "$findings" "$results"

run_study() {
    set -euo pipefail
    local name=$1 begin=$SECONDS program more
    read -ra program <<<"$PT"
    read -ra more <<<"$STUDY_ARGS"
    "${program[@]}" study "studies/$name.toml" -o "$results/$name" --cache "$results/references" --resume "${more[@]}" >"$results/$name.txt" ||
        { echo "studies: $name failed" >&2 && return 1; }
    "${program[@]}" study report "$results/$name" --markdown "$findings/$name.md" --figure "$findings/$name.svg" >/dev/null
    echo "$name: $((SECONDS - begin)) s, $results/$name/report.html"
}
export -f run_study
printf '%s\0' "${names[@]}" | xargs -0 -n 1 -P "${JOBS:-1}" bash -c 'run_study "$1"' run_study
echo "$findings: ${#names[@]} studies in $SECONDS s"
