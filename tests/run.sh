#!/usr/bin/env bash
# Runs every test: `bash tests/run.sh`. Arguments go to `cargo test`.
#
# The tests need a Vulkan adapter (Metal on macOS, DirectX 12 on Windows). Where a Linux machine has none, this script
# installs Mesa's software adapter, lavapipe; with TIRTOUCH_REQUIRE_GPU=1 a test that finds no adapter fails instead of
# passing without having tested anything.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { echo "tests/run.sh: $*"; }
fail() {
    echo "tests/run.sh: $*" >&2
    exit 3
}

has_loader() {
    PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null | grep -F 'libvulkan.so.1' >/dev/null
}

# The drivers' manifests, one per line: those that the environment names, or those of the standard folders.
manifests() {
    local named="${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}"
    if [ -n "$named" ]; then
        tr ':' '\n' <<<"$named"
        return
    fi
    local data="${XDG_DATA_HOME:-${HOME:-/nonexistent}/.local/share}"
    find /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d "$data/vulkan/icd.d" \
        -name '*.json' 2>/dev/null || true
}

# A manifest is not a device: GPU drivers are often installed where there is no GPU. The software adapter needs none.
has_adapter() {
    local manifest
    while read -r manifest; do
        [ -e "$manifest" ] || continue
        case "$(basename "$manifest")" in
        lvp_icd*) return 0 ;;
        *) if compgen -G '/dev/dri/renderD*' >/dev/null || [ -e /dev/nvidia0 ] || [ -e /dev/dxg ]; then return 0; fi ;;
        esac
    done < <(manifests)
    return 1
}

has_adapter_and_loader() { has_loader && has_adapter; }

packages=(mesa-vulkan-drivers libvulkan1)
as_root=()
# Whether and how it can be installed; the message says what is.
may_install_lavapipe() {
    [ -z "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ] ||
        fail "VK_DRIVER_FILES or VK_ICD_FILENAMES is set and gives no usable driver: correct it or unset it"
    command -v apt-get >/dev/null ||
        fail "no Vulkan adapter found, no apt-get here: install Mesa's lavapipe and the Vulkan loader, run this again"
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null ||
            fail "no Vulkan adapter found; as root, run: apt-get update && apt-get install ${packages[*]}"
        as_root=(sudo)
        # Without a terminal nobody can type a password: fail instead of waiting.
        [ -t 0 ] || as_root=(sudo -n)
    fi
    say "no Vulkan adapter found: installing ${packages[*]}${as_root[0]:+ (by sudo)}"
}
install_lavapipe() {
    # ${a[@]+...}: bash before 4.4 takes an empty array for an unset variable.
    ${as_root[@]+"${as_root[@]}"} apt-get update -qq </dev/null &&
        ${as_root[@]+"${as_root[@]}"} env DEBIAN_FRONTEND=noninteractive \
            apt-get install -y -qq --no-install-recommends "${packages[@]}" </dev/null ||
        fail "could not install ${packages[*]}: install Mesa's lavapipe and the Vulkan loader, then run this again"
}

export PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin"
command -v cargo >/dev/null || fail "cargo not found: install the Rust toolchain (rustup, stable) and run this again"

# What is missing: the adapter, and the browser where its tests must not be left out.
install_missing() {
    has_adapter_and_loader || install_lavapipe
    [ -z "${TIRTOUCH_REQUIRE_BROWSER:-}" ] || bash tests/browser/install.sh
}
installing=""
case "$(uname -s)" in
Linux)
    if has_adapter_and_loader; then say "Vulkan adapter found"; else may_install_lavapipe; fi
    # While the tests are compiled, where nobody has to type a password.
    if [ "$(id -u)" -eq 0 ]; then
        install_missing &
        installing=$!
    else
        install_missing
    fi
    ;;
Darwin) say "macOS: the tests use Metal" ;;
*) say "$(uname -s): the tests use what adapter the system has" ;;
esac

export TIRTOUCH_REQUIRE_GPU=1
# Mesa's device selection would write a warning on standard error, which some tests read.
export NODEVICE_SELECT=1
# Two more tests at once than cores: while one waits for a driver's compiler, which uses one core, others work.
cores="$(getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)"
export RUST_TEST_THREADS="${RUST_TEST_THREADS:-$((cores + 2))}"

run() {
    say "$*"
    "$@"
}
# The package for Python is named too, though nothing of it is run here: the library then has the features of the
# wheel's, and `python/check.sh` finds it compiled.
ours=(-p tirtouch -p tirtouch-python)
# The library with its tests and without, side by side.
run cargo test --profile ci --locked "${ours[@]}" --tests --no-run
[ -z "$installing" ] || wait "$installing"
[ "$(uname -s)" != Linux ] || has_adapter_and_loader ||
    fail "lavapipe is installed, yet no Vulkan loader or driver is found"
# A test runs the examples and finds them built.
examples=()
for file in examples/*.rs; do examples+=(--example "$(basename "$file" .rs)"); done
run cargo build --profile ci --locked "${ours[@]}" "${examples[@]}"
run cargo test --profile ci --locked "${ours[@]}" --tests "$@"
# Documentation examples are a run of their own in cargo.
run cargo test --profile ci --locked "${ours[@]}" --doc "$@"
say "all tests passed"
