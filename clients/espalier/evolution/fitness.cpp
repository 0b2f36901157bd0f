#include "clients/espalier/evolution/fitness.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "engine/core/diagnostic.h"
#include "engine/core/elementary.h"
#include "engine/turtle/scene/geometry.h"

namespace espalier::command {
namespace {

using core::Vec3;

// the width of lines that counts as green, in parts of the extent
constexpr double kTwigsInExtent = 128.0;

// a picture of the ground from above, in cells
class GroundShade {
 public:
  static constexpr int kCells = 512;

  GroundShade(double lowX, double lowZ, double extent)
      : lowX_(lowX), lowZ_(lowZ), cell_(extent / kCells), isShaded_(static_cast<std::size_t>(kSide) * kSide) {}

  // all cells whose centre is within half the width of a line, a cell at least
  void addLine(const Vec3& start, const Vec3& end, double width) {
    const double radius = std::max(width, cell_) / 2.0;
    const double dx = end.x - start.x;
    const double dz = end.z - start.z;
    const double square = dx * dx + dz * dz;
    visit(std::min(start.x, end.x) - radius, std::max(start.x, end.x) + radius, std::min(start.z, end.z) - radius,
          std::max(start.z, end.z) + radius, [&](double x, double z) {
            const double along =
                square > 0.0 ? std::clamp(((x - start.x) * dx + (z - start.z) * dz) / square, 0.0, 1.0) : 0.0;
            return core::hypot(x - start.x - along * dx, z - start.z - along * dz) <= radius;
          });
  }

  void addTriangle(const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto side = [](const Vec3& p, const Vec3& q, double x, double z) {
      return (q.x - p.x) * (z - p.z) - (q.z - p.z) * (x - p.x);
    };
    visit(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), std::min({a.z, b.z, c.z}), std::max({a.z, b.z, c.z}),
          [&](double x, double z) {
            const double first = side(a, b, x, z);
            const double second = side(b, c, x, z);
            const double third = side(c, a, x, z);
            return (first >= 0.0 && second >= 0.0 && third >= 0.0) || (first <= 0.0 && second <= 0.0 && third <= 0.0);
          });
  }

  [[nodiscard]] double area() const {
    return static_cast<double>(std::count(isShaded_.begin(), isShaded_.end(), true)) * cell_ * cell_;
  }

 private:
  static constexpr int kSide = kCells + 8;  // widths at the rim

  template <typename Contains>
  void visit(double lowX, double highX, double lowZ, double highZ, const Contains& contains) {
    const int left = cellOf(lowX - lowX_);
    const int right = cellOf(highX - lowX_);
    const int near = cellOf(lowZ - lowZ_);
    const int far = cellOf(highZ - lowZ_);
    for (int j = near; j <= far; ++j) {
      for (int i = left; i <= right; ++i) {
        if (contains(lowX_ + (i - 3.5) * cell_, lowZ_ + (j - 3.5) * cell_)) {
          isShaded_[static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i)] = true;
        }
      }
    }
  }

  [[nodiscard]] int cellOf(double distance) const {
    return static_cast<int>(std::clamp(std::floor(distance / cell_) + 4.0, 0.0, kSide - 1.0));
  }

  double lowX_;
  double lowZ_;
  double cell_;
  std::vector<bool> isShaded_;
};

struct Bounds {
  Vec3 low{INFINITY, INFINITY, INFINITY};
  Vec3 high{-INFINITY, -INFINITY, -INFINITY};

  void add(const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  [[nodiscard]] double extent() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }
};

