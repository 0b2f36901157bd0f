#include "engine/turtle/scene/geometry.h"

#include <limits>
#include <string>
#include <utility>

#include "engine/core/simulation_error.h"
#include "engine/turtle/export/mesh/scene_meshes.h"

namespace espalier::turtle {
namespace {

using SymbolOf = std::function<core::SymbolId(std::uint32_t plant, std::uint64_t module)>;

std::uint8_t tagOf(std::int32_t colour) {
  return static_cast<std::uint8_t>(((colour % 256) + 256) % 256);
}

void addSource(GeometrySources& sources, const Provenance& from, std::int32_t colour, const SymbolOf& symbolOf) {
  sources.plant.push_back(from.plant);
  sources.module.push_back(from.module);
  sources.symbol.push_back(symbolOf(from.plant, from.module));
  sources.colour.push_back(tagOf(colour));
  sources.branchOrder.push_back(from.branchOrder);
}

GeometryKind kindOf(OrganKind kind) {
  switch (kind) {
    case OrganKind::Polygon:
      return GeometryKind::Polygon;
    case OrganKind::Surface:
      return GeometryKind::Surface;
    case OrganKind::Patch:
      return GeometryKind::Patch;
    case OrganKind::Ball:
      return GeometryKind::Ball;
    case OrganKind::Branch:
    case OrganKind::Cylinder:
      break;
  }
  return GeometryKind::Cylinder;
}

void addSegments(std::span<const Segment> segments, const SymbolOf& symbolOf, Geometry& geometry) {
  for (const Segment& segment : segments) {
    addSource(geometry.segments, {segment.plant, segment.module, segment.branchOrder}, segment.colour, symbolOf);
    geometry.start.push_back(segment.start);
    geometry.end.push_back(segment.end);
    geometry.startWidth.push_back(segment.startWidth);
    geometry.endWidth.push_back(segment.endWidth);
  }
}

void addMesh(const Mesh& mesh, Geometry& geometry) {
  const std::size_t first = geometry.vertices.size();
  if (first + mesh.positions.size() > std::numeric_limits<std::uint32_t>::max()) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::LimitExceeded;
    error.message =
        "The organs have more than 4294967295 vertices, too many for an environment that asks for geometry.";
    throw core::SimulationFailure(std::move(error));
  }
  const auto vertex = [first](std::uint32_t index) { return static_cast<std::uint32_t>(first + index); };
  geometry.vertices.insert(geometry.vertices.end(), mesh.positions.begin(), mesh.positions.end());
  for (const auto& face : mesh.faces) {
    geometry.triangles.push_back({vertex(face[0]), vertex(face[1]), vertex(face[2])});
    if (face[3] != Mesh::kNoVertex) {
      geometry.triangles.push_back({vertex(face[0]), vertex(face[2]), vertex(face[3])});
    }
  }
  geometry.vertexOffset.push_back(geometry.vertices.size());
  geometry.triangleOffset.push_back(geometry.triangles.size());
}

}  // namespace

void appendGeometry(Scene&& scene, const files::ViewSettings& view, const SymbolOf& symbolOf, Geometry& geometry) {
  geometry.areWidthsPixels = scene.lineStyle == files::LineStyle::Pixel;
  addSegments(std::exchange(scene.segments, {}).view(), symbolOf, geometry);
  // without its lines the scene's meshes are its organs
  const ExportInput input{.scene = scene, .view = view};
  MaterialTable materials;
  core::WorkerTeam alone(1);
  const SceneMeshes meshes(input, materials, alone, true);
  Mesh mesh;
  for (const MeshPart& part : meshes.parts()) {
    meshes.make(part, mesh);
    if (mesh.faces.empty()) {
      continue;
    }
    addSource(geometry.organs, meshes.provenanceOf(part), part.colour, symbolOf);
    geometry.kind.push_back(kindOf(part.kind));
    addMesh(mesh, geometry);
  }
}

}  // namespace espalier::turtle
