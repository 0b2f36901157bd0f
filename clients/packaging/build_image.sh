#!/usr/bin/env bash
# Makes an image for containers: build_image.sh FOLDER NAME. FOLDER has espalier_*.deb; its image/ gets the root and the store of buildah, unless
# buildah's own is asked for with ESPALIER_IMAGE_STORE=own. No daemon, and no image is downloaded.
set -euo pipefail

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)"
folder="$(cd "$1" && pwd -P)"
name="$2"
work="$folder/image"
package="$(ls "$folder"/espalier_*.deb | head -n 1)"
mkdir -p "$work"

if [[ ! "$work/root.tar" -nt "$package" ]]; then
  # the end of the name says that it is an archive, not a folder
  mmdebstrap --variant=apt --quiet --include=ca-certificates --customize-hook="copy-in '$package' /srv" \
    --customize-hook='chroot "$1" sh -c "apt-get install -y -qq --no-install-recommends /srv/*.deb && rm /srv/*.deb"' \
    bookworm "$work/root.part.tar" >"$work/root.log" 2>&1 || {
    tail -n 12 "$work/root.log" >&2
    exit 1
  }
  mv "$work/root.part.tar" "$work/root.tar"
fi
store=(--storage-driver vfs --root "$work/store" --runroot "$work/run")
[[ "${ESPALIER_IMAGE_STORE:-}" != own ]] || store=(--storage-driver vfs)
# the folder of the build has nothing else
mkdir -p "$work/context"
cp "$here/Containerfile" "$work/context"
ln -f "$work/root.tar" "$work/context/root.tar"
buildah "${store[@]}" bud --isolation chroot -t "$name" "$work/context"
