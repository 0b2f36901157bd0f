#include "clients/espalier/output/drawing_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace espalier::command {
namespace {

constexpr std::array kAnchors = {
    files::PaletteColour{220, 30, 30}, files::PaletteColour{245, 140, 20}, files::PaletteColour{230, 205, 30},
    files::PaletteColour{40, 160, 60}, files::PaletteColour{30, 90, 210},  files::PaletteColour{150, 50, 180},
    files::PaletteColour{220, 30, 30},
};
constexpr files::PaletteColour kPage{250, 248, 242};
constexpr std::size_t kFirst = 1;    // 0 is the page
constexpr std::size_t kCount = 255;  // colours of lines

std::uint8_t between(std::uint8_t a, std::uint8_t b, double t) {
  return static_cast<std::uint8_t>(std::lround(a + t * (b - a)));
}

}  // namespace

files::Palette colourByDrawingOrder(turtle::Scene& scene) {
  const std::size_t count = scene.segments.size();
  for (std::size_t i = 0; i < count; ++i) {
    scene.segments[i].colour = static_cast<std::int32_t>(kFirst + i * kCount / count);
  }
  files::Palette palette;
  auto& map = palette.maps[palette.base];
  map[0] = kPage;
  for (std::size_t i = 0; i < kCount; ++i) {
    const double place = static_cast<double>(i) / static_cast<double>(kCount - 1) * (kAnchors.size() - 1);
    const std::size_t left = std::min(static_cast<std::size_t>(place), kAnchors.size() - 2);
    const double t = place - static_cast<double>(left);
    const auto& a = kAnchors[left];
    const auto& b = kAnchors[left + 1];
    map[kFirst + i] = {between(a.red, b.red, t), between(a.green, b.green, t), between(a.blue, b.blue, t)};
  }
  return palette;
}

}  // namespace espalier::command
