#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

#include "engine/core/worker_team.h"
#include "engine/turtle/export/mesh/mesh.h"

namespace espalier::turtle {

/// Makes the meshes 0 to count - 1 with several threads, a round of some thousands at a time, and hands them over in
/// order on the calling thread: the output does not depend on the threads. `make` gets a cleared mesh and must be
/// thread-safe. Stops at the first sentence that `use` returns and returns it.
[[nodiscard]] std::optional<std::string> forMeshes(
    core::WorkerTeam& team, std::size_t count, const std::function<void(std::size_t, Mesh&)>& make,
    const std::function<std::optional<std::string>(std::size_t, const Mesh&)>& use);

}  // namespace espalier::turtle
