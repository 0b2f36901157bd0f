#include "environment/obstacles/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::size_t kSides = 32;

/// An affine map: the images of the axes and of the origin.
struct Affine {
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};
  Vec3 origin;

  [[nodiscard]] Vec3 direction(const Vec3& v) const { return x * v.x + y * v.y + z * v.z; }
  [[nodiscard]] Vec3 point(const Vec3& p) const { return origin + direction(p); }
  /// First `first`, then this.
  [[nodiscard]] Affine after(const Affine& first) const {
    return {direction(first.x), direction(first.y), direction(first.z), point(first.origin)};
  }
};

Affine rotation(double degrees, const Vec3& given) {
  const Vec3 axis = core::normalised(given);
  const double c = core::cos(degrees * std::numbers::pi / 180.0);
  const double s = core::sin(degrees * std::numbers::pi / 180.0);
  const auto turned = [&](const Vec3& v) {
    return v * c + core::cross(axis, v) * s + axis * (core::dot(axis, v) * (1.0 - c));
  };
  return {turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}), {}};
}

struct Word {
  std::string_view text;
  int line = 1;
};

/// The words of a text without its comments.
std::vector<Word> wordsOf(std::string& text) {
  // comments become blanks, so that lines keep their numbers
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (text[i] == '/' && (text[i + 1] == '/' || text[i + 1] == '*')) {
      const bool isLine = text[i + 1] == '/';
      const std::size_t end = isLine ? text.find('\n', i) : text.find("*/", i + 2);
      const std::size_t last = end == std::string::npos ? text.size() : end + (isLine ? 0 : 2);
      for (; i < last; ++i) {
        text[i] = text[i] == '\n' ? '\n' : ' ';
      }
    }
  }
  std::vector<Word> words;
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const bool isBlank = text[i] == ' ' || text[i] == '\t' || text[i] == '\r' || text[i] == '\n' || text[i] == ',';
    if (isBlank) {
      line += text[i] == '\n' ? 1 : 0;
      ++i;
      continue;
    }
    const std::size_t end = std::min(text.find_first_of(" \t\r\n,", i), text.size());
    words.push_back({std::string_view(text).substr(i, end - i), line});
    i = end;
  }
  return words;
}

