#include "engine/derivation/string_text.h"

#include "engine/core/hash.h"

namespace espalier::derivation {

void appendText(std::string& text, const language::Program& program, const ModuleString& string,
                core::NumberStyle style) {
  const std::span<const double> parameters = string.parameters();
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    text.append(program.nameOf(type));
    const std::size_t arity = program.arity[type];
    for (std::size_t i = 0; i < arity; ++i) {
      text.push_back(i == 0 ? '(' : ',');
      core::appendNumber(text, parameters[offset + i], style);
    }
    if (arity > 0) {
      text.push_back(')');
    }
    offset += arity;
  }
}

std::string toText(const language::Program& program, const ModuleString& string, core::NumberStyle style) {
  std::string text;
  appendText(text, program, string, style);
  return text;
}

core::NumberStyle numberStyle(core::Compatibility compatibility) {
  return compatibility == core::Compatibility::Espalier ? core::NumberStyle::Shortest : core::NumberStyle::PercentG;
}

std::uint64_t hashOf(const language::Program& program, const ModuleString& string) {
  core::Hasher hasher;
  for (const core::ModuleTypeId type : string.types()) {
    hasher.bytes(program.nameOf(type));
    hasher.integer(program.arity[type]);
  }
  for (const double parameter : string.parameters()) {
    hasher.number(parameter);
  }
  return hasher.value();
}

}  // namespace espalier::derivation
