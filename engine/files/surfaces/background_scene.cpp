#include "engine/files/surfaces/background_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::files {
namespace {

using core::Vec3;

constexpr std::size_t kBackgroundSides = 32;
constexpr std::string_view kBackgroundBlanks = " \t\r\n,";

/// An affine map: the images of the axes and of the origin.
struct BackgroundMap {
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};
  Vec3 origin;

  [[nodiscard]] Vec3 direction(const Vec3& v) const { return x * v.x + y * v.y + z * v.z; }
  [[nodiscard]] Vec3 point(const Vec3& p) const { return origin + direction(p); }
  /// First `first`, then this.
  [[nodiscard]] BackgroundMap after(const BackgroundMap& first) const {
    return {direction(first.x), direction(first.y), direction(first.z), point(first.origin)};
  }
};

BackgroundMap turnAbout(double degrees, const Vec3& given) {
  const Vec3 axis = core::normalised(given);
  const double c = core::cos(degrees * std::numbers::pi / 180.0);
  const double s = core::sin(degrees * std::numbers::pi / 180.0);
  const auto turned = [&](const Vec3& v) {
    return v * c + core::cross(axis, v) * s + axis * (core::dot(axis, v) * (1.0 - c));
  };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {}};
}

struct SceneWord {
  std::string_view text;
  core::SourceRange range;
  std::uint32_t line = 1;
};

/// Makes comments blank, so that places stay.
void blankComments(std::string& text) {
  std::size_t i = 0;
  while (i + 1 < text.size()) {
    const bool isLine = text[i] == '/' && text[i + 1] == '/';
    if (!isLine && !(text[i] == '/' && text[i + 1] == '*')) {
      ++i;
      continue;
    }
    const std::size_t end = isLine ? text.find('\n', i) : text.find("*/", i + 2);
    const std::size_t last = end == std::string::npos ? text.size() : end + (isLine ? 0 : 2);
    for (; i < last; ++i) {
      text[i] = text[i] == '\n' ? '\n' : ' ';
    }
  }
}

std::vector<SceneWord> wordsOfScene(std::string_view text) {
  std::vector<SceneWord> words;
  std::uint32_t line = 1;
  for (std::size_t i = 0; i < text.size();) {
    if (kBackgroundBlanks.find(text[i]) != std::string_view::npos) {
      line += text[i] == '\n' ? 1U : 0U;
      ++i;
      continue;
    }
    const std::size_t end = std::min(text.find_first_of(kBackgroundBlanks, i), text.size());
    words.push_back({text.substr(i, end - i), {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(end)}, line});
    i = end;
  }
  return words;
}

/// Executes the keywords of a background scene.
class BackgroundReader {
 public:
  static constexpr std::string_view kUnknown = "?";

  /// Empty, or what the keyword needs; kUnknown: there is no such keyword.
  std::string_view command(std::string_view keyword, const std::vector<double>& n) {
    const auto needs = [&](std::size_t count) { return n.size() >= count; };
    if (keyword == "pushmatrix") {
      stack_.push_back(stack_.back());
    } else if (keyword == "popmatrix") {
      if (stack_.size() > 1) {
        stack_.pop_back();
      }
    } else if (keyword == "translate" || keyword == "scale") {
      if (!needs(3)) {
        return "3 numbers";
      }
      apply(keyword == "scale" ? BackgroundMap{{n[0], 0, 0}, {0, n[1], 0}, {0, 0, n[2]}, {}}
                               : BackgroundMap{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {n[0], n[1], n[2]}});
    } else if (keyword == "rotate") {
      if (!needs(4)) {
        return "4 numbers";
      }
      apply(turnAbout(n[0], {n[1], n[2], n[3]}));
    } else if (keyword == "multmatrix") {
      if (!needs(16)) {
        return "16 numbers";
      }
      apply({{n[0], n[1], n[2]}, {n[4], n[5], n[6]}, {n[8], n[9], n[10]}, {n[12], n[13], n[14]}});
    } else if (keyword == "material") {
      return addMaterial(n);
    } else {
      return cornerCount_ > kMostBackgroundCorners ? "a scene with fewer corners" : shape(keyword, n);
    }
    return {};
  }
  BackgroundScene take() { return std::move(scene_); }

