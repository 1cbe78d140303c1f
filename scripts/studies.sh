#!/usr/bin/env bash
# Runs the studies that ship with pt, and writes what they found into the book: docs/src/generated/findings/NAME.md. Run it on a GPU.
#
# usage: scripts/studies.sh [-o DIR] [NAME...]
#   -o DIR   folder of the results, which also keeps references for all studies [default: out/studies]; a run that was stopped goes on there
#   NAME     studies/NAME.toml [default: all]
# environment: PT the program [default: cargo run --release -p pt-app --]; STUDY_ARGS more arguments of pt study, such as "--filter seed=0"
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
read -ra program <<<"${PT:-cargo run --release -p pt-app --}"
read -ra more <<<"${STUDY_ARGS-}"
names=("$@")
if [[ $# -eq 0 ]]; then
    for file in studies/*.toml; do
        name=${file##*/}
        names+=("${name%.toml}")
    done
fi
findings=docs/src/generated/findings
mkdir -p "$findings"
for name in "${names[@]}"; do
    echo "== $name: $SECONDS s"
    "${program[@]}" study "studies/$name.toml" -o "$results/$name" --cache "$results/references" --resume "${more[@]}"
    "${program[@]}" study report "$results/$name" --markdown "$findings/$name.md" >/dev/null
done
echo "$findings: ${#names[@]} studies in $SECONDS s"
