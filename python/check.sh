#!/usr/bin/env bash
# Builds the wheel and tests it: `bash python/check.sh [PYTHON...]`, each a command such as python3.12. Without
# arguments the newest and the oldest python3.X from 3.10 on that are on PATH or that pyenv has; where there is none, a
# Debian gets its own. Each has the wheel in a clean environment of its own. The first runs every test and builds the
# documentation; the others, to which the wheel is the same file, run the tests of scenes and arrays.
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
# The newest and the oldest that work, one of each version.
found() {
    local minor python newest="" oldest=""
    for minor in 15 14 13 12 11 10; do
        for python in "python3.$minor" "${PYENV_ROOT:-${HOME:-}/.pyenv}/versions/3.$minor."*"/bin/python3.$minor"; do
            works "$python" || continue
            newest="${newest:-$python}" oldest="$python"
            break
        done
    done
    [ -z "$newest" ] || printf '%s\n' "$newest"
    [ "$oldest" = "$newest" ] || printf '%s\n' "$oldest"
}
pythons=("$@")
if [ $# -eq 0 ]; then
    mapfile -t pythons < <(found)
    if [ ${#pythons[@]} -eq 0 ] && [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
        say "no Python found: installing python3 and python3-venv"
        apt-get update -qq </dev/null
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends python3 python3-venv </dev/null
        mapfile -t pythons < <(found)
    fi
fi
[ ${#pythons[@]} -gt 0 ] || fail "no python3.10 or later, with venv, is on PATH: install one, or name it"
for python in "${pythons[@]}"; do
    works "$python" || fail "$python: is no Python from 3.10 on, or has no venv"
done
say "with ${pythons[*]}"

tools="$target/python/tools"
if [ ! -x "$tools/bin/uv" ]; then
    "${pythons[0]}" -m venv --clear "$tools"
    "$tools/bin/pip" install --quiet --disable-pip-version-check 'maturin>=1.9,<2' uv
fi
export UV_CACHE_DIR="$target/python/cache"

# Clean environments, one for each Python, with what the tests need beside the wheel: made while that is built.
environment_of() { "$1" -c 'import sys; print("%s/python/%d.%d" % (sys.argv[1], *sys.version_info[:2]))' "$target"; }
into() {
    local venv="$1"
    shift
    "$tools/bin/uv" pip install --quiet --python "$venv/bin/python" "$@"
}
prepare() {
    local python venv
    for python in "${pythons[@]}"; do
        venv="$(environment_of "$python")"
        "$tools/bin/uv" venv --quiet --clear --python "$python" "$venv"
        into "$venv" numpy pytest
        [ "$python" = "${pythons[0]}" ] || continue
        into "$venv" pytest-xdist mypy datasets pillow xarray 'pdoc>=16,<17'
        # The renderer to compare with is not built for every Python; what needs it is skipped where it is missing.
        into "$venv" --only-binary :all: mitsuba || say "no Mitsuba for $venv: its scenes are not looked at"
    done
}
prepare &
prepared=$!

# Both packages are named, so that features are those of the wheel's library: then it is compiled once.
cargo build --profile "$profile" --locked -p tirtouch -p tirtouch-python --bin tirtouch
rm -rf "$target/wheels"
# For this machine: what is published must be built against an old glibc and checked for that (manylinux).
"$tools/bin/maturin" build --profile "$profile" --locked --manifest-path python/Cargo.toml --auditwheel skip \
    --out "$target/wheels"
wheels=("$target"/wheels/*.whl)
wait "$prepared"

export TIRTOUCH_REQUIRE_GPU="${TIRTOUCH_REQUIRE_GPU:-1}"
TIRTOUCH_BINARY="$(realpath "$target/$folder/tirtouch")"
export TIRTOUCH_BINARY
tests() { "$venv/bin/python" -m pytest -q -p no:cacheprovider "$@"; }
cores="$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"
for python in "${pythons[@]}"; do
    venv="$(environment_of "$python")"
    say "Python ${venv##*/}"
    if [ "$python" = "${pythons[0]}" ]; then
        into "$venv" "${wheels[0]}[tables,progress]"
        # A file's tests share what they press and learn.
        tests -n "$cores" --dist loadfile python/tests
        # Beside the other's tests: each is one thread's work.
        "$venv/bin/python" -m mypy.stubtest tirtouch --mypy-config-file python/pyproject.toml &
        typed=$!
        bash python/docs.sh "$venv/bin/python"
    else
        into "$venv" "${wheels[0]}"
        tests python/tests/test_scene.py python/tests/test_render.py
    fi
done
wait "$typed"
say "all tests passed"
