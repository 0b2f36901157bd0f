#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "engine/turtle/environment_process.h"
#include "protocol/framing.h"
#include "protocol/messages.h"
#include "server/remote/hosting/environment_host.h"

namespace espalier::server {

/// The environment's side of one connection: answers hello and environment.* for a process of its own per simulation.
/// Not thread-safe. Idempotent: a step that is asked again with the same queries gets the same replies, without
/// advancing a process that has state.
class EnvironmentDialogue {
 public:
  /// Open at a time on one connection.
  static constexpr std::size_t kMostSimulations = 10'000;

  /// `factory` must outlive the object.
  EnvironmentDialogue(const ProcessFactory& factory, const protocol::FrameLimits& limits)
      : factory_(&factory), limits_(limits) {}

  /// One message in; the bytes to send back, or nothing for notifications and answers.
  [[nodiscard]] std::optional<std::string> answer(const protocol::MessageReader::Read& read);
  /// Both sides named the capability `bin` in hello.
  [[nodiscard]] bool areBlocksAgreed() const { return areBlocksAgreed_; }
  [[nodiscard]] bool hasSimulations() const { return !opened_.empty(); }

 private:
  struct Opened {
    std::unique_ptr<turtle::EnvironmentProcess> process;
    std::vector<std::string> symbols;
    bool isStateful = false;
    turtle::EnvironmentNeeds needs;
    std::optional<std::uint64_t> lastStep;  // of a process with state
    std::uint32_t lastIteration = 0;
    std::uint64_t lastQueriesHash = 0;
    std::shared_ptr<const turtle::Geometry> geometry;  // that came last; null: none
    // of the last step: its answer refers to them
    turtle::QueryBatch queries;
    turtle::ReplyBatch replies;
    protocol::ReplyColumns columns;
  };
  using Reply = protocol::Expected<protocol::Body>;

  [[nodiscard]] Reply handle(const protocol::Message& request);
  template <auto decode, auto handler>
  [[nodiscard]] static Reply decodeAndHandle(EnvironmentDialogue& self, const protocol::Payload& payload);
  // the handlers of protocol/methods.def; the payload tells whether a step came in blocks
#define ESPALIER_COMMON_METHOD(NAME, PARAMS, HANDLER, SUMMARY) \
  [[nodiscard]] Reply HANDLER(const protocol::PARAMS& params, const protocol::Payload& payload);
#define ESPALIER_SHARED_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  [[nodiscard]] Reply HANDLER(const protocol::PARAMS& params, const protocol::Payload& payload);
#define ESPALIER_ENVIRONMENT_METHOD(NAME, PARAMS, HANDLER, SUMMARY) \
  [[nodiscard]] Reply HANDLER(const protocol::PARAMS& params, const protocol::Payload& payload);
#include "protocol/methods.def"
  /// The process of a simulation. A controller that did not open it gets one that is opened with nothing special.
  [[nodiscard]] protocol::Expected<Opened*> openedFor(const std::string& simulation);
  /// A new process, opened.
  [[nodiscard]] protocol::Expected<Opened*> openAnew(const turtle::EnvironmentContext& context);

  const ProcessFactory* factory_;
  protocol::FrameLimits limits_;
  std::map<std::string, Opened> opened_;  // by simulation
  bool areBlocksAgreed_ = false;
};

}  // namespace espalier::server
