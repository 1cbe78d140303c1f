#!/usr/bin/env bash
# Adds the denoiser `box` to a copy of this checkout, builds pt there, and runs studies/denoiser.toml, small: `box` is a row of it, with a
# lower error than the light that is not filtered.
#
# usage: examples/box_denoiser/try.sh
#
# The checkout stays as it is. What is built in its target folder is copied, so that cargo builds pt-denoise and what depends on it alone.
# Exit code 1: the variant does not do what the tutorial says.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
fail() {
    echo "try.sh: $1" >&2
    exit "${2:-1}"
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
copy=$work/pt built=${CARGO_TARGET_DIR:-target}/debug

# Times stay as they are: by them cargo sees that a crate has not changed.
mkdir "$copy"
git ls-files -z --cached --others --exclude-standard | while IFS= read -rd '' file; do
    [[ ! -e $file ]] || printf '%s\0' "$file"
done | xargs -0 cp --archive --parents --target-directory="$copy"
# Those of folders too: build scripts watch folders of kernels.
find "$copy" -type d -printf '%P\0' | while IFS= read -rd '' folder; do touch --no-create --reference="./$folder" "$copy/$folder"; done
[[ ! -e ../shared ]] || ln -s "$(realpath ../shared)" "$work/shared"
if [[ -d $built/deps ]]; then
    mkdir -p "$work/target/debug/deps"
    cp --archive "$built/.fingerprint" "$built/build" "$work/target/debug/"
    # Libraries without the programs of tests, which are the most of it.
    find "$built/deps" -maxdepth 1 -name '*.*' -exec cp --archive --target-directory="$work/target/debug/deps" {} +
fi
export CARGO_TARGET_DIR=$work/target

cd "$copy"
examples/box_denoiser/add.sh
# With the features of the tests: with others, cargo would build all dependencies again. It takes those of dev-dependencies only where
# it also builds a test, a benchmark or an example; this example is small and does not depend on pt-denoise.
cargo build --locked --workspace --bin pt --example make_grid || fail "the copy does not build"
pt=$work/target/debug/pt
"$pt" knobs denoise.variant | grep -q box || fail "pt knobs does not list it"
"$pt" passes --scene cornell --set denoise.variant=box | grep 'denoise box' || fail "the frame does not have its pass"

# The study as it is but for its size and its scene, whose many lamps make noise that a mean removes. No value of the axis is named:
# `box` comes by itself.
small=studies/small.toml
sed -E 's/^scenes = .*/scenes = ["lamps"]/; s/^sizes = .*/sizes = ["96x54"]/; s/^seeds = .*/seeds = 2/; s/^frames = .*/frames = 4/
    s/^measure = .*/measure = 2/; s/^spp = .*/spp = 64/' studies/denoiser.toml >"$small"
"$pt" study "$small" -o "$work/out" --filter=denoise.variant={off,svgf,box} >"$work/summary" || fail "the study fails"
cat "$work/summary"
# The first table is of relMSE: variant, cells, mean.
mean() { awk -v variant="$1" '$1 == variant && $2 == 2 { print $3; exit }' "$work/summary"; }
off=$(mean off) box=$(mean box)
[[ -n $box ]] || fail "the study has no row of it"
# With five seeds the mean has 0.44 times the error of the light, and the intervals are apart.
awk -v off="$off" -v box="$box" 'BEGIN { exit !(box < off) }' || fail "the mean ($box) is not less noisy than the light ($off)"
[[ -s $work/out/report.html ]] && grep -q box "$work/out/report.html" || fail "the report does not show it"
