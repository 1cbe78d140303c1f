# Shared by the scripts of this folder; they source it. Each of them is also what the jobs run: `SCRIPT task DIR` in the array, `SCRIPT join DIR`
# in the job that depends on it. DIR holds what the jobs need: `settings`, the arguments of pt (`arguments`, each ended by a zero byte), the
# parts, and a log for each job.

say() { printf '%s: %s\n' "$name" "$*"; }
fail() {
    printf '%s: %s\n' "$name" "$@" >&2
    exit 2
}

# The comment at the top of the script, whose lines up to `set` are the help.
help() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "$script"; }

# Options that both scripts have. Sets parts, retries, at_once, work, pt, wait, sbatch (array), and rest (the arguments behind --).
parse_options() {
    parts=4 retries=2 at_once='' work='' pt='' wait=no sbatch=() rest=()
    while [[ $# -gt 0 ]]; do
        case $1 in
            -h | --help) help && exit 0 ;;
            --wait) wait=yes && shift ;;
            --) shift && rest=("$@") && break ;;
            "$parts_option" | --retries | --at-once | --work | --pt | --sbatch)
                [[ $# -ge 2 ]] || fail "$1 needs a value; --help lists the options"
                case $1 in
                    "$parts_option") parts=$2 ;;
                    --retries) retries=$2 ;;
                    --at-once) at_once=$2 ;;
                    --work) work=$2 ;;
                    --pt) pt=$2 ;;
                    --sbatch) sbatch+=("$2") ;;
                esac
                shift 2
                ;;
            *) fail "unknown option '$1'; the arguments of pt come behind --, and --help lists the options" ;;
        esac
    done
    local number
    for number in "$parts" "$retries" "${at_once:-1}"; do
        [[ $number =~ ^[0-9]{1,6}$ ]] || fail "'$number' is no number; --help says what $parts_option, --retries and --at-once take"
    done
    [[ $parts -ge 1 ]] || fail "$parts_option must be at least 1"
    [[ ${#rest[@]} -gt 0 ]] || fail "the arguments of pt are missing; give them behind --, as --help shows"
    pt=${pt:-$(cd "$(dirname "$script")/../.." && pwd)/target/release/pt}
    pt=$(command -v "$pt") || pt=$(command -v pt) || fail "there is no program pt; build it (cargo build --release -p pt-app) or name it with --pt"
    pt=$(realpath "$pt")
    command -v sbatch >/dev/null || fail "sbatch is missing: this is no machine that submits to Slurm; the book has a line for a single machine (xargs -P)"
}

# Takes an option with its value out of rest: `take -o --output` sets value, empty where it is not given.
take() {
    local kept=() word
    value=''
    while [[ ${#rest[@]} -gt 0 ]]; do
        word=${rest[0]} rest=("${rest[@]:1}")
        case $word in
            "$1" | "$2")
                [[ ${#rest[@]} -gt 0 ]] || fail "$word needs a value"
                value=${rest[0]} rest=("${rest[@]:1}")
                ;;
            "$2="*) value=${word#*=} ;;
            *) kept+=("$word") ;;
        esac
    done
    rest=("${kept[@]}")
}

# Takes an option without a value out of rest: `take_flag --no-aov` sets flag to (--no-aov), or to () where it is not given.
take_flag() {
    local kept=() word
    flag=()
    for word in "${rest[@]}"; do
        if [[ $word = "$1" ]]; then flag=("$1"); else kept+=("$word"); fi
    done
    rest=("${kept[@]}")
}

# Refuses options that the script itself gives to pt.
refuse() {
    local word option
    for word in "${rest[@]}"; do
        for option in "$@"; do
            [[ ${word%%=*} != "$option" ]] || fail "$option is given to pt by this script; leave it out"
        done
    done
}

# Submits the array and the job that joins its parts. `result`: what the second one writes.
submit() {
    mkdir -p "$work" || fail "cannot write $work"
    work=$(cd "$work" && pwd)
    # What is there of the same work goes on; what is there of other work stays as it is.
    {
        printf '%s\0' "$parts" "$result" "${rest[@]}"
    } >"$work/arguments.new"
    if [[ -e $work/arguments ]] && ! cmp -s "$work/arguments" "$work/arguments.new"; then
        rm -f "$work/arguments.new"
        fail "$work holds the parts of other work; give another folder with --work, or remove it"
    fi
    mv "$work/arguments.new" "$work/arguments"
    printf '%s\0' "$pt" "$retries" >"$work/settings"
    local array join
    array=$(script_of task | sbatch --parsable --requeue --open-mode=append --job-name="pt-$name" --output="$work/log_%a.txt" \
        --array="0-$((parts - 1))${at_once:+%$at_once}" "${sbatch[@]}") || fail "sbatch refused the array (its message is above)"
    array=${array%%;*}
    join=$(script_of join | sbatch --parsable --requeue --open-mode=append --job-name="pt-$name-join" --output="$work/log_join.txt" \
        --dependency="afterok:$array" --kill-on-invalid-dep=yes "${sbatch[@]}") || {
        scancel "$array"
        fail "sbatch refused the job that joins the parts (its message is above); the array was cancelled"
    }
    join=${join%%;*}
    say "submitted array $array with $parts parts, and job $join that joins them into $result; logs: $work"
    [[ $wait = yes ]] || return 0
    # The queue forgets jobs some minutes after they ended.
    while [[ -n $(squeue -h -j "$join" -t all -o %T 2>/dev/null | grep -vE '^(COMPLETED|FAILED|CANCELLED|TIMEOUT|NODE_FAIL|OUT_OF_MEMORY|BOOT_FAIL|DEADLINE)$') ]]; do
        sleep 1
    done
    [[ -e $work/joined ]] || fail "the work did not end well; see the logs in $work, and submit again: finished parts are kept"
    say "done: $result"
}

# A job's script: a copy of this one in Slurm's spool folder would not find its files.
script_of() { printf '#!/bin/bash\nexec bash %q %q %q\n' "$script" "$1" "$work"; }

# Reads what `submit` wrote. Sets pt, retries, parts, result and rest.
read_work() {
    work=$1
    mapfile -d '' -t rest <"$work/arguments"
    parts=${rest[0]} result=${rest[1]} rest=("${rest[@]:2}")
    local settings
    mapfile -d '' -t settings <"$work/settings"
    pt=${settings[0]} retries=${settings[1]}
}

# Runs a function until it succeeds, as often as retries allow. What it left behind goes on where it stopped.
attempt() {
    local try
    for ((try = 0; try <= retries; try++)); do
        [[ $try -eq 0 ]] || say "attempt $((try + 1)) of $((retries + 1))"
        if "$@"; then
            return 0
        fi
    done
    fail "failed $((retries + 1)) times"
}