 private:
  std::string_view shape(std::string_view keyword, const std::vector<double>& n) {
    if (keyword == "sphere") {
      if (n.empty()) {
        return "a radius";
      }
      if (n[0] < 0.0) {
        return "a radius that is not negative";
      }
      addSphere(n[0]);
    } else if (keyword == "prism" || keyword == "box") {
      if (n.size() < 3) {
        return "3 numbers";
      }
      addPrism(n[0], n[1], n[2]);
    } else if (keyword == "cylinder" || keyword == "cone") {
      const bool isCone = keyword == "cone";
      if (n.size() < (isCone ? 3U : 2U)) {
        return isCone ? "3 numbers" : "2 numbers";
      }
      if (n[0] < 0.0 || (isCone && n[1] < 0.0)) {
        return "radii that are not negative";
      }
      const double height = isCone ? n[2] : n[1];
      addRings({{n[0], 0.0}, {isCone ? n[1] : n[0], height}}, 0.0, height);
    } else if (keyword == "rectangle") {
      if (n.size() < 2) {
        return "2 numbers";
      }
      const double x = n.size() > 3 ? n[2] : 0.0;
      const double y = n.size() > 3 ? n[3] : 0.0;
      addFan({{x, y, 0}, {x + n[0], y, 0}, {x + n[0], y + n[1], 0}, {x, y + n[1], 0}});
    } else if (keyword == "polygon" || keyword == "polygonuv") {
      const std::size_t stride = keyword == "polygon" ? 3 : 6;
      if (n.size() < 3 * stride) {
        return "at least 3 points";
      }
      std::vector<Vec3> points;
      for (std::size_t i = 0; i + stride <= n.size(); i += stride) {
        points.push_back({n[i], n[i + 1], n[i + 2]});
      }
      addFan(points);
    } else if (keyword == "mesh") {
      if (n.size() < 12) {
        return "at least 4 points";
      }
      addStrip(n);
    } else {
      return kUnknown;
    }
    return {};
  }

  // ambient, diffuse, specular and emission with four components each, then the exponent; only complete groups count
  std::string_view addMaterial(const std::vector<double>& n) {
    // complete groups only: fewer than four numbers change nothing
    if (n.size() < 4) {
      return {};
    }
    if (scene_.materials.size() >= kMostBackgroundMaterials) {
      return "a scene with at most 256 materials";
    }
    Material material = scene_.materials.back();
    double opacity = 1.0;
    const std::array groups{&material.ambient, &material.diffuse, &material.specular, &material.emission};
    for (std::size_t group = 0; group < groups.size() && n.size() >= 4 * group + 4; ++group) {
      for (std::size_t k = 0; k < 3; ++k) {
        (*groups[group])[k] = std::clamp(n[4 * group + k], 0.0, 1.0);
      }
      // the opacity of the ambient light has no effect
      opacity = group > 0 ? std::min(opacity, std::clamp(n[4 * group + 3], 0.0, 1.0)) : opacity;
    }
    material.opacity = n.size() >= 8 ? opacity : material.opacity;
    material.shininess = n.size() > 16 ? std::clamp(n[16], 0.0, 128.0) : material.shininess;
    scene_.materials.push_back(material);
    return {};
  }

  void apply(const BackgroundMap& first) { stack_.back() = stack_.back().after(first); }

  void add(BackgroundShape shape) {
    cornerCount_ += shape.vertices.size() + 1;
    shape.material = static_cast<std::uint32_t>(scene_.materials.size() - 1);
    scene_.shapes.push_back(std::move(shape));
  }

  void addFan(const std::vector<Vec3>& points) {
    BackgroundShape fan;
    for (const Vec3& point : points) {
      fan.vertices.push_back(stack_.back().point(point));
    }
    for (std::uint32_t k = 1; k + 1 < points.size(); ++k) {
      fan.triangles.push_back({0, k, k + 1});
    }
    add(std::move(fan));
  }

  void addStrip(const std::vector<double>& n) {
    BackgroundShape strip;
    for (std::size_t i = 0; i + 3 <= n.size(); i += 3) {
      strip.vertices.push_back(stack_.back().point({n[i], n[i + 1], n[i + 2]}));
    }
    for (std::uint32_t k = 0; 2 * k + 3 < strip.vertices.size(); ++k) {
      strip.triangles.push_back({2 * k, 2 * k + 1, 2 * k + 3});
      strip.triangles.push_back({2 * k, 2 * k + 3, 2 * k + 2});
    }
    add(std::move(strip));
  }

