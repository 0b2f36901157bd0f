#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <vector>

#include "protocol/codec.h"
#include "protocol/methods.h"
#include "tests/support/places.h"

namespace espalier::protocol::readme_test {
namespace {

using nlohmann::json;

std::string contentOf(const std::string& name) {
  std::ifstream file(sourceFolder() + "/protocol/" + name);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The lines of all json blocks of the specification.
std::vector<std::string> exampleLines() {
  std::vector<std::string> lines;
  std::istringstream text(contentOf("README.md"));
  bool isInBlock = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("```")) {
      isInBlock = line == "```json";
    } else if (isInBlock) {
      lines.push_back(line);
    }
  }
  return lines;
}

/// The part of JSON Schema that the file uses. Appends what is wrong.
void validate(const json& schema, const json& root, const json& value, const std::string& path,
              std::vector<std::string>& problems) {
  if (schema.is_boolean()) {
    return;
  }
  if (schema.contains("$ref")) {
    const std::string name = schema["$ref"].get<std::string>().substr(std::string("#/$defs/").size());
    validate(root["$defs"][name], root, value, path, problems);
    return;
  }
  if (schema.contains("anyOf")) {
    for (const json& option : schema["anyOf"]) {
      std::vector<std::string> found;
      validate(option, root, value, path, found);
      if (found.empty()) {
        return;
      }
    }
    problems.push_back(path + ": none of the alternatives");
    return;
  }
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end()) {
    problems.push_back(path + ": not one of the values");
  }
  if (schema.contains("type")) {
    const json types = schema["type"].is_array() ? schema["type"] : json::array({schema["type"]});
    const bool isRight = std::any_of(types.begin(), types.end(), [&](const json& type) {
      return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
             (type == "string" && value.is_string()) || (type == "boolean" && value.is_boolean()) ||
             (type == "number" && value.is_number()) || (type == "integer" && value.is_number_integer()) ||
             (type == "null" && value.is_null());
    });
    if (!isRight) {
      problems.push_back(path + ": wrong type");
      return;
    }
  }
  for (const json& name : schema.value("required", json::array())) {
    if (!value.contains(name.get<std::string>())) {
      problems.push_back(path + ": " + name.get<std::string>() + " is missing");
    }
  }
  if (schema.contains("properties") && value.is_object()) {
    for (const auto& [name, member] : value.items()) {
      if (schema["properties"].contains(name)) {
        validate(schema["properties"][name], root, member, path + "." + name, problems);
      }
    }
  }
  if (schema.contains("items")) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      validate(schema["items"], root, value[i], path + "[" + std::to_string(i) + "]", problems);
    }
    if (value.size() < schema.value("minItems", 0U) || value.size() > schema.value("maxItems", 1'000'000U)) {
      problems.push_back(path + ": wrong length");
    }
  }
}

/// The error of the decoder of a method's params, or nothing.
std::string decodeParams(const Message& message) {
  for (const Method& method : methods()) {
    if (method.name == message.method && method.problemOf != nullptr) {
      const auto error = method.problemOf(message.payload);
      return error ? error->message : std::string();
    }
  }
  return {};
}

TEST(Readme, EveryExampleIsAMessageThatTheCodecAndTheSchemaAccept) {
  const json schema = json::parse(contentOf("espalier-1.schema.json"));
  const json& methods = schema["$defs"]["methods"];
  std::map<std::string, std::string> methodOfId;
  std::size_t count = 0;
  for (const std::string& line : exampleLines()) {
    SCOPED_TRACE(line);
    ++count;
    auto decoded = decodeMessage(line);
    if (!decoded) {
      FAIL() << decoded.error().error.message;
    }
    Message& message = *decoded;
    if (message.blockBytes > 0) {
      // the page does not show the bytes: zeros
      const std::shared_ptr<std::uint64_t[]> zeros(new std::uint64_t[message.blockBytes / 8 + 1]());
      message.payload.attach(std::make_shared<const Blocks>(message.blockTable, zeros));
    }
    const json value = json::parse(line);
    std::vector<std::string> problems;
    validate(schema, schema, value, "message", problems);
    if (!message.method.empty()) {
      EXPECT_EQ(decodeParams(message), "");
      ASSERT_TRUE(methods.contains(message.method));
      validate(methods[message.method]["params"], schema, value.value("params", json::object()), "params", problems);
      methodOfId[toText(message.id)] = message.method;
    } else if (message.kind == Message::Kind::Result) {
      ASSERT_TRUE(methodOfId.contains(toText(message.id))) << "an answer to no example";
      validate(methods[methodOfId[toText(message.id)]]["result"], schema, value["result"], "result", problems);
      if (methodOfId[toText(message.id)] == "environment.step") {
        const auto replies = decodeReplies(message.payload, 2);
        EXPECT_TRUE(replies.has_value());
      }
    } else {
      EXPECT_NE(nameOf(message.error.code), "unknown");
    }
    for (const std::string& problem : problems) {
      ADD_FAILURE() << problem;
    }
  }
  EXPECT_GE(count, 40U);
}

