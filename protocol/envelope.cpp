#include "protocol/envelope.h"

#include <utility>
#include <vector>

#include "protocol/decoding/json_parser.h"
#include "protocol/decoding/member.h"
#include "protocol/decoding/payload_content.h"
#include "protocol/json_writer.h"

namespace espalier::protocol {
namespace {

constexpr std::size_t kLongestIdBytes = 200;

/// A refusal of the whole message because of one member.
tl::unexpected<BadMessage> refusal(const MessageId& id, Error error, std::uint64_t blockBytes = 0) {
  error.code = ErrorCode::InvalidRequest;
  return tl::unexpected(BadMessage{id, std::move(error), blockBytes});
}

/// Reads the id. Returns the mistake, or nothing.
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

/// Reads `bin` and `binBytes`. Returns the mistake, or nothing.
std::optional<Error> readBlockTable(const nlohmann::json& root, std::uint64_t& blockBytes,
                                    std::vector<BlockDescription>& table) {
  const auto total = root.find("binBytes");
  const auto list = root.find("bin");
  if (total == root.end() && list == root.end()) {
    return std::nullopt;
  }
  try {
    blockBytes = Member(total == root.end() ? nullptr : &*total, "binBytes").count();
    const Member blocks(list == root.end() ? nullptr : &*list, "bin");
    const std::size_t count = blocks.arraySize();
    for (std::size_t i = 0; i < count; ++i) {
      const Member entry = blocks.element(i);
      entry.requireObject();
      BlockDescription block;
      block.name = entry["name"].text();
      const std::string& type = entry["dtype"].text();
      if (type == "<f8") {
        block.type = BlockType::Float64;
      } else if (type == "<f4") {
        block.type = BlockType::Float32;
      } else if (type == "<u4") {
        block.type = BlockType::Unsigned32;
      } else {
        entry["dtype"].failExpected("one of <f8, <f4, <u4");
      }
      const Member shape = entry["shape"];
      const std::size_t dimensions = shape.arraySize();
      for (std::size_t k = 0; k < dimensions; ++k) {
        block.shape.push_back(shape.element(k).count());
      }
      block.offset = entry["offset"].count();
      block.bytes = entry["bytes"].count();
      table.push_back(std::move(block));
    }
  } catch (const MemberFailure& failure) {
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

/// The whole message: `head` ends in `"params":` or `"result":`, the body and its blocks follow.
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

tl::expected<Message, BadMessage> decodeMessage(std::string_view line) {
  auto parsed = parseJson(line);
  if (!parsed) {
    return tl::unexpected(BadMessage{{}, std::move(parsed.error())});
  }
  auto tree = std::make_shared<JsonTree>(std::move(*parsed));
  const nlohmann::json& root = tree->value;
  if (root.is_array()) {
    return refusal({}, {{}, "Batch arrays are not part of espalier/1. Send one object per line.", {}});
  }
  if (!root.is_object()) {
    return refusal({}, {{}, "A message is a JSON object; this line is another JSON value.", {}});
  }

  // the id first, so that every later mistake can be answered
  Message message;
  const auto id = root.find("id");
  if (id != root.end()) {
    if (const auto problem = readId(*id, message.id)) {
      return refusal({}, memberError("id", *problem));
    }
  }
  const auto version = root.find("jsonrpc");
  if (version == root.end() || !version->is_string() || version->get_ref<const std::string&>() != "2.0") {
    return refusal(message.id, memberError("jsonrpc", "expected \"2.0\""));
  }

  std::uint64_t blockBytes = 0;
  if (auto problem = readBlockTable(root, blockBytes, message.blockTable)) {
    return refusal(message.id, std::move(*problem), blockBytes);
  }
  message.blockBytes = blockBytes;
  const auto refused = [&](const std::string& path, const std::string& what) {
    return refusal(message.id, memberError(path, what), blockBytes);
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

}  // namespace espalier::protocol
