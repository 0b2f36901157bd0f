#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/frame.h"
#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// A small mesh of triangles and quads with a normal and texture coordinates for each vertex.
struct Mesh {
  static constexpr std::uint32_t kNoVertex = 0xFFFFFFFF;

  std::vector<core::Vec3> positions;
  std::vector<core::Vec3> normals;                  // (vertexCount), unit
  std::vector<std::array<double, 2>> coordinates;   // (vertexCount)
  std::vector<std::array<std::uint32_t, 4>> faces;  // a triangle's fourth is kNoVertex
  // of tubes: the segment that each vertex belongs to, an index into Scene::segments (vertexCount). A face belongs to
  // that of its third corner. Empty for other meshes
  std::vector<std::uint32_t> vertexSegments;

  void clear();
  [[nodiscard]] std::size_t triangleCount() const;
};

/// Where a mesh that several organs share stands: a point p of it is at position + scale.x p.x left + scale.y p.y
/// heading + scale.z p.z up of the frame.
struct OrganPlacement {
  core::Vec3 position;
  core::Frame frame;
  core::Vec3 scale{1.0, 1.0, 1.0};
};

/// Appends a mesh as it is, without the segments of its vertices and faces.
void append(Mesh& mesh, const Mesh& other);

/// Removes the triangles without area in single precision, as files hold it; a quad with one becomes a triangle. The
/// vertices stay. False: all faces are far from that, and the mesh is as it was. O(faces).
bool dropDegenerateFaces(Mesh& mesh);

/// Appends a mesh where an organ is. A mirrored placement turns its faces round, as glTF's nodes do.
void appendPlaced(Mesh& mesh, const Mesh& local, const OrganPlacement& placement);

/// `count` times a level of detail, at least `least`.
[[nodiscard]] int atDetail(int count, double detail, int least);

/// The samples of a bicubic Bezier patch, rows along s.
void appendPatch(Mesh& mesh, const std::array<core::Vec3, 16>& points, int subdivisionS, int subdivisionT);

/// A surface `~c` of the view file in its own coordinates (along L, H, U), smooth across its patches. `detail`: factor
/// of its subdivision. Texture coordinates are those of each patch, or go once over the whole surface in its x and y.
void appendLocalSurface(Mesh& mesh, const files::Surface& surface, double detail = 1.0);
void setWholeCoordinates(Mesh& mesh);
void appendLocalSurface(Mesh& mesh, const files::TriangleSurface& surface);

/// A surface `~c` where the turtle placed it.
void appendSurface(Mesh& mesh, const SurfaceInstance& instance, const files::ViewSettings& view);

/// A sphere of `rings` by `sides` quads.
void appendSphere(Mesh& mesh, const core::Vec3& centre, double diameter, int rings, int sides);

/// A disc in the plane of H and L.
inline constexpr int kDiscSides = 24;  // of the discs in pictures
void appendDisc(Mesh& mesh, const Ball& ball, int sides);

/// One ring of a tube: `sides + 1` vertices centre + cos(k) up + sin(k) side, the last at the place of the first (the
/// seam of the texture). `up` and `side` hold the radius; at a bend they are those of an oblique section.
struct TubeRing {
  core::Vec3 centre;
  core::Vec3 up;              // to the first vertex
  core::Vec3 side;            // a quarter turn on
  core::Vec3 normalUp;        // unit normals of the tube there, without its taper
  core::Vec3 normalSide;      // (cross(normalUp, normalSide) is the tube's direction)
  double slope = 0.0;         // radius lost per unit of length: tilts the normals
  double along = 0.0;         // length of the tube up to here: the second texture coordinate
  double turns = 0.0;         // the same in circumferences
  std::uint32_t segment = 0;  // that ends here, an index into Scene::segments; of the first ring: that begins here
};

/// A tube through rings. Where it goes on as the tube of another mesh with the same ring, it is open.
struct Tube {
  std::vector<TubeRing> rings;
  bool isOpenAtStart = false;
  bool isOpenAtEnd = false;
};

/// Cosine and sine of the corners of a tube (sides + 1); the last are the first again.
using TubeCircle = std::vector<std::array<double, 2>>;
[[nodiscard]] TubeCircle tubeCircle(int sides);

/// A tube with shared vertices; flat caps close the ends that are not open. `ratio` above 0: the second texture
/// coordinate counts pictures of that height by the tube's circumference; else lengths.
void appendTube(Mesh& mesh, const Tube& tube, const TubeCircle& circle, double ratio = 0.0);

/// `sides + 1` points of a contour at equal distances along it; a circle when `id` is not in the view file.
[[nodiscard]] std::vector<core::Vec3> sampleContour(const files::ViewSettings& view, std::int32_t id, int sides);

}  // namespace espalier::turtle
