#!/usr/bin/env bash
# Packs what other systems install by themselves: build_archives.sh FOLDER gets
#   espalier-VERSION.tgz       for npm (clients/typescript)
#   espalier_VERSION.tar.gz    for R (clients/r), where R is installed
#   espalier-blender.zip       for Blender (clients/blender)
# No network is used. `./dev package` calls this.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)"
mkdir -p "$1"
folder="$(cd "$1" && pwd -P)"

[[ -f "$root/clients/typescript/dist/node.js" ]] || {
  echo "clients/typescript/dist is not there: run ./dev build first (it needs Node.js and npm)." >&2
  exit 1
}
# dist is built already; without scripts npm asks for nothing
npm pack --silent --offline --ignore-scripts --pack-destination "$folder" "$root/clients/typescript" >/dev/null
python3 "$root/clients/blender/make_addon.py" "$folder/espalier-blender.zip"
if command -v R >/dev/null; then
  (cd "$folder" && R CMD build "$root/clients/r" >build-r.log 2>&1) || {
    cat "$folder/build-r.log" >&2
    exit 1
  }
  rm "$folder/build-r.log"
else
  echo "R is not installed (Debian: r-base-core): the package for R is not built" >&2
fi
ls "$folder"/espalier-*.tgz "$folder"/espalier-blender.zip "$folder"/espalier_*.tar.gz 2>/dev/null || true
