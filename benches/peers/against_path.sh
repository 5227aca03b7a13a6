#!/usr/bin/env bash
# The map of light against `path`, with other seeds, by the block test of `compare`: one JSON object a scene.
# Writes measured/against_path.jsonl beside this file. Takes about ten minutes.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$here/../.."
out="$(mktemp -d)"
trap 'rm -rf "$out"' EXIT

cargo build --release --locked --manifest-path "$root/Cargo.toml" --bin tirtouch
tirtouch="$(cd "${CARGO_TARGET_DIR:-$root/target}" && pwd)/release/tirtouch"

# Scene, paths a pixel, paths a pixel of the map.
while read -r scene paths map; do
    "$tirtouch" render "$scene" --integrator path --spp "$paths" --seed 1001 --quiet --force -o "$out/path" >&2
    "$tirtouch" render "$scene" --integrator map --spp "$map" --seed 1 --quiet --force -o "$out/map" >&2
    # Exit code 1 says that blocks differ, which is a result.
    found="$(cd "$out" && "$tirtouch" compare map/radiance.exr path/radiance.exr --json)" || [ $? -eq 1 ]
    echo "{\"scene\": \"$(basename "$scene" .toml)\", \"path_spp\": $paths, \"map_spp\": $map, \"compare\": $(tr -d '\n' <<<"$found")}"
done >"$out/found" <<SCENES
$root/scenes/contact-disc.toml 4096 64
$here/pressed.toml 2048 64
$root/scenes/phantom-size-8mm.toml 4096 64
SCENES
mv "$out/found" "$here/measured/against_path.jsonl"
