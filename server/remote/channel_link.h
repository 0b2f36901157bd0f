#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/framing.h"
#include "server/remote/environment_link.h"
#include "server/remote/processes/line_channel.h"

namespace espalier::server {

struct ChannelOptions {
  std::chrono::milliseconds connectTimeout{5'000};
  /// How long a peer may take to answer `hello`; one that does not is taken for a minimal environment.
  std::chrono::milliseconds introductionTimeout{10'000};
  protocol::FrameLimits limits;
  bool offersBlocks = true;  // names the capability `bin`
};

/// A link over a connection that we dial (TCP, or a socket of the file system), or to a command that we start.
/// Asio-free: the caller's thread waits.
class ChannelLink final : public EnvironmentLink {
 public:
  [[nodiscard]] static std::unique_ptr<ChannelLink> tcp(std::string address, const ChannelOptions& options);
  /// A socket of the file system.
  [[nodiscard]] static std::unique_ptr<ChannelLink> unixSocket(std::string path, const ChannelOptions& options);
  /// A command that the shell starts.
  [[nodiscard]] static std::unique_ptr<ChannelLink> stdio(std::string command, const ChannelOptions& options);
  /// A program that starts without a shell. People know it by `name`; `words` are its file and its arguments.
  [[nodiscard]] static std::unique_ptr<ChannelLink> program(const std::string& name, std::vector<std::string> words,
                                                            const ChannelOptions& options);
  ~ChannelLink() override;

  [[nodiscard]] std::string label() const override { return label_; }
  [[nodiscard]] std::string remedy() const override { return remedy_; }
  [[nodiscard]] std::optional<LinkFailure> connect() override;
  [[nodiscard]] std::uint64_t generation() const override;
  [[nodiscard]] PeerTerms terms() const override { return terms_; }
  [[nodiscard]] LinkOutcome call(std::string_view method, const protocol::Body& params,
                                 std::chrono::milliseconds timeout) override;
  void interrupt() override;

 private:
  struct Transport;
  using Dialer = std::function<tl::expected<std::unique_ptr<Transport>, std::string>(Deadline)>;
  using Starter = std::function<tl::expected<std::unique_ptr<ChildProcess::Started>, std::string>()>;

  [[nodiscard]] static std::unique_ptr<ChannelLink> started(const std::string& name, Starter start,
                                                            const ChannelOptions& options);

  ChannelLink(std::string label, std::string remedy, Dialer dialer, const ChannelOptions& options);
  /// Sends hello. A peer that does not know it, or keeps silent, is served all the same.
  [[nodiscard]] std::optional<LinkFailure> introduce();
  [[nodiscard]] std::vector<std::string> ownCapabilities() const;
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> ownLimits() const;
  /// Notes the terms of the peer's hello.
  void agree(const std::vector<std::string>& capabilities,
             const std::vector<std::pair<std::string, std::uint64_t>>& limits);
  [[nodiscard]] LinkOutcome exchange(const protocol::MessageId& id, const std::string& line, Deadline deadline,
                                     std::chrono::milliseconds timeout);
  /// Answers a request of the environment: it may say hello itself.
  [[nodiscard]] LineChannel::Status answer(const protocol::Message& request, Deadline deadline);
  [[nodiscard]] LinkFailure failureOf(LineChannel::Status status, std::chrono::milliseconds timeout);

  std::string label_;
  std::string remedy_;
  Dialer dialer_;
  ChannelOptions options_;
  mutable std::mutex mutex_;              // guards the pointer against interrupt()
  std::shared_ptr<Transport> transport_;  // null: not connected
  PeerTerms terms_;
  std::uint64_t connectionCount_ = 0;
  std::uint64_t requestCount_ = 0;
};

}  // namespace espalier::server
