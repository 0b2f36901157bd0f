#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/core/vec3.h"
#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// Where the rows of a table of geometry come from, as columns.
struct GeometrySources {
  std::vector<std::uint32_t> plant;        // (n)
  std::vector<std::uint64_t> module;       // index in the plant's string of the module that drew it (n)
  std::vector<core::SymbolId> symbol;      // of that module; a homomorphism may have drawn something else for it (n)
  std::vector<std::uint8_t> colour;        // index of the colour or material, a model's tag for organs (n)
  std::vector<std::uint32_t> branchOrder;  // (n)

  [[nodiscard]] std::size_t size() const { return plant.size(); }
  bool operator==(const GeometrySources&) const = default;
};

/// The shape of an organ.
enum class GeometryKind : std::uint8_t { Cylinder, Polygon, Surface, Patch, Ball };

/// The plants as an environment sees them: lines as segments, everything else as triangles. World coordinates and
/// units, all plants, by plant and then in the order of drawing (organs: by plant, kind, order of drawing). The organ
/// that a communication module stands before has the module index of its query plus one.
struct Geometry {
  // segments: straight and round, from start to end
  GeometrySources segments;                  // (s)
  std::vector<core::Vec3> start, end;        // (s)
  std::vector<double> startWidth, endWidth;  // diameters (s)
  bool areWidthsPixels = false;              // the model draws lines of so many pixels: they have no size in the world

  // organs: each a mesh of its own
  GeometrySources organs;                               // (o)
  std::vector<GeometryKind> kind;                       // (o)
  std::vector<std::uint64_t> vertexOffset{0};           // of each organ's vertices (o + 1)
  std::vector<std::uint64_t> triangleOffset{0};         // of each organ's triangles (o + 1)
  std::vector<core::Vec3> vertices;                     // of all organs, concatenated
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices into `vertices`

  bool operator==(const Geometry&) const = default;
};

/// Appends the geometry of a scene. `symbolOf` gives the symbol of a plant's module. The scene's segments are left
/// moved-from. Fails (core::SimulationFailure) when it takes more than 2^32 vertices. O(scene).
void appendGeometry(Scene&& scene, const files::ViewSettings& view,
                    const std::function<core::SymbolId(std::uint32_t plant, std::uint64_t module)>& symbolOf,
                    Geometry& geometry);

}  // namespace espalier::turtle
