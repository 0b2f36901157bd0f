#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/core/number_text.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The texts of numbers that were written lately. The parameters of a plant repeat: angles, ages, the lengths of equal
/// organs. One thread uses it, for numbers of one style.
class NumberTexts {
 public:
  explicit NumberTexts(core::NumberStyle style) : style_(style) {}
  /// Does what core::writeNumber does.
  [[nodiscard]] char* write(char* out, double value);

 private:
  static constexpr unsigned kIndexBits = 10;
  /// The text "0" of the number 0, which has the same text in all styles, until another number takes the entry.
  struct Entry {
    std::uint64_t bits = 0;  // of the number
    std::array<char, 23> text{'0'};
    std::uint8_t size = 1;
  };
  core::NumberStyle style_;
  std::vector<Entry> entries_ = std::vector<Entry>(std::size_t{1} << kIndexBits);  // by a hash of the bits
};

/// How the modules of a Program are spelled: a table of the names by module type. The Program must outlive it. Several
/// threads may use it.
class ModuleSpelling {
 public:
  explicit ModuleSpelling(const language::Program& program);

  /// The bytes that the text of so many modules and parameters has at most.
  [[nodiscard]] std::size_t mostBytes(std::size_t moduleCount, std::size_t parameterCount) const {
    return moduleCount * (longestName_ + 2) + parameterCount * (core::kMostNumberBytes + 1) + kNameBytes;
  }
  /// Writes the text of modules to `out`, which has room for mostBytes(). Returns its end.
  [[nodiscard]] char* write(char* out, std::span<const core::ModuleTypeId> types, std::span<const double> parameters,
                            NumberTexts& numbers) const;

 private:
  static constexpr std::size_t kNameBytes = 16;
  struct Name {
    std::array<char, kNameBytes> text{};  // its beginning; with parameters followed by a parenthesis
    std::uint32_t size = 0;               // with the parenthesis; above kNameBytes: `text` does not hold it
    std::uint32_t arity = 0;
  };

  char* writeBytes(char* out, std::span<const core::ModuleTypeId> types) const;
  char* writeName(char* out, core::ModuleTypeId type) const;

  const language::Program* program_;
  std::vector<Name> names_;  // by module type
  std::vector<char> bytes_;  // by module type: its name; empty unless all types without parameters have names of a byte
  std::vector<std::array<char, 2>> pairs_;  // the same of two modules, at [first | second << pairShift_]; may be empty
  unsigned pairShift_ = 0;
  std::size_t longestName_ = 0;
};

}  // namespace espalier::derivation
