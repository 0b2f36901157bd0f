// Grows a plant on a running server and prints its string after each step: grow HOST:PORT
#include <iostream>

#include "clients/cpp/client.h"
#include "protocol/json_text.h"

using espalier::client::Client;
using espalier::protocol::Error;
using espalier::protocol::memberOf;

namespace {

// A tip asks how high it is and grows while it is lower than 3.
constexpr const char* kCreate =
    R"({"model":{"source":"Lsystem: 1\nderivation length: 5\nAxiom: A?E(0)\nA?E(h) : h < 3 --> FA?E(0)\nendlsystem\n"},)"
    R"("environment":[{"type":"height"}],"seed":1})";

std::string ask(Client& client, const char* method, const std::string& params) {
  auto outcome = client.request(method, params);
  if (!outcome) {
    std::cerr << "grow: " << outcome.error().message << '\n';
    std::exit(1);
  }
  return *outcome;
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount != 2) {
    std::cerr << "usage: grow HOST:PORT\n";
    return 2;
  }
  auto connected = Client::connect(arguments[1], {});
  if (!connected) {
    std::cerr << "grow: " << connected.error().message << '\n';
    return 1;
  }
  Client& client = **connected;
  const std::string simulation = memberOf(ask(client, "simulation.create", kCreate), "simulation").value_or("");
  const std::string named = R"({"simulation":")" + simulation + "\"}";
  for (bool isFinished = false; !isFinished;) {
    isFinished = memberOf(ask(client, "simulation.step", named), "finished") == "true";
    const std::string got = ask(client, "simulation.get", R"({"simulation":")" + simulation + R"(","what":"string"})");
    std::cout << memberOf(got, "step").value_or("?") << '\t' << memberOf(got, "string").value_or("?") << '\n';
  }
  ask(client, "simulation.delete", named);
}
