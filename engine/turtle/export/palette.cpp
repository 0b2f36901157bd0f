#include "engine/turtle/export/palette.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace espalier::turtle {

namespace {

constexpr std::int32_t kDefaultIndex = 128;
// beyond all colours of a forest, whose models have blocks of their own; a multiple of 256
constexpr std::int32_t kFirstOrderMaterial = 1 << 24;

struct Anchor {
  std::int32_t index;
  Colour colour;
};

// from bark over leaf to flower
constexpr std::array kRamp = {
    Anchor{0, {58, 42, 30}},     Anchor{48, {108, 78, 52}},   Anchor{96, {128, 116, 62}}, Anchor{128, {84, 132, 62}},
    Anchor{168, {140, 178, 84}}, Anchor{200, {226, 190, 84}}, Anchor{228, {204, 88, 96}}, Anchor{255, {246, 232, 226}},
};

constexpr Colour kBackground{250, 248, 242};
constexpr Colour kTrunk{104, 76, 54};
constexpr Colour kTwig{106, 148, 74};  // of a plant without organs
constexpr Colour kWood{138, 108, 78};  // twigs of a plant with organs

unsigned char channel(double value) {
  return static_cast<unsigned char>(std::lround(std::clamp(value, 0.0, 255.0)));
}

std::int32_t wrapped(std::int32_t index) {
  return ((index % 256) + 256) % 256;
}

}  // namespace

Colour mixed(const Colour& a, const Colour& b, double t) {
  const auto mix = [t](unsigned char x, unsigned char y) { return channel(x + t * (y - x)); };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour defaultColour(std::int32_t index) {
  const std::int32_t place = wrapped(index);
  for (std::size_t i = 1; i < kRamp.size(); ++i) {
    if (place <= kRamp[i].index) {
      const double t = static_cast<double>(place - kRamp[i - 1].index) / (kRamp[i].index - kRamp[i - 1].index);
      return mixed(kRamp[i - 1].colour, kRamp[i].colour, t);
    }
  }
  return kRamp.back().colour;
}

files::Palette defaultPalette() {
  files::Palette palette;
  auto& map = palette.maps[palette.base];
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Colour colour = i == 0 ? kBackground : defaultColour(static_cast<std::int32_t>(i));
    map[i] = {colour.red, colour.green, colour.blue};
  }
  return palette;
}

files::Palette paletteOf(const files::ViewSettings& view, const files::Palette& folder) {
  if (!folder.empty() || view.colourEntries.empty()) {
    return folder;
  }
  files::Palette palette = defaultPalette();
  for (const auto& [index, colour] : view.colourEntries) {
    palette.maps[palette.base][static_cast<std::size_t>(index)] = colour;
  }
  return palette;
}

Palette::Palette(const Scene& scene, const files::ViewSettings& view, const files::Palette* folder)
    : colours_(folder != nullptr && !folder->empty() ? folder : nullptr),
      hasOrgans_(!scene.polygons.empty() || !scene.surfaces.empty() || !scene.patches.empty()) {
  if (colours_ == nullptr && !view.colourEntries.empty()) {
    entries_ = std::make_shared<const files::Palette>(paletteOf(view, {}));
    colours_ = entries_.get();
  }
  // a view file that sets other entries, as the background, leaves the plant as it is
  hasOwnLines_ = colours_ != nullptr && (entries_ == nullptr || view.colourEntries.contains(kDefaultIndex));
  for (const Segment& segment : scene.segments) {
    maximumOrder_ = std::max(maximumOrder_, segment.branchOrder);
    if (segment.colour != kDefaultIndex) {
      isColoured_.resize(std::max<std::size_t>(isColoured_.size(), segment.plant + std::size_t{1}));
      isColoured_[segment.plant] = true;
    }
  }
}

std::int32_t Palette::numberOf(std::int32_t index) const {
  if (colours_ != nullptr) {
    const int block = colours_->base + (index - wrapped(index)) / files::Palette::kBlockSize;
    if (colours_->usesMaterials ? colours_->materials.contains(block) : colours_->maps.contains(block)) {
      return index;
    }
  }
  return wrapped(index);
}

std::int32_t Palette::materialOf(const Segment& segment) const {
  return isPlain(segment.plant)
             ? kFirstOrderMaterial + static_cast<std::int32_t>(std::min<std::uint32_t>(segment.branchOrder, 100'000))
             : numberOf(segment.colour);
}

Colour Palette::ofMaterial(std::int32_t material) const {
  if (material < kFirstOrderMaterial) {
    return ofIndex(material);
  }
  if (hasOrgans_) {
    const double order = material - kFirstOrderMaterial;
    return mixed(kTrunk, kWood, order / (order + 1.0));
  }
  if (maximumOrder_ == 0) {
    return mixed(kTrunk, kTwig, 0.75);
  }
  return mixed(kTrunk, kTwig, std::sqrt(static_cast<double>(material - kFirstOrderMaterial) / maximumOrder_));
}

Colour Palette::ofIndex(std::int32_t index) const {
  if (colours_ == nullptr) {
    return defaultColour(index);
  }
  const files::PaletteColour colour = colours_->colour(numberOf(index));
  return {colour.red, colour.green, colour.blue};
}

double Palette::opacityOfIndex(std::int32_t index) const {
  const std::optional<files::Material> material = folderMaterial(index);
  return material ? material->opacity : 1.0;
}

Colour Palette::background() const {
  if (colours_ == nullptr) {
    return kBackground;
  }
  const files::PaletteColour colour = colours_->background();
  return {colour.red, colour.green, colour.blue};
}

std::optional<files::Material> Palette::folderMaterial(std::int32_t index) const {
  if (colours_ == nullptr || !colours_->usesMaterials) {
    return std::nullopt;
  }
  return colours_->material(numberOf(index));
}

Colour Palette::ofSegment(const Segment& segment) const {
  return ofMaterial(materialOf(segment));
}

}  // namespace espalier::turtle
