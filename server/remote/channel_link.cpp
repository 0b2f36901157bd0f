#include "server/remote/channel_link.h"

#include <algorithm>
#include <exception>
#include <new>

#include "engine/core/work_meter.h"
#include "protocol/codec.h"
#include "protocol/version.h"

namespace espalier::server {

namespace {

/// Ends the reading of a message at the deadline of the question: library code that does not ask gets no more memory.
/// A program whose `new` tells no meter reads to the end.
class ReadingMeter final : public core::WorkMeter {
 public:
  explicit ReadingMeter(Deadline deadline) : outer_(core::WorkMeter::current()), deadline_(deadline) {}

  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    // the clock costs more than a small block
    if (bytes > 0 && (++blocks_ % kBlocksOfALook == 0)) {
      isLate_ = isLate_ || std::chrono::steady_clock::now() >= deadline_;
    }
    if (isLate_ && bytes > 0 && std::uncaught_exceptions() == 0) {
      return false;
    }
    return outer_ == nullptr || outer_->take(bytes);
  }
  [[nodiscard]] bool isStopped() const noexcept override {
    return isLate_ || (outer_ != nullptr && outer_->isStopped());
  }
  [[nodiscard]] bool isLate() const { return isLate_; }

 private:
  static constexpr std::uint32_t kBlocksOfALook = 1024;

  core::WorkMeter* const outer_;  // null: nobody counts
  Deadline deadline_;
  std::uint32_t blocks_ = 0;
  bool isLate_ = false;
};

}  // namespace

struct ChannelLink::Transport {
  Transport(Descriptor input, Descriptor output, std::unique_ptr<ChildProcess> startedChild,
            const protocol::FrameLimits& limits)
      : child(std::move(startedChild)),
        channel(std::move(input), std::move(output), limits.lineBytes),
        reader(limits) {}
  ~Transport() { channel.closeOutput(); }

  /// Gives back the memory of messages that are gone: the next question may come late.
  void rest() {
    channel.rest();
    reader.rest();
    received = std::string();
  }

  // the channel closes first, so that the child reads the end of its input before it is waited for
  std::unique_ptr<ChildProcess> child;  // null: a connection
  LineChannel channel;
  protocol::MessageReader reader;
  std::string received;  // memory of the last bytes
};

std::unique_ptr<ChannelLink> ChannelLink::tcp(std::string address, const ChannelOptions& options) {
  const protocol::FrameLimits limits = options.limits;
  Dialer dialer = [address, limits](Deadline deadline) -> tl::expected<std::unique_ptr<Transport>, std::string> {
    auto dialled = dialTcp(address, deadline);
    if (!dialled) {
      return tl::unexpected(std::move(dialled.error()));
    }
    return std::make_unique<Transport>(std::move(*dialled), Descriptor(), nullptr, limits);
  };
  return std::unique_ptr<ChannelLink>(new ChannelLink("environment tcp://" + address,
                                                      "Start it again at " + address + ", then try again.",
                                                      std::move(dialer), options));
}

std::unique_ptr<ChannelLink> ChannelLink::unixSocket(std::string path, const ChannelOptions& options) {
  const protocol::FrameLimits limits = options.limits;
  Dialer dialer = [path, limits](Deadline) -> tl::expected<std::unique_ptr<Transport>, std::string> {
    auto dialled = dialUnix(path);
    if (!dialled) {
      return tl::unexpected(std::move(dialled.error()));
    }
    return std::make_unique<Transport>(std::move(*dialled), Descriptor(), nullptr, limits);
  };
  return std::unique_ptr<ChannelLink>(new ChannelLink(
      "environment unix:" + path, "Start it again at " + path + ", then try again.", std::move(dialer), options));
}

std::unique_ptr<ChannelLink> ChannelLink::stdio(std::string command, const ChannelOptions& options) {
  return started(
      command, [command] { return ChildProcess::start(command); }, options);
}

std::unique_ptr<ChannelLink> ChannelLink::program(const std::string& name, std::vector<std::string> words,
                                                  const ChannelOptions& options) {
  return started(
      name, [words = std::move(words)] { return ChildProcess::start(words); }, options);
}

std::unique_ptr<ChannelLink> ChannelLink::started(const std::string& name, Starter start,
                                                  const ChannelOptions& options) {
  const protocol::FrameLimits limits = options.limits;
  Dialer dialer = [start = std::move(start),
                   limits](Deadline) -> tl::expected<std::unique_ptr<Transport>, std::string> {
    auto result = start();
    if (!result) {
      return tl::unexpected(std::move(result.error()));
    }
    auto& child = **result;
    return std::make_unique<Transport>(std::move(child.input), std::move(child.output),
                                       std::make_unique<ChildProcess>(std::move(child.process)), limits);
  };
  return std::unique_ptr<ChannelLink>(new ChannelLink(
      "environment 'stdio:" + name + "'", "Run the command by hand to see what is wrong.", std::move(dialer), options));
}