  void addPrism(double a, double b, double c) {
    BackgroundShape prism;
    for (int corner = 0; corner < 8; ++corner) {
      prism.vertices.push_back(
          stack_.back().point({(corner & 1) != 0 ? a : 0.0, (corner & 2) != 0 ? b : 0.0, (corner & 4) != 0 ? c : 0.0}));
    }
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& f : kFaces) {
      prism.triangles.push_back({f[0], f[1], f[2]});
      prism.triangles.push_back({f[0], f[2], f[3]});
    }
    add(std::move(prism));
  }

  /// Around +y, closed, the points of the rings in order and a middle at both ends.
  void addRings(const std::vector<std::pair<double, double>>& radiusAndHeight, double low, double high) {
    BackgroundShape body;
    for (const auto& [radius, height] : radiusAndHeight) {
      for (std::size_t side = 0; side < kBackgroundSides; ++side) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(side) / static_cast<double>(kBackgroundSides);
        body.vertices.push_back(stack_.back().point({radius * core::cos(angle), height, radius * core::sin(angle)}));
      }
    }
    const auto rings = static_cast<std::uint32_t>(radiusAndHeight.size());
    const auto sides = static_cast<std::uint32_t>(kBackgroundSides);
    body.vertices.push_back(stack_.back().point({0, low, 0}));
    body.vertices.push_back(stack_.back().point({0, high, 0}));
    for (std::uint32_t side = 0; side < sides; ++side) {
      const std::uint32_t next = (side + 1) % sides;
      for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
        const std::uint32_t below = ring * sides;
        const std::uint32_t above = below + sides;
        body.triangles.push_back({below + side, above + side, above + next});
        body.triangles.push_back({below + side, above + next, below + next});
      }
      body.triangles.push_back({rings * sides, side, next});
      body.triangles.push_back({rings * sides + 1, (rings - 1) * sides + next, (rings - 1) * sides + side});
    }
    add(std::move(body));
  }

  void addSphere(double radius) {
    const BackgroundMap& m = stack_.back();
    const double size = core::length(m.x);
    const double slack = 1e-9 * size;
    const bool isRound = std::abs(core::length(m.y) - size) <= slack && std::abs(core::length(m.z) - size) <= slack &&
                         std::abs(core::dot(m.x, m.y)) <= slack * size &&
                         std::abs(core::dot(m.y, m.z)) <= slack * size && std::abs(core::dot(m.z, m.x)) <= slack * size;
    if (isRound) {
      BackgroundShape sphere;
      sphere.isSphere = true;
      sphere.centre = m.origin;
      sphere.radius = radius * size;
      return add(std::move(sphere));
    }
    std::vector<std::pair<double, double>> rings;
    for (std::size_t k = 1; k < kBackgroundSides / 2; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / static_cast<double>(kBackgroundSides / 2);
      rings.emplace_back(radius * core::sin(angle), -radius * core::cos(angle));
    }
    addRings(rings, -radius, radius);
  }

  std::vector<BackgroundMap> stack_{BackgroundMap{}};
  std::size_t cornerCount_ = 0;
  // before any `material`: OpenGL's grey
  BackgroundScene scene_{{}, {Material{.ambient = {0.2, 0.2, 0.2}, .diffuse = {0.8, 0.8, 0.8}}}};
};

}  // namespace

BackgroundScene readBackgroundScene(std::string_view text, std::vector<BackgroundProblem>& problems) {
  std::string copy(text);
  blankComments(copy);
  const std::vector<SceneWord> words = wordsOfScene(copy);
  BackgroundReader reader;
  for (std::size_t i = 0; i < words.size();) {
    const SceneWord keyword = words[i++];
    const std::size_t first = i;
    std::vector<double> numbers;
    for (; i < words.size(); ++i) {
      const auto number = core::parseNumber(words[i].text);
      if (!number) {
        break;
      }
      numbers.push_back(*number);
    }
    const std::string_view missing = reader.command(keyword.text, numbers);
    if (missing.empty()) {
      continue;
    }
    const bool isUnknown = missing == BackgroundReader::kUnknown;
    const std::string name = "'" + std::string(keyword.text.substr(0, 40)) + "'";
    std::string found = ", found " + std::to_string(numbers.size()) + (numbers.size() == 1 ? " number" : " numbers");
    if (missing.ends_with("negative")) {
      const std::size_t begin = words[first].range.begin;
      found = ", found " + copy.substr(begin, std::min<std::size_t>(words[i - 1].range.end - begin, 40));
    } else if (missing.starts_with("a scene")) {
      found.clear();
    }
    problems.push_back({keyword.range, keyword.line,
                        isUnknown ? "unknown keyword " + name : name + " needs " + std::string(missing) + found,
                        isUnknown});
  }
  return reader.take();
}

}  // namespace espalier::files
