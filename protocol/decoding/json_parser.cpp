#include "protocol/decoding/json_parser.h"

#include <utility>
#include <vector>

#include "protocol/json_text.h"

namespace espalier::protocol {
namespace {

/// Deepest nesting of brackets outside strings: checked before parsing, so that no recursion can run out of stack.
std::size_t nestingOf(std::string_view json) {
  std::size_t depth = 0;
  std::size_t deepest = 0;
  bool isInText = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (isInText) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        isInText = false;
      }
    } else if (c == '"') {
      isInText = true;
    } else if (c == '[' || c == '{') {
      deepest = ++depth > deepest ? depth : deepest;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

/// A text of a peer as an error quotes it: whole, or its beginning.
std::string shortened(std::string_view text) {
  const std::string_view beginning = beginningOf(text, 300);
  return std::string(beginning) + (beginning.size() < text.size() ? "..." : "");
}

/// Destroys what arrays and objects have, the innermost first. Its depth is that of the nesting, which is bounded.
void makeEmpty(nlohmann::json& value) noexcept {
  if (auto* const array = value.get_ptr<nlohmann::json::array_t*>()) {
    for (nlohmann::json& element : *array) {
      makeEmpty(element);
    }
    array->clear();
  } else if (auto* const object = value.get_ptr<nlohmann::json::object_t*>()) {
    for (auto& [name, member] : *object) {
      makeEmpty(member);
    }
    object->clear();
  }
}

/// Builds the tree of a message, called by nlohmann::json::sax_parse. Refuses an object that has a name twice: readers
/// would disagree about which value counts.
class TreeBuilder {
 public:
  bool null() { return put(nullptr); }
  bool boolean(bool value) { return put(value); }
  bool number_integer(nlohmann::json::number_integer_t value) { return put(value); }
  bool number_unsigned(nlohmann::json::number_unsigned_t value) { return put(value); }
  bool number_float(nlohmann::json::number_float_t value, const std::string&) { return put(value); }
  bool string(std::string& value) { return put(std::move(value)); }
  bool binary(nlohmann::json::binary_t&) { return false; }  // JSON has none
  bool start_object(std::size_t) { return open(nlohmann::json::object()); }
  bool start_array(std::size_t) { return open(nlohmann::json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }
  bool key(std::string& name) {
    auto& object = open_.back()->get_ref<nlohmann::json::object_t&>();
    const auto [place, isNew] = object.try_emplace(std::move(name), nullptr);
    if (!isNew) {
      repeatedName_ = shortened(place->first);
      return false;
    }
    place_ = &place->second;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& exception) {
    problem_ = parserMessage(exception);
    return false;
  }

  [[nodiscard]] JsonTree take() { return std::move(root_); }
  [[nodiscard]] const std::string& problem() const { return problem_; }
  /// When it was refused without a problem.
  [[nodiscard]] const std::string& repeatedName() const { return repeatedName_; }

 private:
  template <typename T>
  bool put(T&& value) {
    *nextPlace() = std::forward<T>(value);
    return true;
  }
  bool open(nlohmann::json value) {
    nlohmann::json* const place = nextPlace();
    *place = std::move(value);
    open_.push_back(place);
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }
  nlohmann::json* nextPlace() {
    if (!open_.empty() && open_.back()->is_array()) {
      return &open_.back()->get_ref<nlohmann::json::array_t&>().emplace_back();
    }
    return place_;
  }

  JsonTree root_;
  nlohmann::json* place_ = &root_.value;  // of the next value, unless it is an element
  std::vector<nlohmann::json*> open_;     // objects and arrays around, outermost first
  std::string problem_;
  std::string repeatedName_;
};

}  // namespace

JsonTree::~JsonTree() {
  makeEmpty(value);
}

bool isNestedTooDeeply(std::string_view json) {
  return nestingOf(json) > kDeepestNesting;
}

std::string parserMessage(const nlohmann::json::exception& exception) {
  const std::string_view text = exception.what();
  const std::size_t bracket = text.find("] ");
  return shortened(bracket == std::string_view::npos ? text : text.substr(bracket + 2));
}

tl::expected<JsonTree, JsonFault> parseTree(std::string_view text) {
  if (isNestedTooDeeply(text)) {
    return tl::unexpected(JsonFault{JsonFault::Kind::TooDeep, {}});
  }
  TreeBuilder builder;
  if (nlohmann::json::sax_parse(text, &builder)) {
    return builder.take();
  }
  return tl::unexpected(builder.problem().empty() ? JsonFault{JsonFault::Kind::RepeatedName, builder.repeatedName()}
                                                  : JsonFault{JsonFault::Kind::NotJson, builder.problem()});
}

Expected<JsonTree> parseJson(std::string_view text) {
  auto tree = parseTree(text);
  if (tree) {
    return std::move(*tree);
  }
  switch (tree.error().kind) {
    case JsonFault::Kind::TooDeep:
      return tl::unexpected(
          Error{ErrorCode::Parse,
                "The message nests brackets deeper than " + std::to_string(kDeepestNesting) + ". Send flatter JSON.",
                {}});
    case JsonFault::Kind::RepeatedName:
      return tl::unexpected(
          Error{ErrorCode::InvalidRequest,
                "An object of the message has '" + tree.error().what + "' twice. Send each name once.",
                {}});
    case JsonFault::Kind::NotJson:
      break;
  }
  return tl::unexpected(Error{ErrorCode::Parse,
                              "The line is not JSON: " + tree.error().what +
                                  ". Send one JSON object per line, in UTF-8; NaN and Infinity are not JSON numbers.",
                              {}});
}

}  // namespace espalier::protocol
