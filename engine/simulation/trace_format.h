#pragma once

#include <string>
#include <string_view>

#include "engine/simulation/trace.h"

namespace espalier::simulation {

// The bytes of trace events. The layout is in FORMATS.md.

[[nodiscard]] std::string encodeStart(const std::string& snapshot, const turtle::EnvironmentDescription* description,
                                      const turtle::EnvironmentContext& context);
[[nodiscard]] std::string encodeStep(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies);
[[nodiscard]] std::string encodeTick(std::uint64_t step);
[[nodiscard]] std::string encodeFailure(std::uint64_t step, std::string_view message);
[[nodiscard]] std::string encodeComplete(const Simulation& simulation);

/// Reads the content of an event; false when it is not an event.
[[nodiscard]] bool decodeEvent(std::string_view content, TraceEvent& event);

/// A check over the replies to one query.
[[nodiscard]] std::uint32_t checkOfReply(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies,
                                         std::size_t query);

/// Hashes of a plant's string in pieces of kTracePieceModules modules.
[[nodiscard]] std::vector<std::uint32_t> pieceHashesOf(const language::Program& program,
                                                       const derivation::ModuleString& string);

}  // namespace espalier::simulation
