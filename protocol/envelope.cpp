#include "protocol/envelope.h"

#include <utility>
#include <vector>

#include "protocol/bulk_text.h"
#include "protocol/json_tree.h"
#include "protocol/json_writer.h"

namespace espalier::protocol {
namespace {

constexpr std::size_t kDeepestNesting = 64;
constexpr std::size_t kLongestIdBytes = 200;

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

/// What the parser says, without its own exception numbers.
std::string parserMessage(const nlohmann::json::exception& exception) {
  std::string text = exception.what();
  const std::size_t bracket = text.find("] ");
  return bracket == std::string::npos ? text : text.substr(bracket + 2);
}

/// Builds the tree of a message and refuses objects that have a name twice: readers would disagree about which value
/// counts. What nlohmann::json::sax_parse calls.
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
      repeatedName_ = place->first;
      return false;
    }
    place_ = &place->second;
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& exception) {
    problem_ = parserMessage(exception);
    return false;
  }

  [[nodiscard]] nlohmann::json take() { return std::move(root_); }
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

  nlohmann::json root_;
  nlohmann::json* place_ = &root_;     // of the next value, unless it is an element
  std::vector<nlohmann::json*> open_;  // objects and arrays around, outermost first
  std::string problem_;
  std::string repeatedName_;
};

std::variant<nlohmann::json, Error> parse(std::string_view text) {
  if (nestingOf(text) > kDeepestNesting) {
    return Error{ErrorCode::Parse,
                 "The message nests brackets deeper than " + std::to_string(kDeepestNesting) + ". Send flatter JSON.",
                 {}};
  }
  TreeBuilder builder;
  if (nlohmann::json::sax_parse(text, &builder)) {
    return builder.take();
  }
  if (builder.problem().empty()) {
    return Error{ErrorCode::InvalidRequest,
                 "An object of the message has '" + builder.repeatedName() + "' twice. Send each name once.",
                 {}};
  }
  return Error{ErrorCode::Parse,
               "The line is not JSON: " + builder.problem() +
                   ". Send one JSON object per line, in UTF-8; NaN and Infinity are not JSON numbers.",
               {}};
}

BadMessage invalid(MessageId id, const std::string& path, const std::string& what) {
  Error error = fieldError(path, what);
  error.code = ErrorCode::InvalidRequest;
  return {std::move(id), std::move(error)};
}

/// Reads the id. Returns what is wrong, or nothing.
std::optional<std::string> readId(const nlohmann::json& value, MessageId& id) {
  if (value.is_null()) {
    return std::nullopt;
  }
  if (value.is_string()) {
    const auto& text = value.get_ref<const std::string&>();
    if (text.size() > kLongestIdBytes) {
      return "a text of " + std::to_string(text.size()) + " bytes is too long for an id (at most " +
             std::to_string(kLongestIdBytes) + ")";
    }
    id = MessageId::of(text);
    return std::nullopt;
  }
  if (value.is_number_integer()) {
    const bool isHuge =
        value.is_number_unsigned() && value.get<std::uint64_t>() > static_cast<std::uint64_t>(kMaximumExactInteger);
    const std::int64_t number = isHuge ? 0 : value.get<std::int64_t>();
    if (isHuge || number < -kMaximumExactInteger) {
      return "an id beyond 2^53 is not exact in every language; use a smaller number or a text";
    }
    id = MessageId::of(number);
    return std::nullopt;
  }
  return "expected a whole number or a text as id";
}

Error readError(const nlohmann::json& value) {
  Error error;
  if (value.is_object()) {
    if (const auto code = value.find("code"); code != value.end() && code->is_number_integer()) {
      error.code = static_cast<ErrorCode>(code->get<std::int32_t>());
    }
    if (const auto message = value.find("message"); message != value.end() && message->is_string()) {
      error.message = message->get<std::string>();
    }
    if (const auto data = value.find("data"); data != value.end() && data->is_object()) {
      error.data = data->dump();
    }
  }
  return error;
}

