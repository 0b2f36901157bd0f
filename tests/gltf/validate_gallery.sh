#!/usr/bin/env bash
# validate_gallery.sh PROGRAM FOLDER: writes all gallery models and every kind of organ as .glb into FOLDER and sends them
# through the Khronos validator. FOLDER/report.txt ends with `N passed, N failed`; what failed is shown.
set -euo pipefail

program="$1" folder="$2"
files=()

# scene NAME COMMAND...: what the program writes for COMMAND; a file that is not written is a failure of the validator
scene() {
  local file="$folder/$1.glb"
  shift
  files+=("$file")
  "$program" "$@" --quiet -o "$file" || rm -f "$file"
}

mkdir -p "$folder"
for model in clients/gallery/*/ tests/gltf/*/; do
  # a folder of one model, or with a model of its name; the models of the chapters follow
  [[ "$(find "$model" -maxdepth 1 -name '*.l' | wc -l)" == 1 || -f "$model$(basename "$model").l" ]] || continue
  scene "$(basename "$model")" run "$model"
done
# the models of the chapters
while read -r name rest; do
  [[ "$name" == chapter-*/*.* && "$name" != *@* ]] || continue
  # shellcheck disable=SC2086 # several arguments
  scene "${name//[\/:]/-}" run "clients/gallery/$name" $rest
done <clients/gallery/pictures.txt
# a forest; copies of plants, as nodes of one mesh and as instances
scene forest forest --number 60 --seed 7
scene rows run clients/gallery/textured-tree --variants 4 --in-rows 0
scene rows--instancing run clients/gallery/textured-tree --variants 4 --in-rows 0 --instancing

node tests/gltf/validate.js "${files[@]}" >"$folder/report.txt" || { cat "$folder/report.txt"; exit 1; }
