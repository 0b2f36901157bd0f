#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "environment/base/configuration.h"
#include "environment/published/field_text.h"
#include "environment/registry.h"

namespace espalier::environment {

/// How a line `keyword: values` of the field's specification files becomes a configuration key.
enum class FieldKind : std::uint8_t {
  Number,   // the first number
  Numbers,  // the first `count` numbers
  Switch,   // true when the value is one of `onWords`, else false
  Row,      // a row of numbers, at most `count`, added to the key's rows
  Unused,   // chooses how the published program computes, not what: accepted, no key
  Own,      // a form of its own, read by FieldKeyword::read
};

/// A line with a form of its own: the line with its data rows, the folder's files, and where its keys go.
struct FieldLineInput {
  const FieldLine& line;
  const std::string& file;  // of the specification: files it names lie beside it
  core::FileProvider& files;
  ConfigurationValues& values;
};

struct FieldKeyword {
  std::string_view keyword;  // exactly as in the file, without the colon
  FieldKind kind = FieldKind::Number;
  std::string_view key;  // of the configuration
  std::size_t count = 1;
  std::span<const std::string_view> onWords{};
  /// Own: sets keys from the line; a sentence that says what is wrong with it, or nothing.
  std::string (*read)(const FieldLineInput& input) = nullptr;
};

/// Everything the registry knows about one process.
struct ProcessEntry {
  std::string_view name;
  std::string_view summary;  // one sentence
  std::string_view source;   // where the model was published
  std::span<const std::string_view> aliases;
  std::span<const ConfigurationKey> keys;
  std::span<const FieldKeyword> fieldKeywords;
  ProcessOrErrors (*make)(const Configuration& configuration);
};

/// The entry of a name or alias; null when unknown.
[[nodiscard]] const ProcessEntry* findProcess(std::string_view name);

/// "environment process 'chibba' is unknown. Did you mean 'chiba'? Available: chiba, clover."
[[nodiscard]] core::Diagnostic unknownProcess(std::string_view name);

}  // namespace espalier::environment
