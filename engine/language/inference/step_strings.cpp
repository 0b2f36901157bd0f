#include "engine/language/inference/step_strings.h"

#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "engine/files/utf8.h"

namespace espalier::language {
namespace {

constexpr std::size_t kMostSymbols = 65535;

class StepStringsReader {
 public:
  StepStringsReader(const std::string& fileName, core::DiagnosticList& diagnostics)
      : fileName_(fileName), diagnostics_(diagnostics) {}

  StepStrings read(std::string_view text) {
    text = files::withoutByteOrderMark(text);
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      ++line_;
      readLine(text.substr(0, end));
      text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    }
    if (result_.strings.size() < 2 && !diagnostics_.hasErrors()) {
      fail(
          {}, 0, 0,
          result_.strings.empty() ? "there is no string in this file" : "one string is not enough to infer productions",
          "write the strings of successive steps, one a line, as `espalier derive MODEL.l --every` prints them");
    }
    return std::move(result_);
  }

 private:
  void readLine(std::string_view line) {
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    const std::size_t tab = line.find('\t');
    std::uint64_t number = 0;
    const bool hasNumber = tab != std::string_view::npos && tab > 0 &&
                           std::from_chars(line.data(), line.data() + tab, number).ptr == line.data() + tab;
    if (line.find_first_not_of(" \t") == std::string_view::npos) {
      return;
    }
    if (hasNumber) {
      if (nextNumber_ && number != *nextNumber_) {
        fail(line, 0, tab, "step " + std::to_string(number) + " follows step " + std::to_string(*nextNumber_ - 1),
             "the strings of successive steps are needed: each step is derived from the previous one");
      }
      nextNumber_ = number + 1;
    }
    readString(line, hasNumber ? tab + 1 : 0);
  }

  void readString(std::string_view line, std::size_t at) {
    std::vector<std::uint16_t> symbols;
    std::vector<std::size_t> open;  // where brackets wait for their partner
    while (at < line.size()) {
      std::size_t length = files::sequenceLength(line.substr(at));
      if (length == 0) {
        fail(line, at, 1, "this is not UTF-8 text", "save the file as UTF-8");
        return;
      }
      if (line[at] == '(' || line[at] == ')') {
        fail(line, at, 1, std::string("a '") + line[at] + "' without its module",
             "parameters are written behind a symbol and closed, as in /(180)");
        return;
      }
      if (line[at] == '[') {
        open.push_back(at);
      } else if (line[at] == ']' && open.empty()) {
        warn(line, at, "the bracket ']' closes nothing in this string");
      } else if (line[at] == ']') {
        open.pop_back();
      }
      if (line[at] != ' ' && line[at] != '\t') {
        // parameters belong to their symbol
        if (at + length < line.size() && line[at + length] == '(') {
          const std::size_t end = line.find(')', at + length);
          length = end == std::string_view::npos ? length : end + 1 - at;
        }
        symbols.push_back(symbolCalled(std::string(line.substr(at, length)), line, at));
      }
      at += length;
    }
    for (const std::size_t bracket : open) {
      warn(line, bracket, "the bracket '[' is never closed in this string");
    }
    result_.strings.push_back(std::move(symbols));
  }

  std::uint16_t symbolCalled(const std::string& name, std::string_view line, std::size_t at) {
    const auto [entry, isNew] = numbers_.try_emplace(name, static_cast<std::uint16_t>(result_.names.size()));
    if (isNew) {
      if (result_.names.size() >= kMostSymbols) {
        fail(line, at, 1, "more than " + std::to_string(kMostSymbols) + " different symbols", "");
        return 0;
      }
      result_.names.push_back(name);
    }
    return entry->second;
  }

  void warn(std::string_view line, std::size_t at, std::string message) {
    add(core::Severity::Warning, line, at, 1, std::move(message),
        "brackets without a partner are symbols like others, not branches");
  }

  void fail(std::string_view line, std::size_t at, std::size_t length, std::string message, std::string hint) {
    add(core::Severity::Error, line, at, length, std::move(message), std::move(hint));
  }

  void add(core::Severity severity, std::string_view line, std::size_t at, std::size_t length, std::string message,
           std::string hint) {
    core::Diagnostic diagnostic;
    diagnostic.severity = severity;
    diagnostic.message = std::move(message);
    diagnostic.hint = std::move(hint);
    diagnostic.location.file = fileName_;
    if (length > 0) {
      diagnostic.location.line = line_;
      diagnostic.location.column = static_cast<std::uint32_t>(at + 1);
      diagnostic.location.length = static_cast<std::uint32_t>(length);
      diagnostic.location.lineText = std::string(line);
    }
    diagnostics_.add(std::move(diagnostic));
  }

  const std::string& fileName_;
  core::DiagnosticList& diagnostics_;
  StepStrings result_;
  std::map<std::string, std::uint16_t> numbers_;
  std::optional<std::uint64_t> nextNumber_;
  std::uint32_t line_ = 0;
};

}  // namespace

std::string StepStrings::text(const std::vector<std::uint16_t>& symbols) const {
  std::string result;
  for (const std::uint16_t symbol : symbols) {
    result += names[symbol];
  }
  return result;
}

StepStrings readStepStrings(const std::string& fileName, std::string_view text, core::DiagnosticList& diagnostics) {
  return StepStringsReader(fileName, diagnostics).read(text);
}

}  // namespace espalier::language