/// Reads `bin` and `binBytes`. What is wrong, or nothing.
std::optional<Error> readBlockTable(const nlohmann::json& root, std::uint64_t& blockBytes,
                                    std::vector<BlockDescription>& table) {
  const auto total = root.find("binBytes");
  const auto list = root.find("bin");
  if (total == root.end() && list == root.end()) {
    return std::nullopt;
  }
  try {
    blockBytes = Field(total == root.end() ? nullptr : &*total, "binBytes").count();
    const Field blocks(list == root.end() ? nullptr : &*list, "bin");
    const std::size_t count = blocks.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      const Field field = blocks.element(i);
      field.requireObject();
      BlockDescription block;
      block.name = field["name"].text();
      const std::string& type = field["dtype"].text();
      if (type == "<f8") {
        block.type = BlockType::Float64;
      } else if (type == "<f4") {
        block.type = BlockType::Float32;
      } else if (type == "<u4") {
        block.type = BlockType::Unsigned32;
      } else {
        field["dtype"].failExpected("one of <f8, <f4, <u4");
      }
      const Field shape = field["shape"];
      const std::size_t dimensions = shape.arraySize();
      for (std::size_t k = 0; k < dimensions; ++k) {
        block.shape.push_back(shape.element(k).count());
      }
      block.offset = field["offset"].count();
      block.bytes = field["bytes"].count();
      table.push_back(std::move(block));
    }
  } catch (const FieldFailure& failure) {
    return failure.error;
  }
  return problemOf(table, blockBytes);
}

std::string begin(const MessageId* id) {
  std::string line = R"({"jsonrpc":"2.0")";
  if (id != nullptr) {
    line += ",\"id\":" + toText(*id);
  }
  return line;
}

/// The rest of a message after `..."params":`, with its blocks.
std::string withBody(std::string head, const Body& body) {
  if (body.blocks.isEmpty()) {
    head.reserve(head.size() + body.json.size() + 2);
    return head.append(body.json).append("}\n");
  }
  const std::string members = body.blocks.members();
  head.reserve(head.size() + body.json.size() + members.size() + 4 + body.blocks.totalBytes());
  head.append(body.json).append(",").append(members).append("}\n");
  body.blocks.appendTo(head);
  return head;
}

}  // namespace

std::string toText(const MessageId& id) {
  JsonWriter writer;
  switch (id.kind) {
    case MessageId::Kind::Null:
      writer.null();
      break;
    case MessageId::Kind::Number:
      writer.integer(id.number);
      break;
    case MessageId::Kind::Text:
      writer.text(id.text);
      break;
  }
  return writer.take();
}

std::string Payload::toText() const {
  if (bulk_ != nullptr) {
    return std::string(bulk_->json);
  }
  return value_ == nullptr ? "null" : static_cast<const nlohmann::json*>(value_)->dump();
}

