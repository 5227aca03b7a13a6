#!/usr/bin/env bash
# Pages in a headless Chromium: `bash tests/browser/run.sh [FOLDER]`; pictures of them go to FOLDER. The browser
# is installed on Debian where there is none. `TIRTOUCH_PROFILE` is cargo's profile.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

export PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin" NODEVICE_SELECT="${NODEVICE_SELECT:-1}"
bash tests/browser/install.sh
profile="${TIRTOUCH_PROFILE:-ci}"
folder="$profile"
[ "$profile" != dev ] || folder=debug
# Both packages are named, so that features are those of the Python package: then the library is compiled once.
cargo build --profile "$profile" --locked -p tirtouch -p tirtouch-python --bin tirtouch
[ $# -eq 0 ] || mkdir -p "$1"
program="${CARGO_TARGET_DIR:-target}/$folder/tirtouch"
python3 tests/browser/view.py "$program" "$@"
python3 tests/browser/sweep.py "$program" "$@"

