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

# the client for npm, compiled in a copy by the compiler that the build of the studio has fetched
modules="$root/clients/web/node_modules"
[[ -f "$modules/typescript/bin/tsc" && -f "$root/clients/typescript/src/protocol.ts" ]] || {
  echo "the TypeScript compiler is not in clients/web/node_modules: install Node.js and npm, then run ./dev build" >&2
  exit 1
}
copy="$(mktemp -d)"
trap 'rm -rf "$copy"' EXIT
cp -r "$root"/clients/typescript/{package.json,README.md,tsconfig.json,src} "$copy"
(cd "$copy" && node "$modules/typescript/bin/tsc" --typeRoots "$modules/@types")
# compiled already; without scripts npm asks for nothing
npm pack --silent --offline --ignore-scripts --pack-destination "$folder" "$copy" >/dev/null
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
