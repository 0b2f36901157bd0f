#include "engine/turtle/export/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <tuple>

#include "engine/core/elementary.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kTowardMiddle = 1e-3;  // of a patch, in its parameters
constexpr double kSharpEdge = 0.5;      // cosine between the normals of patches that do not join smoothly

std::array<double, 4> bernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}

std::array<double, 4> bernsteinSlope(double t) {
  const double s = 1.0 - t;
  return {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t};
}

Vec3 tensor(const std::array<Vec3, 16>& points, const std::array<double, 4>& s, const std::array<double, 4>& t) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      sum = sum + (s[i] * t[j]) * points[i * 4 + j];
    }
  }
  return sum;
}

Vec3 patchNormal(const std::array<Vec3, 16>& points, double s, double t) {
  const Vec3 alongS = tensor(points, bernsteinSlope(s), bernstein(t));
  const Vec3 alongT = tensor(points, bernstein(s), bernsteinSlope(t));
  return core::cross(alongT, alongS);
}

// whether a normal is no more than the rounding of the patch's size
bool isVanishing(const Vec3& normal, const std::array<Vec3, 16>& points) {
  double size = 0.0;
  for (const Vec3& p : points) {
    size = std::max(size, core::length(p - points[0]));
  }
  return core::length(normal) <= 1e-12 * size * size;
}

// the quads of a grid of (rows + 1) by (columns + 1) vertices that begins at `first`
void appendGridFaces(Mesh& mesh, std::uint32_t first, std::uint32_t rows, std::uint32_t columns) {
  std::size_t face = mesh.faces.size();
  mesh.faces.resize(face + std::size_t{rows} * columns);
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column;
      const std::uint32_t b = a + columns + 1;
      mesh.faces[face++] = {a, a + 1, b + 1, b};
    }
  }
}

// gives vertices at the same place the mean of their normals, unless they meet at a sharp edge
void smoothSeams(Mesh& mesh, std::size_t first) {
  std::vector<std::size_t> order(mesh.positions.size() - first);
  std::iota(order.begin(), order.end(), first);
  const auto place = [&mesh](std::size_t i) {
    const Vec3& p = mesh.positions[i];
    return std::tuple(p.x, p.y, p.z);
  };
  std::ranges::stable_sort(order, {}, place);
  const std::vector<Vec3> before = mesh.normals;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && place(order[end]) == place(order[begin])) {
      ++end;
    }
    for (std::size_t i = begin; end - begin > 1 && i < end; ++i) {
      Vec3 sum;
      for (std::size_t k = begin; k < end; ++k) {
        if (core::dot(before[order[i]], before[order[k]]) > kSharpEdge) {
          sum = sum + before[order[k]];
        }
      }
      mesh.normals[order[i]] = core::normalised(sum);
    }
    begin = end;
  }
}

// of a normal of any length; up when it has none
Vec3 unitOrUp(const Vec3& normal) {
  const double length = core::length(normal);
  return length > 0.0 ? Vec3{normal.x / length, normal.y / length, normal.z / length} : Vec3{0.0, 1.0, 0.0};
}

void appendVertex(Mesh& mesh, const Vec3& position, const Vec3& normal, double u, double v) {
  mesh.positions.push_back(position);
  mesh.normals.push_back(unitOrUp(normal));
  mesh.coordinates.push_back({u, v});
}

// vertices that are set by their number afterwards
void appendVertices(Mesh& mesh, std::size_t count) {
  mesh.positions.resize(mesh.positions.size() + count);
  mesh.normals.resize(mesh.positions.size());
  mesh.coordinates.resize(mesh.positions.size());
}

}  // namespace

void Mesh::clear() {
  positions.clear();
  normals.clear();
  coordinates.clear();
  faces.clear();
  vertexSegments.clear();
}

std::size_t Mesh::triangleCount() const {
  return static_cast<std::size_t>(
      std::accumulate(faces.begin(), faces.end(), std::size_t{0},
                      [](std::size_t sum, const auto& face) { return sum + (face[3] == kNoVertex ? 1U : 2U); }));
}

int atDetail(int count, double detail, int least) {
  return std::max(least, static_cast<int>(std::lround(count * detail)));
}

