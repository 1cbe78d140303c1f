#!/usr/bin/env bash
# Renders a reference as a Slurm array over slices of its samples, and joins them with a job that depends on the array.
#
# usage: scripts/slurm/reference.sh [OPTIONS] -- SCENE --spp N -o OUT.exr [options of pt reference]
#
#   --slices N      slices, each a job of the array [default: 4]
#   --at-once M     at most M of them run at the same time
#   --retries R     attempts after the first one that a slice has; it goes on from its last checkpoint [default: 2]
#   --work DIR      folder for slices, checkpoints and logs, which all machines see [default: OUT.exr.slices]
#   --pt PROGRAM    the program [default: target/release/pt of this checkout, or pt]
#   --sbatch OPTION option for sbatch, such as --sbatch --partition=gpu; may be repeated
#   --wait          wait until OUT.exr is there
#
# Slurm repeats a job whose machine failed; it goes on from its checkpoint, too. Submitting the same command again keeps the slices that are
# finished. The result is that of `pt merge` over the same slices, bit by bit, on machines with the same device.
# Exit code 0: submitted, or done with --wait; 2: what is wrong has been printed.
set -euo pipefail

script=$(realpath "${BASH_SOURCE[0]}")
readonly script name=reference parts_option=--slices
# shellcheck source=scripts/slurm/common.sh
. "$(dirname "$script")/common.sh"

# Samples of slice $1.
range() {
    take --spp --spp
    samples=$value
    first=$((samples * $1 / parts)) end=$((samples * ($1 + 1) / parts))
}

# Renders a slice. It is complete only when pt says that it has all of its samples.
slice() {
    local said
    said=$("$pt" reference "${rest[@]}" --spp "$samples" --spp-range "$first..$end" --no-aov \
        --checkpoint "$slice.checkpoint" --resume -o "$slice.part.exr") || return 1
    printf '%s\n' "$said"
    grep -q ", $((end - first)) samples a pixel," <<<"$said" || return 1
    mv "$slice.part.exr" "$slice.exr"
    rm -f "$slice.checkpoint"
}

join() {
    # A slice may be there with another name only if somebody put it there.
    local slices=() index
    for ((index = 0; index < parts; index++)); do slices+=("$work/slice_$index.exr"); done
    "$pt" merge "${slices[@]}" "${flag[@]}" -o "$result" && touch "$work/joined" && rm -f "${slices[@]}"
}

case ${1-} in
    task)
        read_work "$2"
        range "$SLURM_ARRAY_TASK_ID"
        take_flag --no-aov
        slice=$work/slice_$SLURM_ARRAY_TASK_ID
        [[ ! -e $slice.exr ]] || { say "slice $SLURM_ARRAY_TASK_ID is there" && exit 0; }
        attempt slice
        exit 0
        ;;
    join)
        read_work "$2"
        take_flag --no-aov
        attempt join
        exit 0
        ;;
esac
parse_options "$@"
take -o --output
result=$value
[[ $result = *.exr ]] || fail "the image to write is missing: -o OUT.exr"
take --spp --spp
[[ $value =~ ^[1-9][0-9]{0,8}$ ]] || fail "the number of samples is missing: --spp N"
samples=$value
refuse --spp-range --checkpoint --resume --checkpoint-interval --time-limit
[[ $parts -le $samples ]] || parts=$samples
[[ -d $(dirname "$result") ]] || fail "the folder of $result does not exist"
result=$(realpath -m "$result")
work=${work:-$result.slices}
rest+=(--spp "$samples")
rm -f "$work/joined"
submit
