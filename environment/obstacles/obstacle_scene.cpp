#include "environment/obstacles/obstacle_scene.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "environment/obstacles/scene_file.h"

namespace espalier::environment {

namespace {

using core::Vec3;

std::vector<Bounds> boundsOfAll(const ObstacleScene::Content& content) {
  std::vector<Bounds> bounds = content.boxes;
  const auto boundsOfOne = [](const auto& shape) { return boundsOf(shape); };
  std::transform(content.spheres.begin(), content.spheres.end(), std::back_inserter(bounds), boundsOfOne);
  std::transform(content.capsules.begin(), content.capsules.end(), std::back_inserter(bounds), boundsOfOne);
  return bounds;
}

bool isNearer(const std::optional<SurfacePoint>& candidate, const std::optional<SurfacePoint>& best) {
  if (!candidate || !best) {
    return candidate.has_value();
  }
  // equally near ones: by their places, whatever the order of visits
  const auto keyOf = [](const SurfacePoint& s) {
    return std::array{s.distance, s.point.x, s.point.y, s.point.z, s.normal.x, s.normal.y, s.normal.z};
  };
  return keyOf(*candidate) < keyOf(*best);
}

/// Calls `visit(shape)` with the shape of a number in the tree.
template <typename Visit>
auto withShape(const std::vector<Bounds>& boxes, const std::vector<Sphere>& spheres,
               const std::vector<Capsule>& capsules, std::size_t index, const Visit& visit) {
  if (index < boxes.size()) {
    return visit(boxes[index]);
  }
  index -= boxes.size();
  return index < spheres.size() ? visit(spheres[index]) : visit(capsules[index - spheres.size()]);
}

}  // namespace

ObstacleScene::ObstacleScene(Content content)
    : halfSpaces_(std::move(content.halfSpaces)),
      boxes_(content.boxes),
      spheres_(content.spheres),
      capsules_(content.capsules),
      tree_(boundsOfAll(content)) {
  for (MeshData& mesh : content.meshes) {
    meshes_.emplace_back(std::move(mesh));
  }
}

bool ObstacleScene::isEmpty() const {
  return halfSpaces_.empty() && boxes_.empty() && spheres_.empty() && capsules_.empty() && meshes_.empty();
}

std::optional<SurfacePoint> ObstacleScene::nearest(const Vec3& p, double most) const {
  std::optional<SurfacePoint> best;
  const auto consider = [&](const std::optional<SurfacePoint>& candidate) {
    if (candidate && candidate->distance <= most && isNearer(candidate, best)) {
      best = candidate;
    }
  };
  const auto left = [&] { return best ? std::clamp(best->distance, 0.0, most) : most; };
  for (const HalfSpace& space : halfSpaces_) {
    consider(nearestOn(space, p));
  }
  tree_.visitNear(p, left(), [&](std::size_t index) {
    withShape(boxes_, spheres_, capsules_, index, [&](const auto& shape) { consider(nearestOn(shape, p)); });
    return left();
  });
  for (const ObstacleMesh& mesh : meshes_) {
    consider(mesh.nearest(p, left()));
  }
  return best;
}

bool ObstacleScene::isInside(const Vec3& p) const {
  const auto surface = nearest(p, 0.0);
  return surface && surface->distance < 0.0;
}

bool ObstacleScene::isClear(const Vec3& a, const Vec3& b, double radius) const {
  const auto isTouching = [&](const auto& shape) { return distanceTo(shape, a, b) <= radius; };
  if (std::any_of(halfSpaces_.begin(), halfSpaces_.end(), isTouching)) {
    return false;
  }
  bool isFree = true;
  const double around = core::length(b - a) * 0.5 + radius;
  tree_.visitNear((a + b) * 0.5, around, [&](std::size_t index) {
    isFree = isFree && !withShape(boxes_, spheres_, capsules_, index, isTouching);
    return isFree ? around : 0.0;
  });
  return isFree && std::none_of(meshes_.begin(), meshes_.end(),
                                [&](const ObstacleMesh& mesh) { return mesh.distanceTo(a, b, radius).has_value(); });
}

double ObstacleScene::clearance(const Vec3& origin, const Vec3& direction, double reach) const {
  double way = reach;
  const auto consider = [&](const std::optional<double>& hit) { way = hit ? std::min(way, *hit) : way; };
  for (const HalfSpace& space : halfSpaces_) {
    consider(rayTo(space, origin, direction));
  }
  tree_.visitRay(origin, direction, way, [&](std::size_t index) {
    withShape(boxes_, spheres_, capsules_, index,
              [&](const auto& shape) { consider(rayTo(shape, origin, direction)); });
    return way;
  });
  for (const ObstacleMesh& mesh : meshes_) {
    consider(mesh.rayTo(origin, direction, way));
  }
  return way;
}

namespace {

/// Reads the keys and collects the errors.
class ObstacleReader {
 public:
  ObstacleReader(std::string_view process, const Configuration& configuration)
      : process_(process), configuration_(configuration) {}

  tl::expected<ObstacleScene::Content, std::vector<core::Diagnostic>> read() {
    readSolids();
    readHeights();
    readMeshes();
    if (!errors_.empty()) {
      return tl::unexpected(std::move(errors_));
    }
    return std::move(content_);
  }

 private:
  void add(const std::string& message, const std::string& hint) {
    errors_.push_back(wrongConfiguration(process_, message, hint));
  }

  static std::string place(std::string_view key, std::size_t row) {
    return "'" + std::string(key) + "[" + std::to_string(row) + "]'";
  }

