#!/usr/bin/env bash
# tirtouch against Mitsuba 3, see README.md here. Arguments go to compare.py.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
python="${PEER_PYTHON:-$here/peer-venv/bin/python}"

fail() {
    echo "benches/peers/run.sh: $*" >&2
    exit 3
}

[ -x "$python" ] || fail "no Python at $python: make the environment as README.md here says, or set PEER_PYTHON"
"$python" -c 'import mitsuba, numpy' || fail "$python lacks mitsuba or numpy: see README.md here"

# Mitsuba's LLVM variants crash on LLVM 14 to 16; a newer one must be named where an older one is installed too.
if [ -z "${DRJIT_LIBLLVM_PATH:-}" ] && [ "$(uname -s)" = Linux ]; then
    libraries="$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p | sed -n 's/.*=> \(.*libLLVM\.so\.[0-9.]*\)$/\1/p' | sort -V)"
    [ -n "$libraries" ] || fail "no LLVM of version 19 or later found: install libllvm19, or set DRJIT_LIBLLVM_PATH"
    DRJIT_LIBLLVM_PATH="$(tail -n 1 <<<"$libraries")"
    export DRJIT_LIBLLVM_PATH
fi
export NODEVICE_SELECT=1

cargo build --release --locked --manifest-path "$here/../../Cargo.toml" --bin tirtouch --example pressed_peer
exec "$python" "$here/compare.py" "$@"
