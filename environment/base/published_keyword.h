#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "environment/base/configuration.h"
#include "environment/base/published_text.h"

namespace espalier::environment {

/// Words that switch a published keyword on.
inline constexpr std::array<std::string_view, 1> kOn{"on"};
inline constexpr std::array<std::string_view, 1> kYes{"yes"};
inline constexpr std::array<std::string_view, 2> kOnOrYes{"on", "yes"};

/// How a line `keyword: values` of a published specification file becomes a configuration key.
enum class PublishedKind : std::uint8_t {
  Number,   // the first number
  Numbers,  // the first `count` numbers; missing ones keep their default
  Switch,   // one of `onWords` switches it on and anything else off; or one of `offWords` off and anything else on
  Row,      // `count` numbers, added to the key's rows; a line with fewer is dropped
  Unused,   // accepted without effect: it chooses how the published program computes, not its result
  Own,      // a form of its own, read by PublishedKeyword::read
};

/// The input of PublishedKeyword::read: a line with its data rows, the folder's files, and the keys to set.
struct PublishedLineInput {
  const PublishedLine& line;
  std::span<const PublishedLine> all;     // the lines of the file
  std::span<const PublishedLine> before;  // those above `line`
  const std::string& file;                // of the specification: files it names lie beside it
  core::FileProvider& files;
  ConfigurationValues& values;
  std::string& dropped;  // the ignored part of the line: the end of a sentence whose subject is the keyword
};

/// One keyword of a process's published specification file.
struct PublishedKeyword {
  std::string_view keyword;  // exactly as in the file, without the colon
  PublishedKind kind = PublishedKind::Number;
  std::string_view key;  // of the configuration
  std::size_t count = 1;
  std::span<const std::string_view> onWords{};   // Switch: either these
  std::span<const std::string_view> offWords{};  // or these
  /// Own: sets keys from the line. Returns a sentence that says what is wrong with the line, or an empty text.
  std::string (*read)(const PublishedLineInput& input) = nullptr;
};

}  // namespace espalier::environment
