#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::files {

/// The origin of every byte of preprocessed text, through includes and macro expansions.
class SourceMap {
 public:
  struct File {
    File() = default;
    File(std::string fileName, std::string fileText);

    std::string name;
    std::string text;                       // as read
    std::vector<std::uint32_t> lineBegins;  // offset of each line in it
  };
  /// A run of output bytes: a copy of consecutive bytes of one file, or the whole expansion of one macro use.
  struct Segment {
    std::uint32_t outputBegin = 0;           // segments are sorted by it and cover the text without gaps
    std::uint32_t file = 0;                  // index into files
    std::uint32_t fileOffset = 0;            // of the first byte; for an expansion: of the macro's use
    std::uint32_t expansion = kNoExpansion;  // index into expansions
  };
  struct Expansion {
    std::string macro;
    std::uint32_t file = 0;  // where the macro was defined; kNoExpansion: on the command line
    std::uint32_t definitionOffset = 0;
    std::uint32_t useLength = 1;  // bytes of the use (name and arguments)
  };
  static constexpr std::uint32_t kNoExpansion = 0xFFFFFFFF;

  std::vector<File> files;
  std::vector<Segment> segments;
  std::vector<Expansion> expansions;

  /// The place of a range of preprocessed text; of its first byte when it spans several segments. O(log segments +
  /// log lines).
  [[nodiscard]] core::SourceLocation locate(core::SourceRange range) const;
};

/// The place of `length` bytes at `offset` of a file; the end of the file when the offset is beyond it. O(log lines +
/// length of the line).
[[nodiscard]] core::SourceLocation locateInFile(const SourceMap::File& file, std::uint32_t offset,
                                                std::uint32_t length);

}  // namespace espalier::files
