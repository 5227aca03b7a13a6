#!/usr/bin/env bash
# tirtouch against CalculiX, see README.md here. Arguments go to compare_press.py.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
python="${PEER_PYTHON:-$here/peer-venv/bin/python}"

fail() {
    echo "benches/peers/mechanics.sh: $*" >&2
    exit 3
}

command -v ccx >/dev/null || fail "no ccx: apt-get install calculix-ccx"
[ -x "$python" ] || fail "no Python at $python: make the environment as README.md here says, or set PEER_PYTHON"
"$python" -c 'import numpy' || fail "$python lacks numpy: see README.md here"

cargo build --release --locked --manifest-path "$here/../../Cargo.toml" --example press_peer
exec "$python" "$here/compare_press.py" "$@"
