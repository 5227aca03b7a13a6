#!/usr/bin/env bash
# Installs a headless Chromium on Debian where there is none.
set -euo pipefail
for name in chromium-headless-shell chromium chromium-browser google-chrome; do
    ! command -v "$name" >/dev/null || exit 0
done
command -v apt-get >/dev/null && [ "$(id -u)" -eq 0 ] || {
    echo "tests/browser: no Chromium is on PATH: install chromium or chromium-headless-shell" >&2
    exit 3
}
echo "tests/browser: installing chromium-headless-shell"
apt-get update -qq </dev/null
DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends chromium-headless-shell </dev/null
