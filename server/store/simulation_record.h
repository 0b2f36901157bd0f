#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "protocol/messages.h"

namespace espalier::server {

/// With a snapshot, everything that is needed to make a simulation again.
struct SimulationRecord {
  std::string id;
  std::string owner{};  // the account that it counts for; not in the text
  std::uint64_t seed = 0;
  bool hasSeed = false;           // given by the caller: replaces the model's
  protocol::CreateParams create;  // as asked for; its model is in the snapshot
};

/// The record in the form of the request that makes it, so one decoder reads both.
[[nodiscard]] std::string toText(const SimulationRecord& record);

/// Reads the text of toText(), or says what is wrong with it.
[[nodiscard]] tl::expected<SimulationRecord, std::string> toRecord(const std::string& id, std::string_view text);

}  // namespace espalier::server
