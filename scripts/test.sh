#!/usr/bin/env bash
# Runs `cargo test` and ends with the ten slowest tests, the tests that failed, and one line with the sums.
#
# usage: scripts/test.sh [ARGUMENTS OF CARGO TEST]
set -uo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
if [[ ${1-} = --timed ]]; then
    # Cargo starts every test program through this line. The standard test harness prints times only where unstable options are
    # allowed; the variable allows them in the program that runs, not in what is compiled. Documentation tests are left alone.
    [[ $2 = */deps/* ]] && RUSTC_BOOTSTRAP=1 exec "${@:2}" -Zunstable-options --report-time
    exec "${@:2}"
fi

# Lavapipe compiles every kernel with LLVM. Tests run it for milliseconds, so that most of their time went into optimising it.
export GALLIVM_PERF=${GALLIVM_PERF-nopt}

# Where RUST_BACKTRACE=1 is set: panics have backtraces, errors that are values do not. The library that reflects kernels makes hundreds
# of such errors a kernel and drops them.
export RUST_LIB_BACKTRACE=${RUST_LIB_BACKTRACE-0}

log=$(mktemp)
trap 'rm -f "$log"' EXIT
cargo test --config "target.'cfg(all())'.runner = ['$here/test.sh', '--timed']" "$@" 2>&1 | tee "$log"
status=${PIPESTATUS[0]}

awk -v cargo="$status" '
    $1 == "Running" { split($NF, path, "[/()]"); target = path[length(path) - 1]; sub(/-[0-9a-f]+$/, "", target) }
    $1 == "Doc-tests" { target = "documentation of " $2 }
    match($0, /^test .* \.\.\. (ok|FAILED) <[0-9.]+s>$/) {
        seconds[++count] = substr($NF, 2) + 0
        line[count] = sprintf("%8.1f s  %s: %s", seconds[count], target, $2)
    }
    /^test .* \.\.\. FAILED/ { failures = failures "  " target ": " $2 "\n" }
    # A program that crashed has no result line; one with failed tests leaves with 101.
    target && /process didn.t exit successfully: / && !/exit status: 101\)/ { crashed++; crashes = crashes "  " target "\n" }
    /^test result: / { programs++; passed += $4; failed += $6; ignored += $8 }
    END {
        if (!programs && !crashed) exit
        print "\nslowest tests:"
        for (rank = 1; rank <= 10 && rank <= count; rank++) {
            slowest = 0
            for (i in seconds) if (!slowest || seconds[i] > seconds[slowest]) slowest = i
            print line[slowest]
            delete seconds[slowest]
        }
        if (failures) printf "\nfailed tests:\n%s", failures
        if (crashes) printf "\ntest programs that crashed, whose other tests are not counted:\n%s", crashes
        failed += crashed
        if (cargo && !failed) {
            failed = 1
            print "\ncargo test failed: see above"
        }
        printf "\n%d passed, %d failed, %d skipped\n", passed, failed, ignored
    }
' "$log"
exit "$status"
