#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "clients/espalier/client_token.h"
#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/server_connection.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"

namespace espalier::command {
namespace {

struct StatusOptions {
  ServerAddress server;
  std::string token;
  bool isJson = false;
};

int runStatus(const StatusOptions& options) {
  client::ClientOptions clientOptions;
  clientOptions.token = options.token;
  const auto connection = connectTo(options.server, clientOptions);
  if (!connection) {
    printError(connection.error());
    return kFailure;
  }
  const auto answer = connection->client->request("server.status", "{}");
  if (!answer) {
    printError(answer.error().message);
    return kFailure;
  }
  const auto& status = *answer;
  if (options.isJson) {
    std::printf("%s\n", status.c_str());
    return kSuccess;
  }
  struct Line {
    const char* label;
    const char* object;  // empty: the status itself
    const char* member;
  };
  constexpr std::array kLines{
      Line{"server", "", "server"},
      Line{"seconds since its start", "", "uptimeSeconds"},
      Line{"sessions", "", "sessions"},
      Line{"simulations", "", "simulations"},
      Line{"  of them computing", "", "running"},
      Line{"  damaged on disk", "", "damaged"},
      Line{"workers", "", "workers"},
      Line{"saved on disk", "", "saving"},
      Line{"saved survives the end of", "", "durability"},
      Line{"simulations on disk only", "", "passive"},
      Line{"offered environments", "", "offered"},
      Line{"bytes of all memory", "memory", "usedBytes"},
      Line{"  of at most", "memory", "boundBytes"},
      Line{"bytes of strings", "memory", "stringBytes"},
      Line{"bytes kept for viewers", "memory", "streamBytes"},
      Line{"bytes not read by peers", "memory", "outboxBytes"},
      Line{"bytes of the database", "memory", "databaseBytes"},
      Line{"bytes of the data folder", "memory", "storeBytes"},
      Line{"bytes of traces on disk", "memory", "traceBytes"},
  };
  for (const Line& line : kLines) {
    const std::string object = *line.object == '\0' ? status : protocol::memberOf(status, line.object).value_or("{}");
    if (const auto value = protocol::memberOf(object, line.member)) {
      std::printf("%-26s %s\n", line.label, value->c_str());
    }
  }
  return kSuccess;
}

}  // namespace

void addStatus(CLI::App& program, int& status) {
  const auto options = std::make_shared<StatusOptions>();
  CLI::App* command = program.add_subcommand("status", "Print the load and the contents of a running server");
  addServerAddress(*command, options->server, false);
  addClientToken(*command, options->token);
  command->add_flag("--json", options->isJson, "Print the answer of server.status as JSON");
  command->footer("Exit status: 0 the server answered, 1 no server answers. Example: espalier status 127.0.0.1:4321");
  command->callback([options, &status] { status = runStatus(*options); });
}

}  // namespace espalier::command
