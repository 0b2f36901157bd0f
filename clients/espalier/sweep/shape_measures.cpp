#include "clients/espalier/sweep/shape_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"

namespace espalier::command {
namespace {

using core::Vec3;

constexpr double kNoSize = std::numeric_limits<double>::quiet_NaN();
constexpr int kPieces = 16;

enum Shape : std::size_t {
  Height,
  Lowest,
  ExtentX,
  ExtentY,
  ExtentZ,
  Spread,
  Length,
  Segments,
  WoodArea,
  WoodVolume,
  Organs,
  LeafArea,
  SilhouetteTop,
  SilhouetteFront,
  SilhouetteSide,
  Sky,
  Symmetry,
  Stability,
  Branching
};

enum Quantity : std::size_t { ProfileLength, ProfileWoodArea, ProfileWoodVolume, ProfileLeafArea, ProfileOrgans };

double areaOf(const turtle::Geometry& geometry, std::size_t triangle) {
  const auto& [a, b, c] = geometry.triangles[triangle];
  const Vec3 first = geometry.vertices[b] - geometry.vertices[a];
  const Vec3 second = geometry.vertices[c] - geometry.vertices[a];
  return core::length(core::cross(first, second)) / 2.0;
}

// length, lateral area or volume of a segment
double quantityOf(const turtle::Geometry& geometry, std::size_t segment, std::size_t quantity) {
  const double length = core::length(geometry.end[segment] - geometry.start[segment]);
  const double first = geometry.startWidth[segment] / 2.0;
  const double second = geometry.endWidth[segment] / 2.0;
  if (quantity == ProfileLength) {
    return length;
  }
  if (geometry.areWidthsPixels) {
    return kNoSize;
  }
  return quantity == ProfileWoodArea
             ? std::numbers::pi * (first + second) * core::hypot(length, first - second)
             : std::numbers::pi * length * (first * first + first * second + second * second) / 3.0;
}

double sumOfSegments(const turtle::Geometry& geometry, std::size_t quantity) {
  double sum = 0.0;
  for (std::size_t i = 0; i < geometry.start.size(); ++i) {
    sum += quantityOf(geometry, i, quantity);
  }
  return sum;
}

double leafArea(const turtle::Geometry& geometry) {
  double sum = 0.0;
  for (std::size_t i = 0; i < geometry.triangles.size(); ++i) {
    sum += areaOf(geometry, i);
  }
  return sum;
}

template <typename Visit>
void visitPoints(const turtle::Geometry& geometry, const Visit& visit) {
  std::for_each(geometry.start.begin(), geometry.start.end(), visit);
  std::for_each(geometry.end.begin(), geometry.end.end(), visit);
  std::for_each(geometry.vertices.begin(), geometry.vertices.end(), visit);
}

double boundOf(const turtle::Geometry& geometry, std::size_t name) {
  Vec3 low{INFINITY, INFINITY, INFINITY};
  Vec3 high{-INFINITY, -INFINITY, -INFINITY};
  double spread = 0.0;
  visitPoints(geometry, [&](const Vec3& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    spread = std::max(spread, core::hypot(p.x, p.z));
  });
  if (low.x > high.x) {
    return 0.0;  // nothing is drawn
  }
  switch (name) {
    case Height:
      return high.y;
    case Lowest:
      return low.y;
    case ExtentX:
      return high.x - low.x;
    case ExtentY:
      return high.y - low.y;
    case ExtentZ:
      return high.z - low.z;
    default:
      return spread;
  }
}

// the geometry with another axis upright
turtle::Geometry turned(turtle::Geometry geometry, double Vec3::*upright) {
  const auto turn = [upright](std::vector<Vec3>& points) {
    for (Vec3& p : points) {
      std::swap(p.y, p.*upright);
    }
  };
  turn(geometry.start);
  turn(geometry.end);
  turn(geometry.vertices);
  return geometry;
}

}  // namespace

const std::vector<std::string_view>& shapeMeasureNames() {
  static const std::vector<std::string_view> kNames{
      "height",         "lowest",   "extentX",    "extentY",   "extentZ",  "spread",        "length",
      "segments",       "woodArea", "woodVolume", "organs",    "leafArea", "silhouetteTop", "silhouetteFront",
      "silhouetteSide", "sky",      "symmetry",   "stability", "branching"};
  return kNames;
}

const std::vector<std::string_view>& profileNames() {
  static const std::vector<std::string_view> kNames{"length", "woodArea", "woodVolume", "leafArea", "organs"};
  return kNames;
}

ShapeMeasures::ShapeMeasures(turtle::Scene&& scene, const files::ViewSettings& view) : scene_(scene), view_(view) {
  turtle::appendGeometry(
      std::move(scene), view, [](std::uint32_t, std::uint64_t) { return core::SymbolId{0}; }, geometry_);
}

const PlantMeasures& ShapeMeasures::fitness() {
  if (!fitness_) {
    fitness_ = measurePlant(std::move(*scene_), view_);
    scene_.reset();
  }
  return *fitness_;
}

double ShapeMeasures::value(std::size_t name) {
  switch (name) {
    case Length:
      return sumOfSegments(geometry_, ProfileLength);
    case Segments:
      return static_cast<double>(geometry_.start.size());
    case WoodArea:
      return sumOfSegments(geometry_, ProfileWoodArea);
    case WoodVolume:
      return sumOfSegments(geometry_, ProfileWoodVolume);
    case Organs:
      return static_cast<double>(geometry_.organs.size());
    case LeafArea:
      return leafArea(geometry_);
    case SilhouetteTop:
      return silhouetteArea(geometry_);
    case SilhouetteFront:
      return silhouetteArea(turned(geometry_, &Vec3::z));
    case SilhouetteSide:
      return silhouetteArea(turned(geometry_, &Vec3::x));
    case Sky:
      return fitness().sky;
    case Symmetry:
      return fitness().symmetry;
    case Stability:
      return fitness().stability;
    case Branching:
      return fitness().branching;
    default:
      return boundOf(geometry_, name);
  }
}

std::vector<double> ShapeMeasures::profile(std::size_t name, bool isAlongRadius, std::uint64_t bins, double to) const {
  std::vector<double> sums(bins);
  const auto add = [&](const Vec3& p, double amount) {
    const double place = isAlongRadius ? core::hypot(p.x, p.z) : p.y;
    const double bin = std::floor(place / to * static_cast<double>(bins));
    if (bin >= 0.0 && bin < static_cast<double>(bins)) {
      sums[static_cast<std::size_t>(bin)] += amount;
    }
  };
  if (name == ProfileOrgans) {
    for (std::size_t i = 0; i < geometry_.organs.size(); ++i) {
      add(geometry_.vertices[geometry_.vertexOffset[i]], 1.0);
    }
  } else if (name == ProfileLeafArea) {
    for (std::size_t i = 0; i < geometry_.triangles.size(); ++i) {
      const auto& [a, b, c] = geometry_.triangles[i];
      add((geometry_.vertices[a] + geometry_.vertices[b] + geometry_.vertices[c]) * (1.0 / 3.0), areaOf(geometry_, i));
    }
  } else {
    for (std::size_t i = 0; i < geometry_.start.size(); ++i) {
      const double amount = quantityOf(geometry_, i, name) / kPieces;
      const Vec3 along = geometry_.end[i] - geometry_.start[i];
      for (int piece = 0; piece < kPieces; ++piece) {
        add(geometry_.start[i] + along * ((piece + 0.5) / kPieces), amount);
      }
    }
  }
  return sums;
}

}  // namespace espalier::command