TEST(Methods, AreTheOnesOfTheSchema) {
  const json schema = json::parse(contentOf("espalier-1.schema.json"));
  std::set<std::string> described;
  for (const auto& [name, shapes] : schema["$defs"]["methods"].items()) {
    described.insert(name);
  }
  std::set<std::string> known;
  for (const Method& method : methods()) {
    EXPECT_TRUE(known.emplace(method.name).second) << method.name << " has two rows in methods.def";
  }
  EXPECT_EQ(described, known);
}

TEST(Methods, ADecoderThatReadsNothingIsForMethodsWithoutParams) {
  const Payload none = decodeMessage(R"({"jsonrpc":"2.0","id":1,"method":"m","params":{}})").value().payload;
  for (const Method& method : methods()) {
    if (method.problemOf != nullptr && method.params != "NoParams") {
      EXPECT_TRUE(method.problemOf(none).has_value()) << method.name;
    }
  }
}

// frozen: programs out there compare with these numbers, so a change here breaks them
TEST(Readme, TheNumbersOfErrorsAreFrozen) {
  const std::vector<std::pair<int, std::string>> frozen{{-32700, "parse"},
                                                        {-32600, "invalid request"},
                                                        {-32601, "unknown method"},
                                                        {-32602, "invalid params"},
                                                        {-32603, "internal"},
                                                        {1001, "version"},
                                                        {1002, "capability"},
                                                        {1003, "unauthorised"},
                                                        {1004, "limit"},
                                                        {1005, "timeout"},
                                                        {1006, "environment failed"},
                                                        {1007, "stale step"},
                                                        {1008, "non-finite"},
                                                        {1009, "model"},
                                                        {1010, "cancelled"},
                                                        {1011, "not found"},
                                                        {1012, "hello missing"},
                                                        {1013, "snapshot"},
                                                        {1014, "storage"},
                                                        {1015, "shutting down"},
                                                        {1016, "offer taken"},
                                                        {1017, "model changed"}};
  std::vector<std::pair<int, std::string>> rows;
  for (const ErrorInfo& error : allErrors()) {
    rows.emplace_back(static_cast<int>(error.code), error.name);
    EXPECT_EQ(nameOf(error.code), error.name);
    EXPECT_FALSE(error.meaning.empty() || error.remedy.empty()) << error.name;
  }
  EXPECT_EQ(rows, frozen);
  EXPECT_EQ(nameOf(static_cast<ErrorCode>(1018)), "unknown");
  EXPECT_EQ(static_cast<int>(ErrorCode::Parse), -32700);
  EXPECT_EQ(static_cast<int>(ErrorCode::Internal), -32603);
  EXPECT_EQ(static_cast<int>(ErrorCode::Version), 1001);
  EXPECT_EQ(static_cast<int>(ErrorCode::EnvironmentFailed), 1006);
  EXPECT_EQ(static_cast<int>(ErrorCode::Storage), 1014);
  EXPECT_EQ(static_cast<int>(ErrorCode::ShuttingDown), 1015);
  EXPECT_EQ(static_cast<int>(ErrorCode::OfferTaken), 1016);
}

}  // namespace
}  // namespace espalier::protocol::readme_test
