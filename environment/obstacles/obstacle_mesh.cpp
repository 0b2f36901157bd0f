#include "environment/obstacles/obstacle_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/files/surfaces/mesh_file.h"

namespace espalier::environment {

namespace {

using core::Vec3;
using Side = std::pair<std::uint32_t, std::uint32_t>;

Side sideOf(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

std::vector<Bounds> boxesOf(const std::vector<Triangle>& triangles) {
  std::vector<Bounds> boxes;
  boxes.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    boxes.push_back(boundsOf(triangle));
  }
  return boxes;
}

/// Whether each side belongs to two triangles and all can face one way. Then they do: in each connected part the
/// triangles in the minority are turned.
bool orient(std::vector<std::array<std::uint32_t, 3>>& triangles) {
  struct Users {
    std::size_t count = 0;
    std::array<std::size_t, 2> triangles{};  // the first two
  };
  std::map<Side, Users> usersOf;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      Users& users = usersOf[sideOf(triangles[i][k], triangles[i][(k + 1) % 3])];
      if (users.count < 2) {
        users.triangles[users.count] = i;
      }
      ++users.count;
    }
  }
  if (triangles.empty() || !std::ranges::all_of(usersOf, [](const auto& side) { return side.second.count == 2; })) {
    return false;
  }
  const auto runsAlong = [&](std::size_t i, std::uint32_t a, std::uint32_t b) {
    const auto& t = triangles[i];
    return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
  };
  enum class Facing : std::uint8_t { Unknown, AsGiven, Turned };
  std::vector<Facing> facings(triangles.size(), Facing::Unknown);
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    if (facings[first] != Facing::Unknown) {
      continue;
    }
    // from triangle to triangle over the sides of a part
    std::vector<std::size_t> part{first};
    std::size_t turnedCount = 0;
    facings[first] = Facing::AsGiven;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::size_t i = part[next];
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[i][k];
        const std::uint32_t b = triangles[i][(k + 1) % 3];
        const auto& both = usersOf[sideOf(a, b)].triangles;
        const std::size_t other = both[0] == i ? both[1] : both[0];
        const bool isTurned = (facings[i] == Facing::Turned) != runsAlong(other, a, b);
        const Facing facing = isTurned ? Facing::Turned : Facing::AsGiven;
        if (facings[other] == Facing::Unknown) {
          facings[other] = facing;
          part.push_back(other);
          turnedCount += isTurned ? 1U : 0U;
        } else if (facings[other] != facing) {
          return false;  // one-sided, like Klein's bottle
        }
      }
    }
    const Facing minority = 2 * turnedCount > part.size() ? Facing::AsGiven : Facing::Turned;
    for (const std::size_t i : part) {
      if (facings[i] == minority) {
        std::swap(triangles[i][1], triangles[i][2]);
      }
      facings[i] = Facing::AsGiven;
    }
  }
  return true;
}

/// Angle at corner `at` of three points.
double angleAt(const Vec3& at, const Vec3& b, const Vec3& c) {
  const Vec3 u = core::normalised(b - at);
  const Vec3 v = core::normalised(c - at);
  return core::atan2(core::length(core::cross(u, v)), core::dot(u, v));
}

}  // namespace

tl::expected<MeshData, std::string> readMesh(std::string_view name, const std::string& bytes) {
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  const bool isGltfText = first != std::string::npos && bytes[first] == '{';
  const auto read = name.empty() ? files::readMeshFile(isGltfText ? "mesh.gltf" : "mesh.obj", bytes)
                                 : files::readMeshFile(name, bytes);
  if (!read) {
    return tl::unexpected(read.error());
  }
  MeshData mesh;
  std::map<std::tuple<double, double, double>, std::uint32_t> places;
  for (const files::SurfaceTriangle& triangle : *read) {
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = triangle.points[k];
      const auto [place, isNew] = places.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (isNew) {
        mesh.vertices.push_back(p);
      }
      corners[k] = place->second;
    }
    mesh.triangles.push_back(corners);
  }
  return mesh;
}

void mergeCorners(MeshData& mesh) {
  // solids that touch have corners of their own
  if (auto asGiven = mesh.triangles; orient(asGiven)) {
    return;
  }
  std::map<std::tuple<double, double, double>, std::uint32_t> places;
  std::vector<std::uint32_t> firstAt;
  for (const Vec3& p : mesh.vertices) {
    const auto number = static_cast<std::uint32_t>(firstAt.size());
    firstAt.push_back(places.try_emplace({p.x, p.y, p.z}, number).first->second);
  }
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) {
      corner = corner < firstAt.size() ? firstAt[corner] : corner;
    }
  }
}

std::string problemOf(const MeshData& mesh) {
  if (mesh.triangles.empty()) {
    return "has no triangles";
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!isFinite(mesh.vertices[i])) {
      return "has a coordinate that is not a finite number, in vertex " + std::to_string(i + 1);
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t corner : mesh.triangles[i]) {
      if (corner >= mesh.vertices.size()) {
        return "has a corner that is none of its " + std::to_string(mesh.vertices.size()) + " vertices, in triangle " +
               std::to_string(i + 1);
      }
    }
  }
  return {};
}

