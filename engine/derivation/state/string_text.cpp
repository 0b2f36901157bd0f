#include "engine/derivation/state/string_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "engine/core/hash.h"
#include "engine/derivation/state/module_spelling.h"

namespace espalier::derivation {

namespace {

/// Reads modules one after the other.
class StringReader {
 public:
  StringReader(const language::Program& program, std::string_view text) : program_(program), text_(text) {
    for (const language::Symbol& symbol : program.symbols) {
      if (symbol.name.size() > 1) {
        longNames_.push_back(symbol.name);
      }
    }
    std::ranges::sort(longNames_, [](std::string_view a, std::string_view b) { return a.size() > b.size(); });
  }

  [[nodiscard]] tl::expected<ModuleString, std::string> read() {
    ModuleString string;
    for (skipBlanks(); position_ < text_.size(); skipBlanks()) {
      const std::size_t begin = position_;
      const std::string_view name = takeName();
      if (!takeParameters()) {
        return tl::unexpected(at(position_) + "expected a number, ',' or ')' in the parameters of '" +
                              std::string(name) + "'");
      }
      const core::ModuleTypeId type = typeOf(name);
      if (type == core::kNoModuleType) {
        return tl::unexpected(at(begin) + "the model has no module '" + std::string(name) + "' with " +
                              std::to_string(parameters_.size()) + " parameters" + otherCounts(name));
      }
      string.append(type, parameters_);
    }
    return string;
  }

 private:
  // the counts that the model has instead
  [[nodiscard]] std::string otherCounts(std::string_view name) const {
    std::string counts;
    for (const language::ModuleType& type : program_.types) {
      if (program_.symbols[type.symbol].name == name) {
        counts += (counts.empty() ? ", only with " : " or ") + std::to_string(type.arity);
      }
    }
    return counts.empty() ? ": only modules that occur in the model can be read" : counts;
  }

  void skipBlanks() {
    while (position_ < text_.size() &&
           (text_[position_] == ' ' || (text_[position_] >= '\t' && text_[position_] <= '\r'))) {
      ++position_;
    }
  }

  std::string_view takeName() {
    std::size_t length = 1;
    for (const std::string_view name : longNames_) {
      if (text_.substr(position_).starts_with(name)) {
        length = name.size();
        break;
      }
    }
    position_ += length;
    return text_.substr(position_ - length, length);
  }

  bool takeParameters() {
    parameters_.clear();
    if (position_ >= text_.size() || text_[position_] != '(') {
      return true;
    }
    do {
      ++position_;
      skipBlanks();
      double value = 0.0;
      const char* const end = text_.data() + text_.size();
      const auto result = std::from_chars(text_.data() + position_, end, value);
      if (result.ec != std::errc{} || !std::isfinite(value)) {
        return false;
      }
      position_ = static_cast<std::size_t>(result.ptr - text_.data());
      skipBlanks();
      parameters_.push_back(value);
    } while (position_ < text_.size() && text_[position_] == ',');
    if (position_ >= text_.size() || text_[position_] != ')') {
      return false;
    }
    ++position_;
    return true;
  }

  core::ModuleTypeId typeOf(std::string_view name) {
    const auto key = std::pair(name, parameters_.size());
    const auto known = types_.find(key);
    if (known != types_.end()) {
      return known->second;
    }
    const bool isArity = parameters_.size() <= std::numeric_limits<std::uint16_t>::max();
    const core::ModuleTypeId type =
        isArity ? program_.findType(name, static_cast<std::uint16_t>(parameters_.size())) : core::kNoModuleType;
    types_.emplace(key, type);
    return type;
  }

  // "3:17: "
  [[nodiscard]] std::string at(std::size_t position) const {
    const std::string_view before = text_.substr(0, position);
    const auto line = 1 + std::ranges::count(before, '\n');
    const std::size_t lineBegin = before.rfind('\n') + 1;
    return std::to_string(line) + ":" + std::to_string(position - lineBegin + 1) + ": ";
  }

  const language::Program& program_;
  std::string_view text_;
  std::size_t position_ = 0;
  std::vector<std::string_view> longNames_;  // longest first
  std::vector<double> parameters_;           // of the module that is read
  std::map<std::pair<std::string_view, std::size_t>, core::ModuleTypeId> types_;
};

}  // namespace

void appendText(std::string& text, const language::Program& program, const ModuleString& string,
                core::NumberStyle style) {
  constexpr std::size_t kPieceModules = 16'384;
  const ModuleSpelling spelling(program);
  NumberTexts numbers(style);
  core::Buffer<char> piece;
  std::size_t offset = 0;
  for (std::size_t begin = 0; begin < string.size(); begin += kPieceModules) {
    const auto types = string.types().subspan(begin, std::min<std::size_t>(kPieceModules, string.size() - begin));
    std::size_t parameterCount = 0;
    for (const core::ModuleTypeId type : types) {
      parameterCount += program.arity[type];
    }
    piece.resize(spelling.mostBytes(types.size(), parameterCount));
    const char* const first = piece.data();
    const char* const end =
        spelling.write(piece.data(), types, string.parameters().subspan(offset, parameterCount), numbers);
    if (begin == 0 && string.size() > kPieceModules) {
      // as if the other pieces were like this one: a text that grows is copied again and again
      const auto bytes = static_cast<std::size_t>(end - first);
      text.reserve(text.size() + bytes / 4 * 5 * (string.size() / kPieceModules + 1));
    }
    text.append(first, end);
    offset += parameterCount;
  }
}

std::string toText(const language::Program& program, const ModuleString& string, core::NumberStyle style) {
  std::string text;
  appendText(text, program, string, style);
  return text;
}

tl::expected<ModuleString, std::string> parseText(const language::Program& program, std::string_view text) {
  return StringReader(program, text).read();
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
