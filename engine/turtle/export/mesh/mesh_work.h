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

/// The work on meshes that are numbered from 0. Several threads do it:
/// - `make` and `spell` of several meshes at the same time, so these must not depend on other meshes;
/// - `number` of one mesh at a time, in order, and `use` too. `number` runs ahead of `use` and beside it: they share no
///   state.
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

/// Does the work on `count` meshes. The output does not depend on the threads: while one thread uses a mesh, the others
/// make the next. About 32 MB of meshes and bytes wait for the thread that uses them, or 16 meshes of each thread; with
/// one thread 8 meshes are in memory. Stops at a sentence, which is returned: the first of the meshes in their order.
/// Throws what the work throws; when several threads fail, it is not determined which failure ends the work.
[[nodiscard]] std::optional<std::string> forMeshes(core::WorkerTeam& team, std::size_t count, const MeshWork& work);

}  // namespace espalier::turtle