std::variant<Message, BadMessage> decodeMessage(std::string_view line) {
  auto parsed = parse(line);
  if (auto* error = std::get_if<Error>(&parsed)) {
    return BadMessage{{}, std::move(*error)};
  }
  auto tree = std::make_shared<JsonTree>(JsonTree{std::move(std::get<nlohmann::json>(parsed))});
  const nlohmann::json& root = tree->value;
  if (root.is_array()) {
    return BadMessage{
        {}, {ErrorCode::InvalidRequest, "Batch arrays are not part of espalier/1. Send one object per line.", {}}};
  }
  if (!root.is_object()) {
    return BadMessage{{},
                      {ErrorCode::InvalidRequest, "A message is a JSON object; this line is another JSON value.", {}}};
  }

  // the id first, so that everything wrong after it can be answered
  Message message;
  const auto id = root.find("id");
  if (id != root.end()) {
    if (const auto problem = readId(*id, message.id)) {
      return invalid({}, "id", *problem);
    }
  }
  const auto version = root.find("jsonrpc");
  if (version == root.end() || !version->is_string() || version->get_ref<const std::string&>() != "2.0") {
    return invalid(message.id, "jsonrpc", "expected \"2.0\"");
  }

  std::uint64_t blockBytes = 0;
  if (auto problem = readBlockTable(root, blockBytes, message.blockTable)) {
    problem->code = ErrorCode::InvalidRequest;
    return BadMessage{message.id, std::move(*problem), blockBytes};
  }
  message.blockBytes = blockBytes;
  const auto refused = [&](const std::string& path, const std::string& what) {
    BadMessage bad = invalid(message.id, path, what);
    bad.blockBytes = blockBytes;
    return bad;
  };

  // requests and notifications
  if (const auto method = root.find("method"); method != root.end()) {
    if (!method->is_string() || method->get_ref<const std::string&>().empty()) {
      return refused("method", "expected the name of a method");
    }
    message.method = method->get<std::string>();
    message.kind = id != root.end() ? Message::Kind::Request : Message::Kind::Notification;
    const auto params = root.find("params");
    if (params != root.end() && !params->is_null()) {
      if (!params->is_object()) {
        return refused("params", "expected an object (params by name)");
      }
      message.payload = Payload(tree, &*params, "params");
    }
    return message;
  }

  // responses
  const auto result = root.find("result");
  const auto error = root.find("error");
  if ((result == root.end()) == (error == root.end())) {
    return refused("method", "a message needs a method, a result or an error, and a response only one of the two");
  }
  if (result != root.end()) {
    message.kind = Message::Kind::Result;
    message.payload = Payload(tree, &*result, "result");
  } else {
    message.kind = Message::Kind::Error;
    message.error = readError(*error);
  }
  return message;
}

std::string encodeRequest(const MessageId& id, std::string_view method, const Body& params) {
  std::string head = begin(&id);
  head.append(R"(,"method":")").append(method).append(R"(","params":)");
  return withBody(std::move(head), params);
}

std::string encodeNotification(std::string_view method, const Body& params) {
  std::string head = begin(nullptr);
  head.append(R"(,"method":")").append(method).append(R"(","params":)");
  return withBody(std::move(head), params);
}

std::string encodeResult(const MessageId& id, const Body& result) {
  return withBody(begin(&id).append(",\"result\":"), result);
}

std::string encodeError(const MessageId& id, const Error& error) {
  JsonWriter body;
  body.beginObject().key("code").integer(static_cast<std::int32_t>(error.code)).key("message").text(error.message);
  if (!error.data.empty()) {
    body.key("data").raw(error.data);
  }
  body.endObject();
  std::string line = begin(&id);
  line.append(",\"error\":").append(body.view()).append("}\n");
  return line;
}

std::optional<std::string> memberOf(std::string_view json, std::string_view name) {
  auto parsed = parse(json);
  const auto* root = std::get_if<nlohmann::json>(&parsed);
  if (root == nullptr || !root->is_object()) {
    return std::nullopt;
  }
  const auto found = root->find(name);
  if (found == root->end()) {
    return std::nullopt;
  }
  return found->is_string() ? found->get<std::string>() : found->dump();
}

std::optional<std::map<std::string, std::string>> textsOf(std::string_view json, std::string_view name) {
  auto parsed = parse(json);
  const auto* root = std::get_if<nlohmann::json>(&parsed);
  const auto found = root != nullptr && root->is_object() ? root->find(name) : nlohmann::json::const_iterator();
  if (root == nullptr || !root->is_object() || found == root->end() || !found->is_object()) {
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

std::optional<std::string> jsonProblem(std::string_view json) {
  if (nestingOf(json) > kDeepestNesting) {
    return "brackets are nested deeper than " + std::to_string(kDeepestNesting);
  }
  try {
    const nlohmann::json parsed = nlohmann::json::parse(json);
    return std::nullopt;
  } catch (const nlohmann::json::exception& exception) {
    return parserMessage(exception);
  }
}

}  // namespace espalier::protocol
