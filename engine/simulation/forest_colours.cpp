#include <algorithm>

#include "engine/core/check.h"
#include "engine/simulation/forest.h"
#include "engine/turtle/export/palette.h"

namespace espalier::simulation {
namespace {

files::Material materialOf(const files::PaletteColour& colour) {
  files::Material material;
  material.diffuse = {colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0};
  return material;
}

}  // namespace

files::Palette joinedPalettes(const Programs& programs, std::span<const files::Palette> palettes) {
  ESPALIER_CHECK(programs.size() == palettes.size());
  std::vector<files::Palette> own;
  for (std::size_t model = 0; model < programs.size(); ++model) {
    own.push_back(turtle::paletteOf(programs[model]->view, palettes[model]));
  }
  files::Palette whole;
  if (std::ranges::all_of(own, &files::Palette::empty)) {
    return whole;
  }
  whole.usesMaterials = std::ranges::any_of(own, &files::Palette::usesMaterials);
  for (std::size_t model = 0; model < own.size(); ++model) {
    const files::Palette palette = own[model].empty() ? turtle::defaultPalette() : own[model];
    const int shift = kBlocksPerModel * static_cast<int>(model) + whole.base - palette.base;
    for (const auto& [block, map] : palette.maps) {
      whole.maps[block + shift] = map;
      if (whole.usesMaterials && !palette.usesMaterials) {
        std::ranges::transform(map, whole.materials[block + shift].begin(), materialOf);
      }
    }
    if (palette.usesMaterials) {
      for (const auto& [block, materials] : palette.materials) {
        whole.materials[block + shift] = materials;
      }
    }
  }
  return whole;
}

}  // namespace espalier::simulation
