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
  void moveTo(core::DiagnosticList& list, const files::SourceMap& map) {
    std::stable_sort(messages_.begin(), messages_.end(),
                     [](const Message& a, const Message& b) { return a.range.begin < b.range.begin; });
    // the parser cannot understand a line that could not be preprocessed
    const std::vector<core::Diagnostic> earlier = list.entries();
    const auto isExplained = [&](const core::SourceLocation& place) {
      return std::any_of(earlier.begin(), earlier.end(), [&](const core::Diagnostic& diagnostic) {
        return diagnostic.severity == core::Severity::Error && place.line > 0 &&
               diagnostic.location.line == place.line && diagnostic.location.file == place.file;
      });
    };
    std::size_t errors = 0;
    std::size_t warnings = 0;
    for (Message& message : messages_) {
      // finding a place takes a walk through its file, and the list keeps only its limit of each severity
      const std::size_t rank = message.severity == core::Severity::Error ? errors++ : warnings++;
      core::SourceLocation place =
          rank < core::DiagnosticList::kLimit ? map.locate(message.range) : core::SourceLocation{};
      if (!isExplained(place)) {
        list.add({message.severity, std::move(message.text), std::move(place), std::move(message.hint)});
      }
    }
    messages_.clear();
  }

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