void appendPatch(Mesh& mesh, const std::array<Vec3, 16>& points, int subdivisionS, int subdivisionT) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i <= subdivisionS; ++i) {
    for (int j = 0; j <= subdivisionT; ++j) {
      const double s = static_cast<double>(i) / subdivisionS;
      const double t = static_cast<double>(j) / subdivisionT;
      Vec3 normal = patchNormal(points, s, t);
      if (isVanishing(normal, points)) {
        // where an edge has shrunk to a point: the limit from inside
        normal = patchNormal(points, s + kTowardMiddle * (0.5 - s), t + kTowardMiddle * (0.5 - t));
      }
      appendVertex(mesh, tensor(points, bernstein(s), bernstein(t)), normal, s, t);
    }
  }
  appendGridFaces(mesh, first, static_cast<std::uint32_t>(subdivisionS), static_cast<std::uint32_t>(subdivisionT));
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  mesh.normals.insert(mesh.normals.end(), other.normals.begin(), other.normals.end());
  mesh.coordinates.insert(mesh.coordinates.end(), other.coordinates.begin(), other.coordinates.end());
  for (std::array<std::uint32_t, 4> face : other.faces) {
    for (std::uint32_t& vertex : face) {
      vertex += vertex == Mesh::kNoVertex ? 0 : first;
    }
    mesh.faces.push_back(face);
  }
}

namespace {

// so small a part of the longest side is lost in single precision
constexpr double kFlatTriangle = 1e-6;
constexpr double kSamePlace = 1e-7;

bool hasArea(const Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vec3 u = mesh.positions[b] - mesh.positions[a];
  const Vec3 v = mesh.positions[c] - mesh.positions[a];
  const Vec3 w = v - u;
  const double longest = std::max({core::dot(u, u), core::dot(v, v), core::dot(w, w)});
  return core::length(core::cross(u, v)) > kFlatTriangle * longest;
}

// Whether the areas of a face's triangles are far from the bound: then neither joinCorners nor hasArea would change the
// face. The sum is at least the square of the longest side or diagonal. The area is at most a side times the longest,
// so that no side is short either. True of nearly all faces, and quicker than both. A NaN fails.
bool isFarFromFlat(const Mesh& mesh, const std::array<std::uint32_t, 4>& face) {
  constexpr double kMargin = 4.0;
  const bool isQuad = face[3] != Mesh::kNoVertex;
  const Vec3& a = mesh.positions[face[0]];
  const Vec3 ab = mesh.positions[face[1]] - a;
  const Vec3 ac = mesh.positions[face[2]] - a;
  const Vec3 ad = isQuad ? mesh.positions[face[3]] - a : ac;
  const double longest = 2.0 * (core::dot(ab, ab) + core::dot(ac, ac) + core::dot(ad, ad));
  const double least = kMargin * kFlatTriangle * kFlatTriangle * longest * longest;
  const Vec3 first = core::cross(ab, ac);
  const Vec3 second = isQuad ? core::cross(ac, ad) : first;
  return core::dot(first, first) > least && core::dot(second, second) > least;
}

// corners at almost one place come to lie at exactly one, so that no gap opens where a face is left out
void joinCorners(Mesh& mesh, std::span<const std::uint32_t> corners) {
  double longest = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 side = mesh.positions[corners[(i + 1) % corners.size()]] - mesh.positions[corners[i]];
    longest = std::max(longest, core::dot(side, side));
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto [first, second] = std::minmax(corners[i], corners[(i + 1) % corners.size()]);
    const Vec3 side = mesh.positions[second] - mesh.positions[first];
    if (core::dot(side, side) <= kSamePlace * kSamePlace * longest) {
      mesh.positions[second] = mesh.positions[first];
    }
  }
}

}  // namespace

bool dropDegenerateFaces(Mesh& mesh) {
  auto kept = mesh.faces.begin();
  while (kept != mesh.faces.end() && isFarFromFlat(mesh, *kept)) {
    ++kept;
  }
  if (kept == mesh.faces.end()) {
    return false;
  }
  for (auto face = kept; face != mesh.faces.end(); ++face) {
    if (isFarFromFlat(mesh, *face)) {
      *kept++ = *face;
      continue;
    }
    const auto [a, b, c, d] = *face;
    joinCorners(mesh, std::span(*face).first(d == Mesh::kNoVertex ? 3 : 4));
    const bool isFirst = hasArea(mesh, a, b, c);
    const bool isSecond = d != Mesh::kNoVertex && hasArea(mesh, a, c, d);
    if (isFirst || isSecond) {
      *kept++ = isFirst == isSecond ? std::array{a, b, c, d}
                : isFirst           ? std::array{a, b, c, Mesh::kNoVertex}
                                    : std::array{a, c, d, Mesh::kNoVertex};
    }
  }
  mesh.faces.erase(kept, mesh.faces.end());
  return true;
}

