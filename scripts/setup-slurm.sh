#!/usr/bin/env bash
# Installs Slurm, for the test of scripts/slurm.
#
# usage: scripts/setup-slurm.sh
#
# Debian and Ubuntu, as root. Elsewhere it says so; the test is ignored then.
set -euo pipefail

say() { printf 'setup-slurm: %s\n' "$*"; }

for program in slurmctld slurmd munged sbatch; do
    PATH=$PATH:/usr/sbin command -v "$program" >/dev/null || missing=$program
done
[[ -n ${missing-} ]] || { say "ready" && exit 0; }
readonly apt=(env DEBIAN_FRONTEND=noninteractive apt-get -qy -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3)
if [[ $(id -u) -eq 0 ]] && command -v apt-get >/dev/null &&
    { "${apt[@]}" install --no-install-recommends slurm-wlm munge ||
        { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends slurm-wlm munge; }; } >/dev/null 2>&1; then
    say "ready"
else
    say "$missing is missing and cannot be installed here (root and apt-get are needed): the test of scripts/slurm is ignored"
fi