// area of the shade on the ground of light that goes `alongX` and `alongZ` to the side for each unit
// downward; lines count as `widest` at most; lines reach at most `margin` beyond the points at their ends
double shadeOf(const turtle::Geometry& geometry, double alongX, double alongZ, double widest, double margin = 0.0) {
  const auto fallen = [&](const Vec3& p) { return Vec3{p.x + alongX * p.y, 0.0, p.z + alongZ * p.y}; };
  Bounds bounds;
  bounds.add({});
  for (std::size_t i = 0; i < geometry.start.size(); ++i) {
    bounds.add(fallen(geometry.start[i]));
    bounds.add(fallen(geometry.end[i]));
  }
  for (const Vec3& vertex : geometry.vertices) {
    bounds.add(fallen(vertex));
  }
  // a plant of vertical lines shades a point
  double height = 0.0;
  for (const Vec3& end : geometry.end) {
    height = std::max(height, end.y);
  }
  const double extent = std::max(bounds.extent(), height) + 2.0 * margin;
  if (!(extent > 0.0)) {
    return 0.0;
  }
  GroundShade shade(bounds.low.x - margin, bounds.low.z - margin, extent);
  for (std::size_t i = 0; i < geometry.start.size(); ++i) {
    const double width = geometry.areWidthsPixels ? 0.0 : std::max(geometry.startWidth[i], geometry.endWidth[i]);
    shade.addLine(fallen(geometry.start[i]), fallen(geometry.end[i]), std::min(width, widest));
  }
  for (const auto& [a, b, c] : geometry.triangles) {
    shade.addTriangle(fallen(geometry.vertices[a]), fallen(geometry.vertices[b]), fallen(geometry.vertices[c]));
  }
  return shade.area();
}

double branchingOf(std::span<const turtle::Segment> segments) {
  std::vector<std::uint32_t> children(segments.size());
  for (const turtle::Segment& segment : segments) {
    if (segment.parent != turtle::kNoParent) {
      ++children[segment.parent];
    }
  }
  const auto inner = std::count_if(children.begin(), children.end(), [](std::uint32_t count) { return count > 0; });
  const auto forks = std::count_if(children.begin(), children.end(), [](std::uint32_t count) { return count > 1; });
  return inner > 0 ? static_cast<double>(forks) / static_cast<double>(inner) : 0.0;
}

// how much of the lines' length has its mirror image, in cells of 1/24 of the extent about the plane x = 0
double symmetryOf(const turtle::Geometry& geometry, double extent) {
  const double cell = extent / 24.0;
  // x, y, z of a cell, length in it
  std::vector<std::tuple<std::int64_t, std::int64_t, std::int64_t, double>> samples;
  double total = 0.0;
  const auto index = [cell](double x) { return static_cast<std::int64_t>(std::lround(x / cell)); };
  for (std::size_t i = 0; i < geometry.start.size(); ++i) {
    const Vec3 along = geometry.end[i] - geometry.start[i];
    const double length = core::length(along);
    const auto parts = static_cast<std::size_t>(length / cell * 2.0) + 1;
    for (std::size_t part = 0; part < parts; ++part) {
      const Vec3 p = geometry.start[i] + along * ((static_cast<double>(part) + 0.5) / static_cast<double>(parts));
      samples.emplace_back(index(p.x), index(p.y), index(p.z), length / static_cast<double>(parts));
    }
    total += length;
  }
  // lengths by cell
  std::sort(samples.begin(), samples.end());
  std::vector<std::tuple<std::int64_t, std::int64_t, std::int64_t, double>> cells;
  for (const auto& [x, y, z, length] : samples) {
    if (!cells.empty() && std::get<0>(cells.back()) == x && std::get<1>(cells.back()) == y &&
        std::get<2>(cells.back()) == z) {
      std::get<3>(cells.back()) += length;
    } else {
      cells.emplace_back(x, y, z, length);
    }
  }
  double mirrored = 0.0;
  for (const auto& [x, y, z, length] : cells) {
    const auto image = std::lower_bound(cells.begin(), cells.end(), std::tuple(-x, y, z, 0.0));
    if (image != cells.end() && std::get<0>(*image) == -x && std::get<1>(*image) == y && std::get<2>(*image) == z) {
      mirrored += std::min(length, std::get<3>(*image));
    }
  }
  return total > 0.0 ? mirrored / total : 0.0;
}

}  // namespace

