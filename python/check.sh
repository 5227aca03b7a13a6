#!/usr/bin/env bash
# Builds the wheel and tests it: `bash python/check.sh [PYTHON...]`, each a command such as python3.12. Without
# arguments every python3.X from 3.10 on that is on PATH. Each gets the wheel in a clean environment of its own.
#
# Cargo's target folder is that of the whole repository, so what its tests have compiled is not compiled again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { echo "python/check.sh: $*"; }
fail() {
    echo "python/check.sh: $*" >&2
    exit 3
}

export PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin"
command -v cargo >/dev/null || fail "cargo not found: install the Rust toolchain (rustup, stable) and run this again"
profile="${TIRTOUCH_PROFILE:-ci}"
target="${CARGO_TARGET_DIR:-target}"
# Folders of cargo's own profiles are named otherwise.
folder="$profile"
[ "$profile" != dev ] || folder=debug

# A command that is there may still be a stand-in for a version that is not.
works() { "$1" -c 'import sys, venv; sys.exit(sys.version_info < (3, 10))' >/dev/null 2>&1; }
pythons=("$@")
if [ $# -eq 0 ]; then
    for minor in 10 11 12 13 14 15; do
        if works "python3.$minor"; then pythons+=("python3.$minor"); fi
    done
fi
[ ${#pythons[@]} -gt 0 ] || fail "no python3.10 or later, with venv, is on PATH: install one, or name it"
for python in "${pythons[@]}"; do
    works "$python" || fail "$python: is no Python from 3.10 on, or has no venv"
done
say "with ${pythons[*]}"

tools="$target/python/tools"
if [ ! -x "$tools/bin/maturin" ]; then
    "${pythons[0]}" -m venv --clear "$tools"
    "$tools/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2'
fi

# Both packages are named, so that features are those of the wheel's library: then it is compiled once.
cargo build --profile "$profile" --locked -p tirtouch -p tirtouch-python --bin tirtouch
rm -rf "$target/wheels"
# For this machine: what is published must be built against an old glibc and checked for that (manylinux).
"$tools/bin/maturin" build --profile "$profile" --locked --manifest-path python/Cargo.toml --auditwheel skip \
    --out "$target/wheels"
wheels=("$target"/wheels/*.whl)

export TIRTOUCH_REQUIRE_GPU="${TIRTOUCH_REQUIRE_GPU:-1}"
TIRTOUCH_BINARY="$(realpath "$target/$folder/tirtouch")"
export TIRTOUCH_BINARY
for python in "${pythons[@]}"; do
    version="$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
    venv="$target/python/$version"
    "$python" -m venv --clear "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check "${wheels[0]}[tables,progress]" numpy pytest mypy
    say "Python $version"
    "$venv/bin/python" -m pytest -q -p no:cacheprovider python/tests
    "$venv/bin/python" -m mypy.stubtest tirtouch --mypy-config-file python/pyproject.toml
done
say "all tests passed"
