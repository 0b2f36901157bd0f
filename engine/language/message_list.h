#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/files/source_map.h"

namespace espalier::language {

/// Collects the messages of all phases about a preprocessed text and sorts them by their places.
class MessageList {
 public:
  void error(core::SourceRange range, std::string message, std::string hint = {}) {
    messages_.push_back({core::Severity::Error, range, std::move(message), std::move(hint)});
    ++errorCount_;
  }
  void warning(core::SourceRange range, std::string message, std::string hint = {}) {
    messages_.push_back({core::Severity::Warning, range, std::move(message), std::move(hint)});
  }
  [[nodiscard]] std::size_t errorCount() const { return errorCount_; }

  /// Removes the warnings: beside errors most of them are consequences.
  void dropWarnings() {
    std::erase_if(messages_, [](const Message& message) { return message.severity != core::Severity::Error; });
  }

  /// Removes the messages about the text from `offset` on.
  void dropFrom(std::uint32_t offset) {
    std::erase_if(messages_, [&](const Message& message) { return message.range.begin >= offset; });
  }

  /// Adds all messages to `list`, in the order of the text.
  void moveTo(core::DiagnosticList& list, const files::SourceMap& map);

 private:
  struct Message {
    core::Severity severity = core::Severity::Error;
    core::SourceRange range;
    std::string text;
    std::string hint;
  };
  std::vector<Message> messages_;
  std::size_t errorCount_ = 0;
};

}  // namespace espalier::language