double measure(const PlantMeasures& measures, std::size_t index) {
  const std::array<double, kMeasureNames.size()> values{measures.height,   measures.light,     measures.sky,
                                                        measures.symmetry, measures.stability, measures.branching,
                                                        measures.length,   measures.extent,    measures.organs};
  return values.at(index);
}

PlantMeasures measurePlant(turtle::Scene&& scene, const files::ViewSettings& view) {
  PlantMeasures measures;
  measures.branching = branchingOf(scene.segments.view());
  turtle::Geometry geometry;
  turtle::appendGeometry(
      std::move(scene), view, [](std::uint32_t, std::uint64_t) { return core::SymbolId{0}; }, geometry);

  Bounds bounds;
  bounds.add({});
  Vec3 centre;
  for (std::size_t i = 0; i < geometry.start.size(); ++i) {
    bounds.add(geometry.start[i]);
    bounds.add(geometry.end[i]);
    const double length = core::length(geometry.end[i] - geometry.start[i]);
    measures.length += length;
    centre = centre + (geometry.start[i] + geometry.end[i]) * (length / 2.0);
  }
  for (const Vec3& vertex : geometry.vertices) {
    bounds.add(vertex);
  }
  measures.height = bounds.high.y;
  measures.organs = static_cast<double>(geometry.organs.size());
  if (bounds.extent() <= 0.0) {
    return measures;
  }
  if (measures.length > 0.0) {
    centre = centre * (1.0 / measures.length);
    const double beside = core::hypot(centre.x, centre.z);
    measures.stability = measures.height > 0.0 ? 1.0 - std::min(1.0, beside / (measures.height / 2.0)) : 0.0;
    measures.symmetry = symmetryOf(geometry, bounds.extent());
  }
  measures.extent = bounds.extent();
  measures.light = shadeOf(geometry, 0.0, 0.0, INFINITY);
  // a beam 45 degrees high is as much narrower than its shade on the ground
  const double twig = measures.extent / kTwigsInExtent;
  const double oblique = shadeOf(geometry, 1.0, 0.0, twig) + shadeOf(geometry, -1.0, 0.0, twig) +
                         shadeOf(geometry, 0.0, 1.0, twig) + shadeOf(geometry, 0.0, -1.0, twig);
  measures.sky = (shadeOf(geometry, 0.0, 0.0, twig) + oblique / std::numbers::sqrt2) / 5.0;
  return measures;
}

double silhouetteArea(const turtle::Geometry& geometry) {
  double widest = 0.0;
  for (std::size_t i = 0; i < geometry.start.size() && !geometry.areWidthsPixels; ++i) {
    widest = std::max({widest, geometry.startWidth[i], geometry.endWidth[i]});
  }
  return shadeOf(geometry, 0.0, 0.0, INFINITY, widest / 2.0);
}

std::optional<std::string> FitnessFormula::read(std::string_view text, FitnessFormula& formula) {
  formula.factors.clear();
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    const std::size_t equals = item.find('=');
    const std::string_view name = item.substr(0, equals);
    const auto found = std::find(kMeasureNames.begin(), kMeasureNames.end(), name);
    if (found == kMeasureNames.end()) {
      return "there is no measure '" + std::string(name) + "'. " +
             core::suggestName(name, {kMeasureNames.begin(), kMeasureNames.end()});
    }
    double exponent = 1.0;
    if (equals != std::string_view::npos) {
      const std::string_view number = item.substr(equals + 1);
      const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), exponent);
      if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(exponent)) {
        return "'" + std::string(number) + "' is not a number: give an exponent, as in symmetry=2,light=1";
      }
    }
    formula.factors.emplace_back(static_cast<std::size_t>(found - kMeasureNames.begin()), exponent);
    if (comma == std::string_view::npos) {
      return std::nullopt;
    }
    text.remove_prefix(comma + 1);
  }
}

double FitnessFormula::operator()(const PlantMeasures& measures) const {
  double product = 1.0;
  for (const auto& [index, exponent] : factors) {
    product *= core::pow(measure(measures, index), exponent);
  }
  return std::isfinite(product) ? product : 0.0;
}

}  // namespace espalier::command