class SceneReader {
 public:
  std::string command(std::string_view keyword, const std::vector<double>& n) {
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
      apply(keyword == "scale" ? Affine{{n[0], 0, 0}, {0, n[1], 0}, {0, 0, n[2]}, {}}
                               : Affine{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {n[0], n[1], n[2]}});
    } else if (keyword == "rotate") {
      if (!needs(4)) {
        return "4 numbers";
      }
      apply(rotation(n[0], {n[1], n[2], n[3]}));
    } else if (keyword == "multmatrix") {
      if (!needs(16)) {
        return "16 numbers";
      }
      apply({{n[0], n[1], n[2]}, {n[4], n[5], n[6]}, {n[8], n[9], n[10]}, {n[12], n[13], n[14]}});
    } else {
      return shape(keyword, n);
    }
    return {};
  }
  SceneShapes take() { return std::move(shapes_); }

 private:
  std::string shape(std::string_view keyword, const std::vector<double>& n) {
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
      addCone(n[0], isCone ? n[1] : n[0], isCone ? n[2] : n[1]);
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
      MeshData mesh;
      for (std::size_t i = 0; i + 3 <= n.size(); i += 3) {
        mesh.vertices.push_back(stack_.back().point({n[i], n[i + 1], n[i + 2]}));
      }
      for (std::uint32_t k = 0; 2 * k + 3 < mesh.vertices.size(); ++k) {
        mesh.triangles.push_back({2 * k, 2 * k + 1, 2 * k + 3});
        mesh.triangles.push_back({2 * k, 2 * k + 3, 2 * k + 2});
      }
      shapes_.meshes.push_back(std::move(mesh));
    }
    return {};
  }

  void apply(const Affine& first) { stack_.back() = stack_.back().after(first); }

  void addFan(const std::vector<Vec3>& points) {
    MeshData mesh;
    for (const Vec3& point : points) {
      mesh.vertices.push_back(stack_.back().point(point));
    }
    for (std::uint32_t k = 1; k + 1 < points.size(); ++k) {
      mesh.triangles.push_back({0, k, k + 1});
    }
    shapes_.meshes.push_back(std::move(mesh));
  }

  void addPrism(double a, double b, double c) {
    MeshData mesh;
    for (int corner = 0; corner < 8; ++corner) {
      mesh.vertices.push_back(
          stack_.back().point({(corner & 1) != 0 ? a : 0.0, (corner & 2) != 0 ? b : 0.0, (corner & 4) != 0 ? c : 0.0}));
    }
    constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& f : kFaces) {
      mesh.triangles.push_back({f[0], f[1], f[2]});
      mesh.triangles.push_back({f[0], f[2], f[3]});
    }
    shapes_.meshes.push_back(std::move(mesh));
  }

  /// Around +y, closed, the points of the rings in order and a middle at both ends.
  void addRings(const std::vector<std::pair<double, double>>& radiusAndHeight, double low, double high) {
    MeshData mesh;
    for (const auto& [radius, height] : radiusAndHeight) {
      for (std::size_t side = 0; side < kSides; ++side) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(side) / static_cast<double>(kSides);
        mesh.vertices.push_back(stack_.back().point({radius * core::cos(angle), height, radius * core::sin(angle)}));
      }
    }
    const auto rings = static_cast<std::uint32_t>(radiusAndHeight.size());
    const auto sides = static_cast<std::uint32_t>(kSides);
    mesh.vertices.push_back(stack_.back().point({0, low, 0}));
    mesh.vertices.push_back(stack_.back().point({0, high, 0}));
    for (std::uint32_t side = 0; side < sides; ++side) {
      const std::uint32_t next = (side + 1) % sides;
      for (std::uint32_t ring = 0; ring + 1 < rings; ++ring) {
        const std::uint32_t below = ring * sides;
        const std::uint32_t above = below + sides;
        mesh.triangles.push_back({below + side, above + side, above + next});
        mesh.triangles.push_back({below + side, above + next, below + next});
      }
      mesh.triangles.push_back({rings * sides, side, next});
      mesh.triangles.push_back({rings * sides + 1, (rings - 1) * sides + next, (rings - 1) * sides + side});
    }
    shapes_.meshes.push_back(std::move(mesh));
  }

  void addCone(double base, double top, double height) { addRings({{base, 0.0}, {top, height}}, 0.0, height); }

  void addSphere(double radius) {
    const Affine& m = stack_.back();
    const double size = core::length(m.x);
    const double slack = 1e-9 * size;
    const bool isRound = std::abs(core::length(m.y) - size) <= slack && std::abs(core::length(m.z) - size) <= slack &&
                         std::abs(core::dot(m.x, m.y)) <= slack * size &&
                         std::abs(core::dot(m.y, m.z)) <= slack * size && std::abs(core::dot(m.z, m.x)) <= slack * size;
    if (isRound) {
      shapes_.spheres.push_back({m.origin, radius * size});
      return;
    }
    std::vector<std::pair<double, double>> rings;
    for (std::size_t k = 1; k < kSides / 2; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k) / static_cast<double>(kSides / 2);
      rings.emplace_back(radius * core::sin(angle), -radius * core::cos(angle));
    }
    addRings(rings, -radius, radius);
  }

  std::vector<Affine> stack_{Affine{}};
  SceneShapes shapes_;
};

}  // namespace

tl::expected<SceneShapes, std::string> readScene(std::string_view text) {
  std::string copy(text);
  const std::vector<Word> words = wordsOf(copy);
  SceneReader reader;
  for (std::size_t i = 0; i < words.size();) {
    const Word keyword = words[i++];
    std::vector<double> numbers;
    for (; i < words.size(); ++i) {
      const auto number = core::parseNumber(words[i].text);
      if (!number) {
        break;
      }
      numbers.push_back(*number);
    }
    const std::string missing = reader.command(keyword.text, numbers);
    if (!missing.empty()) {
      return tl::unexpected("line " + std::to_string(keyword.line) + ": '" + std::string(keyword.text) + "' needs " +
                            missing + ", found " + std::to_string(numbers.size()) + " numbers");
    }
  }
  return reader.take();
}

}  // namespace espalier::environment