void appendPlaced(Mesh& mesh, const Mesh& local, const OrganPlacement& placement) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const Vec3& s = placement.scale;
  const auto toWorld = [&frame = placement.frame](double x, double y, double z) {
    return x * frame.left + y * frame.heading + z * frame.up;
  };
  const bool isMirrored = s.x * s.y * s.z < 0.0;
  appendVertices(mesh, local.positions.size());
  for (std::size_t i = 0; i < local.positions.size(); ++i) {
    const Vec3& p = local.positions[i];
    const Vec3& n = local.normals[i];
    mesh.positions[first + i] = placement.position + toWorld(p.x * s.x, p.y * s.y, p.z * s.z);
    // the product of the other two factors instead of the inverse of each: no division
    const Vec3 normal = toWorld(n.x * s.y * s.z, n.y * s.x * s.z, n.z * s.x * s.y);
    mesh.normals[first + i] = core::normalised(isMirrored ? -normal : normal);
    mesh.coordinates[first + i] = local.coordinates[i];
  }
  for (std::array<std::uint32_t, 4> face : local.faces) {
    const bool isTriangle = face[3] == Mesh::kNoVertex;
    if (isMirrored) {
      std::reverse(face.begin(), face.begin() + (isTriangle ? 3 : 4));
    }
    mesh.faces.push_back({first + face[0], first + face[1], first + face[2], isTriangle ? face[3] : first + face[3]});
  }
}

void appendLocalSurface(Mesh& mesh, const files::Surface& surface, double detail) {
  const std::size_t first = mesh.positions.size();
  for (const files::SurfacePatch& patch : surface.patches) {
    appendPatch(mesh, patch.points, atDetail(std::clamp(surface.subdivisionS, 1, 100), detail, 1),
                atDetail(std::clamp(surface.subdivisionT, 1, 100), detail, 1));
  }
  smoothSeams(mesh, first);
}

void setWholeCoordinates(Mesh& mesh) {
  if (mesh.positions.empty()) {
    return;
  }
  Vec3 low = mesh.positions[0];
  Vec3 high = low;
  for (const Vec3& p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), 0.0};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), 0.0};
  }
  const auto share = [](double value, double from, double to) {
    return to > from ? (value - from) / (to - from) : 0.0;
  };
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3& p = mesh.positions[i];
    mesh.coordinates[i] = {share(p.x, low.x, high.x), share(p.y, low.y, high.y)};
  }
}

void appendLocalSurface(Mesh& mesh, const files::TriangleSurface& surface) {
  for (const files::SurfaceTriangle& triangle : surface.triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::size_t k = 0; k < 3; ++k) {
      appendVertex(mesh, triangle.points[k], triangle.normals[k], triangle.coordinates[k][0],
                   triangle.coordinates[k][1]);
    }
    // the file's normals decide which side is the front
    const Vec3 across = core::cross(triangle.points[1] - triangle.points[0], triangle.points[2] - triangle.points[0]);
    const bool isTurned = core::dot(across, triangle.normals[0] + triangle.normals[1] + triangle.normals[2]) < 0.0;
    mesh.faces.push_back({first, first + (isTurned ? 2 : 1), first + (isTurned ? 1 : 2), Mesh::kNoVertex});
  }
}

void appendSurface(Mesh& mesh, const SurfaceInstance& instance, const files::ViewSettings& view) {
  Mesh local;
  if (instance.isTriangleSurface && instance.surface < view.triangleSurfaces.size()) {
    appendLocalSurface(local, view.triangleSurfaces[instance.surface]);
  } else if (!instance.isTriangleSurface && instance.surface < view.surfaces.size()) {
    appendLocalSurface(local, view.surfaces[instance.surface]);
  }
  appendPlaced(mesh, local, {instance.position, instance.frame, instance.scale});
}

