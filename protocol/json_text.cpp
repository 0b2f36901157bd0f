#include "protocol/json_text.h"

#include <simdjson.h>
#include <algorithm>

#include "protocol/decoding/json_parser.h"

namespace espalier::protocol {

std::optional<std::string> memberOf(std::string_view json, std::string_view name) {
  const auto parsed = parseJson(json);
  if (!parsed || !parsed->value.is_object()) {
    return std::nullopt;
  }
  const auto found = parsed->value.find(name);
  if (found == parsed->value.end()) {
    return std::nullopt;
  }
  return found->is_string() ? found->get<std::string>() : found->dump();
}

std::optional<std::map<std::string, std::string>> textsOf(std::string_view json, std::string_view name) {
  const auto parsed = parseJson(json);
  if (!parsed || !parsed->value.is_object()) {
    return std::nullopt;
  }
  const auto found = parsed->value.find(name);
  if (found == parsed->value.end() || !found->is_object()) {
    return std::nullopt;
  }
  std::map<std::string, std::string> texts;
  for (const auto& [key, value] : found->items()) {
    if (!value.is_string()) {
      return std::nullopt;
    }
    texts.emplace(key, value.get<std::string>());
  }
  return texts;
}

std::optional<std::vector<std::string>> listOf(std::string_view json, std::string_view name) {
  const auto parsed = parseJson(json);
  if (!parsed || !parsed->value.is_object()) {
    return std::nullopt;
  }
  const auto found = parsed->value.find(name);
  if (found == parsed->value.end() || !found->is_array()) {
    return std::nullopt;
  }
  std::vector<std::string> texts;
  for (const auto& value : *found) {
    if (!value.is_string()) {
      return std::nullopt;
    }
    texts.push_back(value.get<std::string>());
  }
  return texts;
}

bool isPlainText(std::string_view bytes) {
  return bytes.find('\0') == std::string_view::npos && simdjson::validate_utf8(bytes);
}

std::string_view beginningOf(std::string_view text, std::size_t mostBytes) {
  std::size_t end = std::min(text.size(), mostBytes);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) {
    --end;
  }
  return text.substr(0, end);
}

std::optional<std::string> jsonProblem(std::string_view json) {
  const auto tree = parseTree(json);
  if (tree) {
    return std::nullopt;
  }
  switch (tree.error().kind) {
    case JsonFault::Kind::TooDeep:
      return "brackets are nested deeper than " + std::to_string(kDeepestNesting);
    case JsonFault::Kind::RepeatedName:
      return "an object has '" + tree.error().what + "' twice";
    case JsonFault::Kind::NotJson:
      break;
  }
  return tree.error().what;
}

}  // namespace espalier::protocol