ChannelLink::ChannelLink(std::string label, std::string remedy, Dialer dialer, const ChannelOptions& options)
    : label_(std::move(label)), remedy_(std::move(remedy)), dialer_(std::move(dialer)), options_(options) {}

ChannelLink::~ChannelLink() = default;

std::uint64_t ChannelLink::generation() const {
  return transport_ != nullptr ? connectionCount_ : 0;
}

std::optional<LinkFailure> ChannelLink::connect() {
  if (transport_ != nullptr) {
    return std::nullopt;
  }
  auto dialled = dialer_(std::chrono::steady_clock::now() + options_.connectTimeout);
  if (!dialled) {
    return LinkFailure{LinkFailure::Kind::Away, "is not there: " + dialled.error(), {}};
  }
  {
    const std::lock_guard lock(mutex_);
    transport_ = std::move(*dialled);
  }
  ++connectionCount_;
  return introduce();
}

std::optional<LinkFailure> ChannelLink::introduce() {
  const protocol::HelloParams hello{.protocol = {protocol::kProtocolVersion},
                                    .roles = {"controller"},
                                    .name = "espalier",
                                    .version = std::string(protocol::kProgramVersion),
                                    .capabilities = ownCapabilities(),
                                    .token = {},
                                    .limits = ownLimits()};
  terms_ = {};
  auto outcome = call("hello", protocol::encode(hello), options_.introductionTimeout);
  std::optional<LinkFailure> failure;
  bool isServer = false;
  if (outcome) {
    if (const auto result = protocol::decodeHelloResult(*outcome)) {
      agree(result->capabilities, result->limits);
      // which an environment does not grant
      isServer = std::ranges::find(result->roles, "controller") != result->roles.end();
    }
  } else {
    failure = std::move(outcome.error());
    const bool isRefused = failure->kind == LinkFailure::Kind::Refused;
    // an environment asks for no token
    isServer = isRefused && failure->error.code == protocol::ErrorCode::Unauthorised;
    // a connection that was lost with the question serves nobody
    const bool isFinal = isRefused && (failure->error.code == protocol::ErrorCode::Version ||
                                       failure->error.code == protocol::ErrorCode::Limit);
    if (transport_ != nullptr && ((isRefused && !isFinal) || failure->kind == LinkFailure::Kind::Timeout)) {
      failure.reset();
    }
  }
  if (isServer) {
    failure = LinkFailure{LinkFailure::Kind::Server, "is a server of simulations, not an environment", {}};
  }
  if (failure) {
    const std::lock_guard lock(mutex_);
    transport_.reset();
  }
  return failure;
}

std::vector<std::string> ChannelLink::ownCapabilities() const {
  return options_.offersBlocks ? std::vector<std::string>{"bin"} : std::vector<std::string>{};
}

std::vector<std::pair<std::string, std::uint64_t>> ChannelLink::ownLimits() const {
  return {{"lineBytes", options_.limits.lineBytes}, {"blockBytes", options_.limits.blockBytes}};
}

void ChannelLink::agree(const std::vector<std::string>& capabilities,
                        const std::vector<std::pair<std::string, std::uint64_t>>& limits) {
  terms_ = termsOf(capabilities, limits);
  terms_.takesBlocks = terms_.takesBlocks && options_.offersBlocks;
  if (terms_.takesBlocks) {
    transport_->reader.allowBlocks();
  }
}

LinkOutcome ChannelLink::call(std::string_view method, const protocol::Body& params,
                              std::chrono::milliseconds timeout) {
  if (transport_ == nullptr) {
    if (auto failure = connect()) {
      return tl::unexpected(std::move(*failure));
    }
  }
  transport_->channel.clearInterruption();
  const auto id = protocol::MessageId::of("s" + std::to_string(++requestCount_));
  const Deadline deadline = std::chrono::steady_clock::now() + timeout;
  auto outcome = exchange(id, protocol::encodeRequest(id, method, params), deadline, timeout);
  if (!outcome &&
      (outcome.error().kind == LinkFailure::Kind::Closed || outcome.error().kind == LinkFailure::Kind::Garbage)) {
    const std::lock_guard lock(mutex_);
    transport_.reset();
  } else if (transport_ != nullptr) {
    transport_->rest();
  }
  return outcome;
}

