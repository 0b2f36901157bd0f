#include "engine/turtle/export/mesh/mesh_rounds.h"

#include <algorithm>
#include <vector>

namespace espalier::turtle {

namespace {

constexpr std::size_t kTaskMeshes = 32;
constexpr std::size_t kRoundMeshes = 2048;

}  // namespace

std::optional<std::string> forMeshes(core::WorkerTeam& team, std::size_t count,
                                     const std::function<void(std::size_t, Mesh&)>& make,
                                     const std::function<std::optional<std::string>(std::size_t, const Mesh&)>& use) {
  if (team.size() == 1) {
    Mesh mesh;
    for (std::size_t i = 0; i < count; ++i) {
      mesh.clear();
      make(i, mesh);
      if (auto problem = use(i, mesh)) {
        return problem;
      }
    }
    return std::nullopt;
  }
  std::vector<Mesh> meshes(std::min(count, kRoundMeshes));
  for (std::size_t first = 0; first < count; first += kRoundMeshes) {
    const std::size_t here = std::min(kRoundMeshes, count - first);
    team.forEach((here + kTaskMeshes - 1) / kTaskMeshes, [&](std::size_t task) {
      for (std::size_t i = task * kTaskMeshes; i < std::min(here, (task + 1) * kTaskMeshes); ++i) {
        meshes[i].clear();
        make(first + i, meshes[i]);
      }
    });
    for (std::size_t i = 0; i < here; ++i) {
      if (auto problem = use(first + i, meshes[i])) {
        return problem;
      }
    }
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
