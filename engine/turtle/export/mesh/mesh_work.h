#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "engine/core/worker_team.h"
#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::turtle {

/// The work on meshes that are numbered from 0. `make` and `spell` must not depend on other meshes: several threads
/// do them at the same time. `number` and `use` take one mesh at a time, in order, on any of the threads.
struct MeshWork {
  /// Makes a mesh that was cleared. Returns a sentence when files cannot hold the mesh.
  std::function<std::optional<std::string>(std::size_t, Mesh&)> make;
  /// In order, and quick: a number that `spell` gets, such as that of the first vertex. Null: 0.
  std::function<std::uint64_t(std::size_t, const Mesh&)> number = {};
  /// Appends the bytes of a file. Null: none.
  std::function<void(std::size_t, const Mesh&, std::uint64_t number, std::string& bytes)> spell = {};
  /// In order: takes a mesh and its bytes. Returns a sentence to stop.
  std::function<std::optional<std::string>(std::size_t, const Mesh&, std::string_view bytes)> use;
};

/// Does the work on `count` meshes, of which some hundreds are in memory at a time: the output does not depend on the
/// threads. While one thread uses a mesh, the others make the next. Stops at the first sentence, which is returned.
/// Throws what the work throws.
[[nodiscard]] std::optional<std::string> forMeshes(core::WorkerTeam& team, std::size_t count, const MeshWork& work);

}  // namespace espalier::turtle