LinkOutcome ChannelLink::exchange(const protocol::MessageId& id, const std::string& line, Deadline deadline,
                                  std::chrono::milliseconds timeout) {
  LineChannel& channel = transport_->channel;
  // half a message may have been sent: the framing is lost
  const auto lostWith = [&](LineChannel::Status status) {
    auto failure = failureOf(status, timeout);
    const std::lock_guard lock(mutex_);
    transport_.reset();
    return tl::unexpected(std::move(failure));
  };
  if (const auto status = channel.write(line, deadline); status != LineChannel::Status::Done) {
    return lostWith(status);
  }
  protocol::MessageReader& reader = transport_->reader;
  bool isOver = false;
  while (true) {
    std::optional<protocol::MessageReader::Read> read;
    ReadingMeter meter(deadline);
    try {
      const core::WorkMeter::Scope scope(&meter);
      read = reader.next();
    } catch (const std::bad_alloc&) {
      if (!meter.isLate()) {
        throw;
      }
      // the rest of the message is gone, and the next one can be found
      return tl::unexpected(failureOf(LineChannel::Status::Timeout, timeout));
    }
    if (!read) {
      if (reader.lost()) {
        return tl::unexpected(LinkFailure{
            LinkFailure::Kind::Garbage, "sent a message that cannot be read: " + reader.lost()->message, {}});
      }
      // also for a peer that sends other messages without an end; those that are there are looked at once more
      if (isOver) {
        return tl::unexpected(failureOf(LineChannel::Status::Timeout, timeout));
      }
      isOver = std::chrono::steady_clock::now() >= deadline;
      if (const auto status = channel.receive(transport_->received, deadline); status != LineChannel::Status::Done) {
        return tl::unexpected(failureOf(status, timeout));
      }
      reader.feed(transport_->received);
      continue;
    }
    if (!*read) {
      return tl::unexpected(LinkFailure{
          LinkFailure::Kind::Garbage, "sent a line that is not a message: " + read->error().error.message, {}});
    }
    auto& message = **read;
    switch (message.kind) {
      case protocol::Message::Kind::Notification:
        break;
      case protocol::Message::Kind::Request:
        if (const auto status = answer(message, deadline); status != LineChannel::Status::Done) {
          return lostWith(status);
        }
        break;
      case protocol::Message::Kind::Result:
        // an answer with another id belongs to a question that timed out
        if (message.id == id) {
          return std::move(message.payload);
        }
        break;
      case protocol::Message::Kind::Error:
        if (message.id == id || message.id.kind == protocol::MessageId::Kind::Null) {
          return tl::unexpected(refusedWith(message.error));
        }
        break;
    }
  }
}

LineChannel::Status ChannelLink::answer(const protocol::Message& request, Deadline deadline) {
  std::string line;
  if (request.method == "hello") {
    if (const auto said = protocol::decodeHelloParams(request.payload)) {
      agree(said->capabilities, said->limits);
    }
    const protocol::HelloResult hello{.protocol = protocol::kProtocolVersion,
                                      .session = "1",
                                      .server = "espalier " + std::string(protocol::kProgramVersion),
                                      .roles = {},
                                      .capabilities = ownCapabilities(),
                                      .limits = ownLimits()};
    line = protocol::encodeResult(request.id, protocol::encode(hello));
  } else if (request.method == "environment.offer" || request.method == "ping") {
    line = protocol::encodeResult(request.id, "{}");
  } else {
    line = protocol::encodeError(request.id, {protocol::ErrorCode::UnknownMethod,
                                              "'" + request.method +
                                                  "' cannot be asked on this connection; it serves an "
                                                  "environment. Connect to the server as a controller.",
                                              {}});
  }
  return transport_->channel.write(line, deadline);
}

LinkFailure ChannelLink::failureOf(LineChannel::Status status, std::chrono::milliseconds timeout) {
  switch (status) {
    case LineChannel::Status::Timeout:
      return {LinkFailure::Kind::Timeout, "did not answer within " + std::to_string(timeout.count()) + " ms", {}};
    case LineChannel::Status::Interrupted:
      return {LinkFailure::Kind::Interrupted, "was given up with the step", {}};
    case LineChannel::Status::Overflow:
    case LineChannel::Status::Closed:
    case LineChannel::Status::Done:
      break;
  }
  const std::string fate = transport_->child != nullptr ? transport_->child->fate() : std::string();
  return {LinkFailure::Kind::Closed, fate.empty() ? "closed the connection" : fate, {}};
}

void ChannelLink::interrupt() {
  const std::lock_guard lock(mutex_);
  if (transport_ != nullptr) {
    transport_->channel.interrupt();
  }
}

}  // namespace espalier::server
