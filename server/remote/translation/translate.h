#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/simulation_error.h"
#include "engine/core/vec3.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/scene/scene.h"
#include "protocol/messages.h"

namespace espalier::protocol {
struct Error;
}

namespace espalier::server {

// The only crossing between the protocol's structs and the engine's types.

[[nodiscard]] core::Vec3 toVec3(const std::array<double, 3>& numbers);

[[nodiscard]] protocol::DiagnosticRecord toRecord(const core::Diagnostic& diagnostic);
[[nodiscard]] std::vector<protocol::DiagnosticRecord> toRecords(const std::vector<core::Diagnostic>& diagnostics);
/// A failure of a simulation as an error of the wire. `data` has the last completed step, plant, module, place and
/// whether it can be tried again; the limit by its name on the wire, with its bound among `limits`; the simulation's
/// environments for an error of theirs.
[[nodiscard]] protocol::Error toError(const core::SimulationError& error, std::uint64_t completedSteps,
                                      const core::Limits& limits, const std::vector<std::string>& environment = {});
/// A model that does not compile: all diagnostics in `data`.
[[nodiscard]] protocol::Error toError(const std::vector<core::Diagnostic>& diagnostics);

[[nodiscard]] protocol::Statistics toStatistics(const simulation::StepStatistics& statistics, double milliseconds);

[[nodiscard]] protocol::DescribeResult toDescribeResult(const turtle::EnvironmentDescription& description);
[[nodiscard]] turtle::EnvironmentDescription toDescription(const protocol::DescribeResult& result);
[[nodiscard]] protocol::NeedsRecord toNeeds(const turtle::EnvironmentNeeds& needs);

[[nodiscard]] protocol::OpenParams toOpenParams(const turtle::EnvironmentContext& context,
                                                const std::string& configurationJson);
/// The error is a sentence about the world.
[[nodiscard]] tl::expected<turtle::EnvironmentContext, std::string> toContext(const protocol::OpenParams& params);
/// The error names the member, or the line of the weather's table.
[[nodiscard]] tl::expected<turtle::World, std::string> toWorld(const protocol::WorldRecord& record);

/// The origins of plants; they choose among `models` by name. Without plants: none.
[[nodiscard]] std::vector<simulation::PlantOrigin> plantOrigins(const std::vector<protocol::NamedModel>& models,
                                                                const std::vector<protocol::PlantParams>& plants);
[[nodiscard]] simulation::SeedRules seedRules(const protocol::SeedParams& seeds);

/// "cpfg", "cpfg-batch" or empty.
[[nodiscard]] core::Compatibility toCompatibility(const std::string& name);

}  // namespace espalier::server
