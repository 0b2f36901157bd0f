#include "clients/espalier/json_place.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>

namespace espalier::command {
namespace {

/// Walks through a text that is known to be JSON; in any other text it stops at the end.
class JsonWalk {
 public:
  explicit JsonWalk(std::string_view text) : text_(text) {}

  [[nodiscard]] std::size_t position() const { return at_; }

  // moves from a value to its member, and returns the place of the member's name
  std::optional<std::size_t> enter(std::string_view name) {
    if (!take('{')) {
      return std::nullopt;
    }
    while (next() == '"') {
      const std::size_t begin = at_;
      skipString();
      const bool isWanted = text_.substr(begin + 1, at_ - begin - 2) == name;
      take(':');
      skipBlanks();
      if (isWanted) {
        return begin;
      }
      skipValue();
      take(',');
    }
    return std::nullopt;
  }

  // moves from a list to its element
  std::optional<std::size_t> enter(std::size_t index) {
    if (!take('[')) {
      return std::nullopt;
    }
    for (; next() != ']' && at_ < text_.size(); --index) {
      if (index == 0) {
        return at_;
      }
      skipValue();
      take(',');
    }
    return std::nullopt;
  }

  void skipBlanks() { at_ = std::min(text_.find_first_not_of(" \t\r\n", at_), text_.size()); }

 private:
  char next() {
    skipBlanks();
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool take(char c) {
    const bool isThere = next() == c;
    at_ += isThere ? 1 : 0;
    return isThere;
  }
  void skipString() {
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      at_ += text_[at_] == '\\' ? 1 : 0;
    }
    at_ = std::min(at_ + 1, text_.size());
  }
  // to the comma or bracket behind it
  void skipValue() {
    std::size_t depth = 0;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (depth == 0 && (c == ',' || c == ']' || c == '}')) {
        return;
      }
      depth += c == '[' || c == '{' ? 1 : 0;
      depth -= c == ']' || c == '}' ? 1 : 0;
      if (c == '"') {
        skipString();
      } else {
        ++at_;
      }
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// the offset of the part that the path names, as far as the text has it
std::size_t offsetOf(std::string_view text, std::string_view path) {
  JsonWalk walk(text);
  walk.skipBlanks();
  std::size_t found = walk.position();
  while (!path.empty()) {
    std::optional<std::size_t> place;
    if (path.front() == '[') {
      std::size_t index = 0;
      const std::size_t end = std::min(path.find(']'), path.size() - 1);
      std::from_chars(path.data() + 1, path.data() + end, index);
      place = walk.enter(index);
      path.remove_prefix(end + 1);
    } else {
      path.remove_prefix(path.front() == '.' ? 1 : 0);
      const std::size_t end = std::min(path.find_first_of(".["), path.size());
      place = walk.enter(path.substr(0, end));
      path.remove_prefix(end);
    }
    if (!place) {
      break;
    }
    found = *place;
  }
  return found;
}

}  // namespace

std::string jsonPlace(std::string_view text, std::string_view path) {
  const std::size_t offset = offsetOf(text, path);
  if (offset >= text.size()) {
    return {};
  }
  const std::string_view before = text.substr(0, offset);
  const std::size_t newline = before.rfind('\n');
  const std::string_view line = newline == std::string_view::npos ? before : before.substr(newline + 1);
  const auto isCharacter = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; };
  return ":" + std::to_string(std::ranges::count(before, '\n') + 1) + ":" +
         std::to_string(std::ranges::count_if(line, isCharacter) + 1);
}

std::string jsonPlaceOfMessage(std::string_view text, const std::string& path, std::string_view message) {
  std::string object = jsonPlace(text, path);
  std::size_t open = message.find('\'');
  while (open != std::string_view::npos) {
    const std::size_t close = message.find('\'', open + 1);
    if (close == std::string_view::npos) {
      break;
    }
    const std::string member(message.substr(open + 1, close - open - 1));
    if (std::string place = jsonPlace(text, path.empty() ? member : path + "." + member); place != object) {
      return place;
    }
    open = message.find('\'', close + 1);
  }
  return object;
}

}  // namespace espalier::command
