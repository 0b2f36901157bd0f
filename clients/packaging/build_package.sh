#!/usr/bin/env bash
# Builds the Debian packages from the files of this repository: build_package.sh FOLDER [JOBS]
# FOLDER gets espalier_*.deb, espalier-dev_*.deb and python3-espalier_*.deb. `./dev package` calls this.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)"
mkdir -p "$1"
folder="$(cd "$1" && pwd -P)"
jobs="${2:-$(nproc)}"
version="$(sed -nE 's/^project\(Espalier VERSION ([0-9.]+).*/\1/p' "$root/CMakeLists.txt")"
tree="$(mktemp -d)/espalier-$version"
trap 'rm -rf "$(dirname "$tree")"' EXIT

# Node.js makes these; the package is built without it
scripts="espalier.js studio.js studio.js.gz studio.css"
for script in $scripts; do
  [[ -f "$root/clients/web/$script" ]] || {
    echo "The script of the pages clients/web/$script is not there: run ./dev build first (it needs Node.js and npm)." >&2
    exit 1
  }
done

# the files that git knows, as they are now
rm -f "$folder"/*.deb
mkdir -p "$tree"
(cd "$root" && git ls-files -z | xargs -0 cp --parents -t "$tree" --)
(cd "$root/clients/web" && cp -t "$tree/clients/web" -- $scripts)
cp -r "$root/clients/packaging/debian" "$tree/debian"

export ESPALIER_NINJA_FLAGS="-j$jobs"
cd "$tree"
dpkg-buildpackage --build=binary --unsigned-changes --no-pre-clean >"$folder/build.log" 2>&1 || {
  tail -n 40 "$folder/build.log" >&2
  echo "The package could not be built; all of its output is in $folder/build.log" >&2
  exit 1
}
cp "$(dirname "$tree")"/*.deb "$folder"
ls "$folder"/*.deb