void appendSphere(Mesh& mesh, const Vec3& centre, double diameter, int rings, int sides) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(sides);
  for (int i = 0; i <= rings; ++i) {
    // exactly at the poles, so that their vertices meet
    const bool isPole = i == 0 || i == rings;
    const double latitude = std::numbers::pi * i / rings;
    const double radius = isPole ? 0.0 : core::sin(latitude);
    const double height = isPole ? (i == 0 ? -1.0 : 1.0) : -core::cos(latitude);
    for (int j = 0; j <= sides; ++j) {
      const double longitude = 2.0 * std::numbers::pi * (j % sides) / sides;
      const Vec3 normal{radius * core::cos(longitude), height, -radius * core::sin(longitude)};
      appendVertex(mesh, centre + (diameter / 2.0) * normal, normal, static_cast<double>(j) / sides,
                   static_cast<double>(i) / rings);
    }
  }
  for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(rings); ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column;
      const std::uint32_t b = a + columns + 1;
      if (row == 0) {
        mesh.faces.push_back({a, b + 1, b, Mesh::kNoVertex});
      } else if (row + 1 == static_cast<std::uint32_t>(rings)) {
        mesh.faces.push_back({a, a + 1, b, Mesh::kNoVertex});
      } else {
        mesh.faces.push_back({a, a + 1, b + 1, b});
      }
    }
  }
}

void appendDisc(Mesh& mesh, const Ball& ball, int sides) {
  const auto centre = static_cast<std::uint32_t>(mesh.positions.size());
  appendVertex(mesh, ball.centre, ball.frame.up, 0.5, 0.5);
  for (int k = 0; k <= sides; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / sides;
    const Vec3 direction = core::cos(angle) * ball.frame.left + core::sin(angle) * ball.frame.heading;
    appendVertex(mesh, ball.centre + (ball.diameter / 2.0) * direction, ball.frame.up, 0.5 + 0.5 * core::cos(angle),
                 0.5 + 0.5 * core::sin(angle));
  }
  for (std::uint32_t k = 1; k <= static_cast<std::uint32_t>(sides); ++k) {
    mesh.faces.push_back({centre, centre + k, centre + k + 1, Mesh::kNoVertex});
  }
}

TubeCircle tubeCircle(int sides) {
  TubeCircle circle;
  for (int k = 0; k <= sides; ++k) {
    const double angle = 2.0 * std::numbers::pi * (k % sides) / sides;
    circle.push_back({core::cos(angle), core::sin(angle)});
  }
  return circle;
}

void appendTube(Mesh& mesh, const Tube& tube, const TubeCircle& circle, double ratio) {
  const std::vector<TubeRing>& rings = tube.rings;
  if (rings.size() < 2) {
    return;
  }
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(circle.size() - 1);
  std::size_t vertex = first;
  const std::size_t ends = (tube.isOpenAtStart ? 0U : 1U) + (tube.isOpenAtEnd ? 0U : 1U);
  appendVertices(mesh, rings.size() * circle.size() + ends * columns);
  mesh.vertexSegments.resize(mesh.positions.size());
  const auto set = [&](const TubeRing& ring, std::uint32_t corner, const Vec3& unitNormal, double u, double v) {
    const auto [c, s] = circle[corner];
    mesh.positions[vertex] = ring.centre + (c * ring.up + s * ring.side);
    mesh.normals[vertex] = unitNormal;
    mesh.coordinates[vertex] = {u, v};
    mesh.vertexSegments[vertex] = ring.segment;
    ++vertex;
  };
  for (const TubeRing& ring : rings) {
    const Vec3 tilt = ring.slope * core::cross(ring.normalUp, ring.normalSide);
    for (std::uint32_t k = 0; k <= columns; ++k) {
      const auto [c, s] = circle[k];
      set(ring, k, unitOrUp(c * ring.normalUp + s * ring.normalSide + tilt), static_cast<double>(k) / columns,
          ratio > 0.0 ? ring.turns / ratio : ring.along);
    }
  }
  appendGridFaces(mesh, first, static_cast<std::uint32_t>(rings.size() - 1), columns);
  // flat ends, with vertices of their own for their normals
  for (const bool isEnd : {false, true}) {
    if (isEnd ? tube.isOpenAtEnd : tube.isOpenAtStart) {
      continue;
    }
    const TubeRing& ring = isEnd ? rings.back() : rings.front();
    const Vec3 outward = unitOrUp(core::cross(ring.normalUp, ring.normalSide) * (isEnd ? 1.0 : -1.0));
    const auto rim = static_cast<std::uint32_t>(vertex);
    for (std::uint32_t k = 0; k < columns; ++k) {
      const auto [c, s] = circle[k];
      set(ring, k, outward, 0.5 + 0.5 * c, 0.5 + 0.5 * s);
    }
    for (std::uint32_t k = 1; k + 1 < columns; ++k) {
      mesh.faces.push_back(isEnd ? std::array{rim, rim + k, rim + k + 1, Mesh::kNoVertex}
                                 : std::array{rim, rim + k + 1, rim + k, Mesh::kNoVertex});
    }
  }
}

}  // namespace espalier::turtle
