#include "clients/espalier/server_connection.h"

#include <CLI/CLI.hpp>
#include <utility>

#include "protocol/json_text.h"

namespace espalier::command {
namespace {

// an error of the protocol, with a remedy for a person at a shell
std::string sentenceOf(const protocol::Error& error, const std::string& address, bool isPlain) {
  if (error.code == protocol::ErrorCode::Unauthorised) {
    return "The server at " + address + " refuses the connection. " + error.message +
           " The options --token-file and --token give a token.";
  }
  const bool isLost = error.message.starts_with("The connection to the server is lost");
  return isPlain && isLost ? error.message + " If this is the port of --http, write ws://" + address +
                                 "; if the server is encrypted, tls://" + address + "."
                           : error.message;
}

}  // namespace

void addServerAddress(CLI::App& command, ServerAddress& address, bool isRequired) {
  CLI::Option* option = command.add_option(
      "ADDRESS", address.address, "HOST:PORT of the server, tls://HOST:PORT, unix:PATH, ws:// or wss://HOST:PORT");
  isRequired ? option->required() : option->capture_default_str();
  command
      .add_option("--trust", address.trustedFile,
                  "PEM file of a certificate to trust besides those of the system, for tls:// and wss://")
      ->type_name("FILE");
}

Result<ServerConnection> connectTo(const ServerAddress& address, const client::ClientOptions& options) {
  ServerConnection connection;
  std::string place = address.address;
  if (server::DialBridge::isFor(place)) {
    auto opened = server::DialBridge::open(place, {.trustedFile = address.trustedFile});
    if (!opened) {
      return problem(std::move(opened.error()));
    }
    connection.bridge = std::move(*opened);
    place = connection.bridge->address();
  }
  auto connected = client::Client::connect(place, options);
  if (!connected) {
    return problem(sentenceOf(connected.error(), address.address, connection.bridge == nullptr));
  }
  // a server grants roles, an environment none
  const std::string roles = protocol::memberOf((*connected)->helloResult(), "roles").value_or("[]");
  if (roles == "[]") {
    return problem("at " + address.address + " is an environment, not a server. `espalier serve` starts a server; " +
                   "--environment tcp://" + address.address + " lets a model ask this environment.");
  }
  connection.client = std::move(*connected);
  return connection;
}

}  // namespace espalier::command
