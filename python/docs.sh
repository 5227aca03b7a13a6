#!/usr/bin/env bash
# Builds the documentation of the package from its docstrings, into target/python/docs: `bash python/docs.sh [PYTHON]`,
# a Python with tirtouch[tables] and pdoc (default: the newest that python/check.sh made). The pages need no network.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
    echo "python/docs.sh: $*" >&2
    exit 3
}

target="${CARGO_TARGET_DIR:-target}"
python="${1:-$(printf '%s\n' "$target"/python/3.*/bin/python | sort -V | tail -n 1)}"
"$python" -c 'import tirtouch, pandas, xarray, pdoc' ||
    fail "$python lacks a package: it needs tirtouch, pandas, xarray and pdoc"
pages="$target/python/docs"
rm -rf "$pages"
# pdoc warns of a type that it cannot resolve.
"$python" -W error::UserWarning python/docs.py "$pages" || fail "what a reader would miss is above"
! grep -rlE '(src|href)="?(https?:)?//[^"]*\.(js|css)' "$pages" || fail "those pages fetch from the network"
echo "python/docs.sh: $pages/index.html"