  void readSolids() {
    const auto& planes = configuration_.rows("planes");
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const Vec3 normal{planes[i][3], planes[i][4], planes[i][5]};
      if (!(core::length(normal) > 0.0)) {
        add(place("planes", i) + " has a normal of no length", "its last three numbers are the normal");
      }
      content_.halfSpaces.push_back({{planes[i][0], planes[i][1], planes[i][2]}, core::normalised(normal)});
    }
    const auto& boxes = configuration_.rows("boxes");
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const auto& n = boxes[i];
      if (n[0] > n[3] || n[1] > n[4] || n[2] > n[5]) {
        add(place("boxes", i) + " has a first corner beyond its second",
            "the first corner has the smaller coordinates");
      }
      content_.boxes.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}});
    }
    const auto& spheres = configuration_.rows("spheres");
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      const auto& n = spheres[i];
      checkRadius("spheres", i, n[3]);
      content_.spheres.push_back({{n[0], n[1], n[2]}, n[3]});
    }
    const auto& capsules = configuration_.rows("capsules");
    for (std::size_t i = 0; i < capsules.size(); ++i) {
      const auto& n = capsules[i];
      checkRadius("capsules", i, n[6]);
      content_.capsules.push_back({{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6]});
    }
  }

  void checkRadius(std::string_view key, std::size_t row, double radius) {
    if (!(radius >= 0.0)) {
      add(place(key, row) + " has a negative radius", "its last number is the radius");
    }
  }

  void readHeights() {
    const auto& rows = configuration_.rows("heightField");
    const auto& extent = configuration_.numbers("heightFieldExtent");
    if (rows.empty()) {
      if (!extent.empty()) {
        add("'heightFieldExtent' is given without a 'heightField'", "give the heights, or leave both out");
      }
      return;
    }
    const std::size_t columns = rows.front().size();
    const bool isEven = std::all_of(rows.begin(), rows.end(), [&](const auto& row) { return row.size() == columns; });
    if (rows.size() < 2 || !isEven) {
      add("'heightField' must have at least 2 rows of one length",
          "one height for each corner of the ground's squares");
      return;
    }
    if (extent.size() != 4 || extent[0] >= extent[2] || extent[1] >= extent[3]) {
      add("'heightFieldExtent' must be smallest x, smallest z, largest x and largest z",
          "write it as [x0, z0, x1, z1]");
      return;
    }
    MeshData mesh;
    mesh.isGround = true;
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto& row = rows[rows.size() - 1 - k];
      const double z =
          extent[1] + (extent[3] - extent[1]) * static_cast<double>(k) / static_cast<double>(rows.size() - 1);
      for (std::size_t i = 0; i < columns; ++i) {
        const double x =
            extent[0] + (extent[2] - extent[0]) * static_cast<double>(i) / static_cast<double>(columns - 1);
        mesh.vertices.push_back({x, row[i], z});
      }
    }
    const auto across = static_cast<std::uint32_t>(columns);
    for (std::uint32_t k = 0; k + 1 < rows.size(); ++k) {
      for (std::uint32_t i = 0; i + 1 < across; ++i) {
        const std::uint32_t corner = k * across + i;
        mesh.triangles.push_back({corner, corner + across, corner + across + 1});
        mesh.triangles.push_back({corner, corner + across + 1, corner + 1});
      }
    }
    content_.meshes.push_back(std::move(mesh));
  }

  void addMesh(std::string_view key, MeshData mesh) {
    const std::string problem = problemOf(mesh);
    if (!problem.empty()) {
      add("'" + std::string(key) + "' " + problem, "a mesh has vertices with three numbers and triangles between them");
      return;
    }
    content_.meshes.push_back(std::move(mesh));
  }

  void readMeshes() {
    if (!configuration_.rows("triangles").empty() || !configuration_.rows("vertices").empty()) {
      MeshData mesh;
      for (const auto& row : configuration_.rows("vertices")) {
        mesh.vertices.push_back({row[0], row[1], row[2]});
      }
      for (const auto& row : configuration_.rows("triangles")) {
        const auto corner = [&](std::size_t k) {
          return static_cast<std::uint32_t>(std::min(row[k], double{std::numeric_limits<std::uint32_t>::max()}));
        };
        mesh.triangles.push_back({corner(0), corner(1), corner(2)});
      }
      mergeCorners(mesh);
      addMesh("triangles", std::move(mesh));
    }
    if (!configuration_.text("mesh").empty()) {
      auto mesh = readMesh({}, configuration_.text("mesh"));
      if (mesh) {
        addMesh("mesh", std::move(*mesh));
      } else {
        add("'mesh': " + mesh.error(), "give the text of a Wavefront OBJ or glTF file");
      }
    }
    if (!configuration_.text("scene").empty()) {
      auto scene = readScene(configuration_.text("scene"));
      if (!scene) {
        add("'scene', " + scene.error(), "give the text of a background scene");
        return;
      }
      content_.spheres.insert(content_.spheres.end(), scene->spheres.begin(), scene->spheres.end());
      for (MeshData& mesh : scene->meshes) {
        addMesh("scene", std::move(mesh));
      }
    }
  }

  std::string_view process_;
  const Configuration& configuration_;
  ObstacleScene::Content content_;
  std::vector<core::Diagnostic> errors_;
};

}  // namespace

tl::expected<ObstacleScene::Content, std::vector<core::Diagnostic>> readObstacles(std::string_view process,
                                                                                  const Configuration& configuration) {
  return ObstacleReader(process, configuration).read();
}

}  // namespace espalier::environment
