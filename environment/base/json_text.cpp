#include "environment/base/json_text.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <vector>

#include "engine/core/work_meter.h"
#include "environment/base/number_text.h"

namespace espalier::environment {

namespace {

using nlohmann::json;

core::SourceLocation locate(std::string_view text, std::size_t offset, const std::string& file) {
  offset = std::min(offset, text.size());
  const std::string_view before = text.substr(0, offset);
  const std::size_t newline = before.rfind('\n');
  const std::size_t lineBegin = newline == std::string_view::npos ? 0 : newline + 1;
  core::SourceLocation location;
  location.file = file;
  location.line = 1;
  for (const char c : before) {
    location.line += c == '\n' ? 1U : 0U;
  }
  location.column = static_cast<std::uint32_t>(offset - lineBegin + 1);
  location.lineText = std::string(text.substr(lineBegin, text.find('\n', lineBegin) - lineBegin));
  return location;
}

/// The library's sentence without its own prefix and position: "[json.exception...] parse error at line 1, column 9:
/// syntax error while parsing value - unexpected ']'; expected ..." gives "unexpected ']'; expected ...".
std::string reasonOf(std::string_view what) {
  const std::size_t dash = what.find(" - ");
  std::string reason(dash == std::string_view::npos ? what.substr(what.find("] ") + 2) : what.substr(dash + 3));
  return reason;
}

/// Looks at a text before it is parsed: for an object that has a name twice, and for nesting so deep that the library,
/// which copies and writes by recursion, would overflow the stack. The library's parser with a callback would find
/// both, but it takes a time that grows with the square of an array's length.
class NameWatch final : public json::json_sax_t {
 public:
  static constexpr std::size_t kGreatestDepth = 200;

  bool null() override { return look(); }
  bool boolean(bool) override { return look(); }
  bool number_integer(json::number_integer_t) override { return look(); }
  bool number_unsigned(json::number_unsigned_t) override { return look(); }
  bool number_float(json::number_float_t, const std::string&) override { return look(); }
  bool string(std::string&) override { return look(); }
  bool binary(json::binary_t&) override { return false; }  // JSON has none
  bool start_object(std::size_t) override { return open(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override {
    if (!names_.back().insert(name).second) {
      duplicate_ = name;
    }
    return look();
  }
  bool parse_error(std::size_t, const std::string&, const json::exception&) override { return false; }

  [[nodiscard]] bool isTooDeep() const { return names_.size() > kGreatestDepth; }
  /// The last name that an object has twice.
  [[nodiscard]] const std::optional<std::string>& duplicate() const { return duplicate_; }

 private:
  static bool look() {
    core::pollWork();
    return true;
  }
  bool open() {
    names_.emplace_back();
    return !isTooDeep();
  }
  bool close() {
    names_.pop_back();
    return look();
  }

  std::vector<std::set<std::string>> names_;  // seen in each open object; none in an array
  std::optional<std::string> duplicate_;
};

}  // namespace

tl::expected<json, core::Diagnostic> parseJson(std::string_view text, const std::string& file) {
  NameWatch watch;
  static_cast<void>(json::sax_parse(text.begin(), text.end(), &watch));
  core::Diagnostic diagnostic;
  if (watch.isTooDeep()) {
    diagnostic.message = "is nested more than " + std::to_string(NameWatch::kGreatestDepth) + " deep";
    diagnostic.location = locate(text, 0, file);
    return tl::unexpected(std::move(diagnostic));
  }
  try {
    json value = json::parse(text.begin(), text.end());
    if (!watch.duplicate()) {
      return value;
    }
    diagnostic.message = "has the key '" + *watch.duplicate() + "' twice";
    const std::size_t last = text.rfind("\"" + *watch.duplicate() + "\"");
    diagnostic.location = locate(text, last == std::string_view::npos ? 0 : last, file);
  } catch (const json::parse_error& error) {
    diagnostic.message = "is not valid JSON: " + reasonOf(error.what());
    diagnostic.location = locate(text, error.byte > 0 ? error.byte - 1 : 0, file);
  } catch (const json::exception& error) {
    diagnostic.message = "is not valid JSON: " + reasonOf(error.what());
    // of all others only a number that is too large comes from the text, and it is quoted
    const std::string_view what = error.what();
    const std::size_t quote = what.find('\'');
    const std::size_t end = quote == std::string_view::npos ? quote : what.find('\'', quote + 1);
    const std::size_t found = end == std::string_view::npos ? end : text.find(what.substr(quote + 1, end - quote - 1));
    diagnostic.location = locate(text, found == std::string_view::npos ? 0 : found, file);
  }
  return tl::unexpected(std::move(diagnostic));
}

std::string foundText(const json& value) {
  switch (value.type()) {
    case json::value_t::null:
      return "null";
    case json::value_t::object:
      return "an object";
    case json::value_t::array:
      return "a list";
    case json::value_t::string:
      return "the text '" + value.get<std::string>() + "'";
    case json::value_t::boolean:
      return value.get<bool>() ? "true" : "false";
    case json::value_t::number_integer:
    case json::value_t::number_unsigned:
    case json::value_t::number_float:
      return "the number " + numberText(value.get<double>());
    case json::value_t::binary:
    case json::value_t::discarded:
      break;
  }
  return "something else";
}

}  // namespace espalier::environment
