#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "protocol/envelope.h"
#include "protocol/messages.h"

namespace espalier::protocol {

/// A message of many queries or replies, read in one pass without a tree in between.
struct BulkText {
  std::shared_ptr<const void> owner;  // of the text
  std::string_view json;              // params or result as they came
  std::optional<EnvironmentStepParams> step;
  std::optional<ReplyColumns> replies;
};

/// Reads environment.step and its answer as text several times faster than the tree does. Whatever is unusual about a
/// line (other methods, other fields, an error anywhere) is left to decodeMessage, which knows how to say it: for every
/// line that this class reads, the tree gives the same. Keeps memory for the longest line read.
class BulkTextReader {
 public:
  /// Lines below it are left to the tree.
  static constexpr std::size_t kLeastBytes = 4'096;

  BulkTextReader();
  ~BulkTextReader();
  BulkTextReader(BulkTextReader&&) noexcept;
  BulkTextReader& operator=(BulkTextReader&&) noexcept;

  [[nodiscard]] std::optional<Message> read(std::string_view line);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;  // made with the first long line
};

}  // namespace espalier::protocol
