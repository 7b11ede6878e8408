#!/usr/bin/env bash
# Builds the wheel, installs it by pip alone into an empty virtual environment, and runs the tests there.
set -euo pipefail
cd "$(dirname "$0")"

# What takes the place of a missing Python is for the system to say: without one there is nothing to test.
if ! command -v python3 >/dev/null; then
    echo "skipped: there is no python3" >&2
    exit 0
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --disable-pip-version-check --quiet '.[test]'
# From elsewhere, so that the package that is tested is the one that was installed.
tests=$PWD/tests
cd "$folder"
"$folder/venv/bin/python" -m pytest --quiet -p no:cacheprovider "$@" "$tests"
