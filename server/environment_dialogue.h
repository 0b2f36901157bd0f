#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/turtle/environment_process.h"
#include "protocol/envelope.h"
#include "server/environment_host.h"

namespace espalier::server {

/// The environment's side of one connection: answers hello and environment.* for a process of its own per simulation.
/// Not thread-safe. Idempotent: a step that is asked again with the same queries gets the same replies, without
/// advancing a process that has state.
class EnvironmentDialogue {
 public:
  /// `factory` must outlive the object.
  explicit EnvironmentDialogue(const ProcessFactory& factory) : factory_(&factory) {}

  /// One line in; the line to send back, or nothing for notifications and answers.
  [[nodiscard]] std::optional<std::string> answer(std::string_view line);

 private:
  struct Opened {
    std::unique_ptr<turtle::EnvironmentProcess> process;
    std::vector<std::string> symbols;
    bool isStateful = false;
    std::optional<std::uint64_t> lastStep;  // of a process with state
    std::uint32_t lastIteration = 0;
    std::uint64_t lastQueriesHash = 0;
    std::string lastResult;
  };
  /// The result as JSON text, or an error.
  using Reply = std::variant<std::string, protocol::Error>;

  [[nodiscard]] Reply handle(const protocol::Message& request);
  [[nodiscard]] Reply hello(const protocol::Payload& payload) const;
  [[nodiscard]] Reply open(const protocol::Payload& payload);
  [[nodiscard]] Reply step(const protocol::Payload& payload);
  [[nodiscard]] Reply save(const protocol::Payload& payload);
  [[nodiscard]] Reply restore(const protocol::Payload& payload);
  [[nodiscard]] Reply close(const protocol::Payload& payload);
  [[nodiscard]] Opened& openedFor(const std::string& simulation);

  const ProcessFactory* factory_;
  std::map<std::string, Opened> opened_;  // by simulation
};

}  // namespace espalier::server
