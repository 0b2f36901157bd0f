#include "engine/turtle/export/mesh/mesh_rounds.h"

#include <algorithm>
#include <vector>

namespace espalier::turtle {

namespace {

constexpr std::size_t kTaskMeshes = 8;
// A round holds few: the memory that it touches is used again by the next, and stays in the cache.
constexpr std::size_t kRoundTasksPerThread = 16;

/// Meshes that one thread makes and spells one after the other.
struct MeshTask {
  std::size_t first = 0;
  std::vector<Mesh> meshes = std::vector<Mesh>(kTaskMeshes);  // the first `count` of them
  std::size_t count = 0;
  std::vector<std::uint64_t> numbers;                // by mesh
  std::vector<std::optional<std::string>> problems;  // by mesh
  std::string bytes;                                 // of all meshes
  std::vector<std::size_t> ends;                     // in `bytes`, by mesh

  void make(const MeshWork& work) {
    problems.clear();
    for (std::size_t k = 0; k < count; ++k) {
      meshes[k].clear();
      problems.push_back(work.make(first + k, meshes[k]));
    }
  }

  void number(const MeshWork& work) {
    numbers.assign(count, 0);
    for (std::size_t k = 0; work.number && k < count && !problems[k]; ++k) {
      numbers[k] = work.number(first + k, meshes[k]);
    }
  }

  void spell(const MeshWork& work) {
    bytes.clear();
    ends.assign(count, 0);
    for (std::size_t k = 0; work.spell && k < count && !problems[k]; ++k) {
      work.spell(first + k, meshes[k], numbers[k], bytes);
      ends[k] = bytes.size();
    }
  }

  [[nodiscard]] std::optional<std::string> use(const MeshWork& work) const {
    std::size_t begin = 0;
    for (std::size_t k = 0; k < count; ++k) {
      if (problems[k]) {
        return problems[k];
      }
      if (auto problem = work.use(first + k, meshes[k], std::string_view(bytes).substr(begin, ends[k] - begin))) {
        return problem;
      }
      begin = ends[k];
    }
    return std::nullopt;
  }
};

}  // namespace

std::optional<std::string> forMeshes(core::WorkerTeam& team, std::size_t count, const MeshWork& work) {
  // one thread takes one task after the other
  const std::size_t roundMeshes = kTaskMeshes * (team.size() == 1 ? 1 : team.size() * kRoundTasksPerThread);
  std::vector<MeshTask> tasks((std::min(count, roundMeshes) + kTaskMeshes - 1) / kTaskMeshes);
  for (std::size_t first = 0; first < count; first += roundMeshes) {
    const std::size_t end = std::min(count, first + roundMeshes);
    const std::size_t taskCount = (end - first + kTaskMeshes - 1) / kTaskMeshes;
    for (std::size_t task = 0; task < taskCount; ++task) {
      tasks[task].first = first + task * kTaskMeshes;
      tasks[task].count = std::min(kTaskMeshes, end - tasks[task].first);
    }
    team.forEach(taskCount, [&](std::size_t task) { tasks[task].make(work); });
    for (std::size_t task = 0; task < taskCount; ++task) {
      tasks[task].number(work);
    }
    if (work.spell) {
      team.forEach(taskCount, [&](std::size_t task) { tasks[task].spell(work); });
    }
    for (std::size_t task = 0; task < taskCount; ++task) {
      if (!work.spell) {
        tasks[task].ends.assign(tasks[task].count, 0);
      }
      if (auto problem = tasks[task].use(work)) {
        return problem;
      }
    }
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
