#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>

#include "protocol/decoding/json_parser.h"
#include "protocol/messages.h"

namespace espalier::protocol {

// The content of a Payload. For protocol's own .cpp files only: the JSON library stays out of the other headers.

/// A message of many queries or replies, read in one pass without a tree.
struct BulkText {
  std::shared_ptr<const void> owner;  // of the text
  std::string_view json;              // params or result as they came
  std::optional<EnvironmentStepParams> step;
  std::optional<ReplyColumns> replies;
};

}  // namespace espalier::protocol