ObstacleMesh::ObstacleMesh(MeshData data) : isGround_(data.isGround), tree_({}) {
  // triangles without area have no normal
  std::erase_if(data.triangles, [&](const auto& t) {
    const Vec3& a = data.vertices[t[0]];
    return !(core::length(core::cross(data.vertices[t[1]] - a, data.vertices[t[2]] - a)) > 0.0);
  });
  isClosed_ = orient(data.triangles);
  // negative when turned inside out
  double volume = 0.0;
  for (const auto& t : data.triangles) {
    volume += core::dot(data.vertices[t[0]], core::cross(data.vertices[t[1]], data.vertices[t[2]]));
  }
  // normals of sides are the sum of their triangles', those of corners are weighted by the angles
  const double sign = isClosed_ && volume < 0.0 ? -1.0 : 1.0;
  std::map<Side, Vec3> sideNormals;
  std::vector<Vec3> cornerNormals(data.vertices.size());
  std::vector<Vec3> faceNormals;
  for (const auto& t : data.triangles) {
    const std::array<Vec3, 3> p{data.vertices[t[0]], data.vertices[t[1]], data.vertices[t[2]]};
    const Vec3 normal = core::normalised(core::cross(p[1] - p[0], p[2] - p[0])) * sign;
    faceNormals.push_back(normal);
    triangles_.push_back({p});
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3& side = sideNormals[sideOf(t[k], t[(k + 1) % 3])];
      side = side + normal;
      Vec3& corner = cornerNormals[t[k]];
      corner = corner + normal * angleAt(p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
    }
  }
  for (std::size_t i = 0; i < data.triangles.size(); ++i) {
    const auto& t = data.triangles[i];
    normals_.push_back({faceNormals[i], sideNormals[sideOf(t[0], t[1])], sideNormals[sideOf(t[1], t[2])],
                        sideNormals[sideOf(t[2], t[0])], cornerNormals[t[0]], cornerNormals[t[1]],
                        cornerNormals[t[2]]});
  }
  const std::vector<Bounds> boxes = boxesOf(triangles_);
  if (!boxes.empty()) {
    bounds_ = boxes.front();
    for (const Bounds& box : boxes) {
      bounds_.low = {std::min(bounds_.low.x, box.low.x), std::min(bounds_.low.y, box.low.y),
                     std::min(bounds_.low.z, box.low.z)};
      bounds_.high = {std::max(bounds_.high.x, box.high.x), std::max(bounds_.high.y, box.high.y),
                      std::max(bounds_.high.z, box.high.z)};
    }
  }
  tree_ = BoxTree(boxes);
}

bool ObstacleMesh::isOverGround(const core::Vec3& p) const {
  return p.x >= bounds_.low.x && p.x <= bounds_.high.x && p.z >= bounds_.low.z && p.z <= bounds_.high.z;
}

std::optional<SurfacePoint> ObstacleMesh::nearest(const core::Vec3& p, double most) const {
  // a point may be deep inside a solid: then everything within its box matters
  const Bounds& box = bounds_;
  const bool isPerhapsInside =
      (isClosed_ && nearestOn(box, p).distance <= 0.0) || (isGround_ && isOverGround(p) && p.y <= box.high.y);
  double squared = isPerhapsInside ? std::numeric_limits<double>::infinity() : most * most;
  std::optional<std::uint32_t> found;
  TrianglePoint best;
  const double radius = isPerhapsInside ? core::length(p - box.low) + core::length(box.high - box.low) : most;
  tree_.visitNear(p, radius, [&](std::uint32_t i) {
    const TrianglePoint candidate = nearestOnTriangle(triangles_[i], p);
    const core::Vec3 way = p - candidate.point;
    const double d = core::dot(way, way);
    // equally near triangles: the first, whatever the order of visits
    if (d < squared || (d == squared && (!found || i < *found))) {
      squared = d;
      found = i;
      best = candidate;
    }
    return std::isfinite(squared) ? std::sqrt(squared) : radius;
  });
  if (!found) {
    return std::nullopt;
  }
  const core::Vec3 way = p - best.point;
  const double distance = std::sqrt(squared);
  const core::Vec3& pseudonormal = normals_[*found][static_cast<std::size_t>(best.feature)];
  const bool hasInside = isClosed_ || (isGround_ && isOverGround(p));
  const bool isIn = hasInside && core::dot(way, pseudonormal) < 0.0;
  if (!isIn && distance > most) {
    return std::nullopt;
  }
  SurfacePoint result{isIn ? -distance : distance, best.point, core::normalised(pseudonormal)};
  if (distance > 0.0) {
    result.normal = way * ((isIn ? -1.0 : 1.0) / distance);
  }
  return result;
}

bool ObstacleMesh::isInside(const core::Vec3& p) const {
  if (!isClosed_ && !isGround_) {
    return false;
  }
  const auto surface = nearest(p, 0.0);
  return surface && surface->distance <= 0.0;
}

std::optional<double> ObstacleMesh::distanceTo(const core::Vec3& a, const core::Vec3& b, double most) const {
  if (isInside(a) || isInside(b)) {
    return 0.0;
  }
  const core::Vec3 middle = (a + b) * 0.5;
  const double half = core::length(b - a) * 0.5;
  double distance = most;
  bool isFound = false;
  tree_.visitNear(middle, half + most, [&](std::uint32_t i) {
    const double d = environment::distanceTo(triangles_[i], a, b);
    if (d <= distance) {
      distance = d;
      isFound = true;
    }
    return half + distance;
  });
  return isFound ? std::optional(distance) : std::nullopt;
}

std::optional<double> ObstacleMesh::rayTo(const core::Vec3& origin, const core::Vec3& direction, double reach) const {
  if (isInside(origin)) {
    return 0.0;
  }
  double way = reach;
  bool isMet = false;
  tree_.visitRay(origin, direction, reach, [&](std::uint32_t i) {
    const auto hit = environment::rayTo(triangles_[i], origin, direction);
    if (hit && *hit <= way) {
      way = *hit;
      isMet = true;
    }
    return way;
  });
  return isMet ? std::optional(way) : std::nullopt;
}

}  // namespace espalier::environment
