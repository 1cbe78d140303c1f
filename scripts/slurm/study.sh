#!/usr/bin/env bash
# Runs a study as a Slurm array over its shards, and joins their results with a job that depends on the array.
#
# usage: scripts/slurm/study.sh [OPTIONS] -- STUDY.toml -o DIR [options of pt study]
#
#   --shards N      shards, each a job of the array [default: 4]
#   --at-once M     at most M of them run at the same time
#   --retries R     attempts after the first one that a shard has; it goes on behind its last cell [default: 2]
#   --work DIR      folder for the results of shards and logs, which all machines see [default: DIR.shards]
#   --pt PROGRAM    the program [default: target/release/pt of this checkout, or pt]
#   --sbatch OPTION option for sbatch, such as --sbatch --partition=gpu; may be repeated
#   --wait          wait until the result is there
#
# Slurm repeats a job whose machine failed; it goes on behind its last cell, too. Submitting the same command again keeps the cells that are
# finished.
# Exit code 0: submitted, or done with --wait; 2: what is wrong has been printed.
set -euo pipefail

script=$(realpath "${BASH_SOURCE[0]}")
readonly script name=study parts_option=--shards
# shellcheck source=scripts/slurm/common.sh
. "$(dirname "$script")/common.sh"

shard() {
    local resume=()
    [[ ! -e $shard ]] || resume=(--resume)
    "$pt" study "${rest[@]}" --shard "$((SLURM_ARRAY_TASK_ID + first_shard))/$parts" "${resume[@]}" -o "$shard"
}

join() {
    local shards=() index
    for ((index = 0; index < parts; index++)); do shards+=("$work/shard_$index"); done
    "$pt" study merge "${shards[@]}" -o "$result" && touch "$work/joined"
}

# pt counts shards from 1.
readonly first_shard=1
case ${1-} in
    task)
        read_work "$2"
        shard=$work/shard_$SLURM_ARRAY_TASK_ID
        attempt shard
        exit 0
        ;;
    join)
        read_work "$2"
        attempt join
        exit 0
        ;;
esac
parse_options "$@"
take -o --output
result=$value
[[ -n $result ]] || fail "the folder of the result is missing: -o DIR"
refuse --shard --resume --dry-run
result=$(realpath -m "$result")
work=${work:-$result.shards}
rm -f "$work/joined"
submit
