#!/usr/bin/env bash
# Adds the denoiser `box`, the example of the book, to a checkout: two files and the six lines that make them a variant.
#
# usage: examples/box_denoiser/add.sh [CHECKOUT]
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}/pt-denoise"

[[ ! -e src/variants/box_filter.rs ]] || { echo "add.sh: $PWD has the denoiser box already" >&2 && exit 2; }

# behind FILE LINE TEXT: puts TEXT behind the only line that ends with LINE.
behind() {
    [[ $(grep -cE "(^|  |= )$(sed 's/[][\.*^$?+(){}|]/\\&/g' <<<"$2")\$" "$1") = 1 ]] || {
        echo "add.sh: pt-denoise/$1 has not one line '$2'; the tutorial of the book says what to add" >&2
        exit 2
    }
    awk -v line="$2" -v text="$3" '{ print } length($0) >= length(line) && substr($0, length($0) - length(line) + 1) == line { print text }' "$1" >"$1.new"
    mv "$1.new" "$1"
}

cp "$here/box_filter.comp" shaders/
cp "$here/box_filter.rs" src/variants/
behind src/records.rs 'Recurrent = "recurrent",' $'        /// Mean over 5 x 5 pixels, the example of the book.\n        Box = "box",'
behind src/variants/mod.rs 'mod atrous;' 'mod box_filter;'
behind src/variants/mod.rs 'match params.variant {' '            Denoiser::Box => Some(Box::new(box_filter::BoxFilter::new(device)?)),'
behind src/variants/mod.rs 'match self.variant {' '            Denoiser::Box => vec![box_filter::BoxFilter::IO],'
behind src/variants/low_frequency.rs 'match variant {' '            Denoiser::Box => [false, false],'
