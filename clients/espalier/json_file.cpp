#include "clients/espalier/json_file.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "clients/espalier/json_place.h"
#include "engine/files/utf8.h"
#include "protocol/json_text.h"

namespace espalier::command {

void printFileError(const std::string& file, std::string message, core::FileProvider* provider) {
  constexpr std::string_view kRoot = "params";
  if (message.starts_with(kRoot)) {
    message.erase(0, kRoot.size() + (message.substr(kRoot.size(), 1) == "." ? 1 : 2));
  }
  const std::optional<std::string> text = provider != nullptr ? provider->read(file) : std::nullopt;
  const std::size_t path = std::min(message.find(": "), message.size());
  printError(file +
             (text ? jsonPlace(files::asUtf8(*text), std::string_view(message).substr(0, path)) : std::string()) +
             ": " + message);
}

std::optional<protocol::Payload> readJsonFile(const std::string& file, const std::string& what,
                                              core::FileProvider& files) {
  const std::optional<std::string> bytes = files.read(file);
  if (!bytes) {
    printError("there is no " + what + " '" + file + "': check the name and the working folder");
    return std::nullopt;
  }
  const std::string text = files::asUtf8(*bytes);
  if (const auto problem = protocol::jsonProblem(text)) {
    printError(file + ": " + *problem);
    return std::nullopt;
  }
  auto message = protocol::decodeMessage("{\"jsonrpc\":\"2.0\",\"method\":\"file\",\"params\":" + text + "}");
  if (!message) {
    printFileError(file, message.error().error.message, nullptr);
    return std::nullopt;
  }
  return std::move(message->payload);
}

}  // namespace espalier::command
