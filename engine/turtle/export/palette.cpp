#include "engine/turtle/export/palette.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace espalier::turtle {

namespace {

constexpr std::int32_t kDefaultIndex = 128;
constexpr std::int32_t kFirstOrderMaterial = 256;

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
constexpr Colour kTwig{106, 148, 74};

unsigned char channel(double value) {
  return static_cast<unsigned char>(std::lround(std::clamp(value, 0.0, 255.0)));
}

int indexOf(std::int32_t index) {
  return ((index % 256) + 256) % 256;
}

}  // namespace

Colour mixed(const Colour& a, const Colour& b, double t) {
  const auto mix = [t](unsigned char x, unsigned char y) { return channel(x + t * (y - x)); };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour defaultColour(std::int32_t index) {
  const std::int32_t wrapped = indexOf(index);
  for (std::size_t i = 1; i < kRamp.size(); ++i) {
    if (wrapped <= kRamp[i].index) {
      const double t = static_cast<double>(wrapped - kRamp[i - 1].index) / (kRamp[i].index - kRamp[i - 1].index);
      return mixed(kRamp[i - 1].colour, kRamp[i].colour, t);
    }
  }
  return kRamp.back().colour;
}

Palette::Palette(const Scene& scene, const files::Palette* colours)
    : colours_(colours != nullptr && !colours->empty() ? colours : nullptr) {
  isPlain_ = colours_ == nullptr && std::all_of(scene.segments.begin(), scene.segments.end(),
                                                [](const Segment& segment) { return segment.colour == kDefaultIndex; });
  for (const Segment& segment : scene.segments) {
    maximumOrder_ = std::max(maximumOrder_, segment.branchOrder);
  }
}

std::int32_t Palette::materialOf(const Segment& segment) const {
  return isPlain_
             ? kFirstOrderMaterial + static_cast<std::int32_t>(std::min<std::uint32_t>(segment.branchOrder, 100'000))
             : indexOf(segment.colour);
}

Colour Palette::ofMaterial(std::int32_t material) const {
  if (material < kFirstOrderMaterial) {
    return ofIndex(material);
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
  const files::PaletteColour colour = colours_->colour(indexOf(index));
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
  return colours_->material(indexOf(index));
}

Colour Palette::ofSegment(const Segment& segment) const {
  return ofMaterial(materialOf(segment));
}

}  // namespace espalier::turtle
