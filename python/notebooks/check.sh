#!/usr/bin/env bash
# Runs the notebooks: `bash python/notebooks/check.sh [PYTHON]`, a Python with tirtouch, matplotlib, pandas, nbconvert
# and ipykernel (default: python3). With --keep as first argument the outputs are written into the notebooks.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

fail() {
    echo "python/notebooks/check.sh: $*" >&2
    exit 3
}

keep=""
if [ "${1:-}" = --keep ]; then
    keep=1
    shift
fi
python="${1:-python3}"
"$python" -c 'import tirtouch, matplotlib, pandas, nbconvert, ipykernel' ||
    fail "$python lacks a package: it needs tirtouch, matplotlib, pandas, nbconvert and ipykernel"

# A kernel of the same Python, whatever kernels the machine knows.
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
"$python" -m ipykernel install --prefix "$work" --name python3 >/dev/null 2>&1
export JUPYTER_PATH="$work/share/jupyter"
for notebook in *.ipynb; do
    "$python" -m nbconvert --to notebook --execute --log-level ERROR --output-dir "$work" "$notebook"
    [ -z "$keep" ] || cp "$work/$notebook" "$notebook"
    echo "python/notebooks/check.sh: $notebook runs"
done
