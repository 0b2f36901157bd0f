#include "environment/base/json_text.h"

#include <nlohmann/json.hpp>
#include <set>
#include <vector>

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

}  // namespace

tl::expected<json, core::Diagnostic> parseJson(std::string_view text, const std::string& file) {
  std::vector<std::set<std::string>> names;  // keys seen in each open object
  std::string duplicate;
  const json::parser_callback_t watch = [&](int, json::parse_event_t event, json& value) {
    if (event == json::parse_event_t::object_start) {
      names.emplace_back();
    } else if (event == json::parse_event_t::object_end) {
      names.pop_back();
    } else if (event == json::parse_event_t::key && !names.back().insert(value.get<std::string>()).second) {
      duplicate = value.get<std::string>();
    }
    return true;
  };
  core::Diagnostic diagnostic;
  try {
    json value = json::parse(text.begin(), text.end(), watch);
    if (duplicate.empty()) {
      return value;
    }
    diagnostic.message = "has the key '" + duplicate + "' twice";
    const std::size_t last = text.rfind("\"" + duplicate + "\"");
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
