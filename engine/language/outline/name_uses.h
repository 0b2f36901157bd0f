#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/files/source_map.h"
#include "engine/language/parsed_model.h"

namespace espalier::language {

/// The kind of a name in the text of a model.
enum class NameKind : std::uint8_t {
  Macro,
  Variable,       // of an L-system
  LocalVariable,  // of a production
  Parameter,      // of a predecessor or context module
  Array,
  Function,
  Module,
  Unknown,
};

/// A name in a file of a model.
struct NameUse {
  NameKind kind = NameKind::Unknown;
  std::string name;
  /// Uses of one kind and name with equal scopes mean the same thing.
  std::uint32_t scope = 0;
  std::uint32_t arity = 0;    // Module: the number of its parameters
  bool isDefinition = false;  // the place that a reader wants to see: a #define, an assignment, a predecessor
  bool isDeclared = false;    // Module: its name is from `Module:`, so it may have several letters
  bool isExpanded = false;    // a macro brings the name: the place is the use of that macro
  std::uint32_t file = 0;     // index into SourceMap::files
  std::uint32_t offset = 0;
  std::uint32_t length = 1;  // bytes

  /// Whether both mean the same thing. Modules with the same letter and different numbers of parameters do.
  [[nodiscard]] bool meansTheSameAs(const NameUse& other) const {
    return kind == other.kind && name == other.name && scope == other.scope;
  }
};

/// All names of a model, by file and offset. Names that the preprocessor leaves out are missing, except those of
/// macros.
[[nodiscard]] std::vector<NameUse> nameUses(const ParsedModel& model);

/// The definitions and uses of the model's macros in its files, also in parts that `#if` leaves out.
[[nodiscard]] std::vector<NameUse> macroUses(const files::SourceMap& map);

/// A macro that a file defines.
struct MacroDefinition {
  std::string name;
  std::string text;        // that replaces the name
  std::uint32_t file = 0;  // index into SourceMap::files
  std::uint32_t offset = 0;
  std::uint32_t textOffset = 0;  // of `text`; the text is as in the file unless a comment or line end was in it
  bool isFunctionLike = false;
};

/// In the order of files and offsets.
[[nodiscard]] std::vector<MacroDefinition> macroDefinitions(const files::SourceMap& map);

}  // namespace espalier::language
