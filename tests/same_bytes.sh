#!/usr/bin/env bash
# Whether two builds make the same bytes: tables of the shipped recipes, and pictures of eight scenes by every method.
#   tests/same_bytes.sh OLD/target/release NEW/target/release
# A change of the house must pass; a change of what is computed need not. Exit code 1 and a line for each file that differs.
set -euo pipefail
old=$(realpath "$1") new=$(realpath "$2")
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
same() { # NAME FILE FILE
    if cmp -s "$2" "$3"; then echo "same     $1"; else echo "differs  $1"; failed=1; fi
}
for build in old new; do
    mkdir -p "$work/$build"
    cp tables/*.toml "$work/$build"
done
for recipe in tables/*.toml; do
    name=$(basename "$recipe" .toml)
    # The same names from the same folder: the command line stands in the table.
    (cd "$work/old" && "$old/fitter" fit "$name.toml" --seed 1 >/dev/null 2>&1) || { echo "refused  $name by $old"; continue; }
    (cd "$work/new" && "$new/fitter" fit "$name.toml" --seed 1 >/dev/null)
    same "$name" "$work/old/$name.tbl" "$work/new/$name.tbl"
done
root=$PWD
draw() { # BUILD NAME SCENE METHOD
    local tables=()
    [[ $4 == eas || $4 == auto ]] && tables=(--tables .)
    (cd "$work/$2" && "$1/render" image "$root/tests/scenes/$3" -o "../$2.exr" --method "$4" "${tables[@]}" \
        --width 48 --height 36 --spp 4 --seed 3 2>/dev/null)
}
while read -r scene; do
    for method in path irradiance eas sh auto; do
        draw "$old" old "$scene" "$method" || { echo "refused  $scene $method by $old"; continue; }
        draw "$new" new "$scene" "$method"
        same "$scene $method" "$work/old.exr" "$work/new.exr"
    done
done <<'SCENES'
cornell-glossy.xml
cornell-diffuse.xml
anisotropic-sphere.xml
floor-n20.xml
materials.xml
preview.xml
failure/normal-map.xml
failure/window-horizon.xml
SCENES
exit $failed
