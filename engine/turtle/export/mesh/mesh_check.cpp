#include "engine/turtle/export/mesh/mesh_check.h"

#include <algorithm>
#include <cmath>

namespace espalier::turtle {

using core::Vec3;

namespace {

double rounded(double value) {
  return static_cast<double>(static_cast<float>(value));
}

bool isWritable(const Vec3& p) {
  constexpr double kLargestSingle = std::numeric_limits<float>::max();
  return std::abs(p.x) <= kLargestSingle && std::abs(p.y) <= kLargestSingle && std::abs(p.z) <= kLargestSingle;
}

}  // namespace

void Bounds::add(const Mesh& mesh) {
  for (const Vec3& position : mesh.positions) {
    const Vec3 p{rounded(position.x), rounded(position.y), rounded(position.z)};
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
}

void Bounds::add(const Bounds& other) {
  low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y), std::min(low.z, other.low.z)};
  high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y), std::max(high.z, other.high.z)};
}

std::optional<std::string> problemOf(const Mesh& mesh, const SceneMeshes& scene, const MeshPart& part) {
  const auto wrong = std::ranges::find_if_not(mesh.positions, isWritable);
  if (wrong == mesh.positions.end()) {
    return std::nullopt;
  }
  const ExportInput& input = scene.input();
  const Provenance provenance =
      scene.provenanceOf(part, mesh, static_cast<std::size_t>(wrong - mesh.positions.begin()));
  std::string place = "plant " + std::to_string(provenance.plant) + ", module " + std::to_string(provenance.module);
  if (input.step) {
    place.insert(0, "step " + std::to_string(*input.step) + ", ");
  }
  const bool isKnown = input.program != nullptr && provenance.plant < input.strings.size() &&
                       provenance.module < input.strings[provenance.plant]->size();
  if (isKnown) {
    const core::ModuleTypeId type = input.strings[provenance.plant]->types()[provenance.module];
    place += " ('" + std::string(input.program->nameOf(type)) + "')";
  }
  return place + ": its geometry is not finite in 32-bit numbers. Bound the lengths, widths and scales of the model";
}

Vec3 unitNormal(const Vec3& normal) {
  // most are unit vectors: no root
  if (std::abs(core::dot(normal, normal) - 1.0) < 1e-3) {
    return normal;
  }
  const double length = core::length(normal);
  return std::abs(length - 1.0) < 1e-3           ? normal
         : length > 0.0 && std::isfinite(length) ? normal * (1.0 / length)
                                                 : Vec3{0.0, 1.0, 0.0};
}

}  // namespace espalier::turtle
