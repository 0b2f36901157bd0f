#include "server/remote/remote_environment.h"

#include "server/remote/channel_link.h"
#include "server/remote/remote_process.h"

namespace espalier::server {

tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::string> connectRemoteEnvironment(
    const std::string& address, const RemoteEnvironmentOptions& options) {
  constexpr std::string_view kTcp = "tcp://";
  constexpr std::string_view kStdio = "stdio:";
  constexpr std::string_view kUnix = "unix:";
  ChannelOptions channel;
  channel.connectTimeout = options.connectTimeout;
  channel.offersBlocks = !options.isTextOnly;
  std::shared_ptr<EnvironmentLink> link;
  if (address.starts_with(kTcp)) {
    std::string host;
    std::uint16_t port = 0;
    if (!splitAddress(address.substr(kTcp.size()), host, port) || port == 0) {
      return tl::unexpected("'" + address +
                            "' is not an address: write tcp://HOST:PORT, for example tcp://127.0.0.1:4000.");
    }
    link = ChannelLink::tcp(address.substr(kTcp.size()), channel);
  } else if (address.starts_with(kUnix)) {
    link = ChannelLink::unixSocket(address.substr(kUnix.size()), channel);
  } else if (address.starts_with(kStdio)) {
    link = ChannelLink::stdio(address.substr(kStdio.size()), channel);
  } else {
    return tl::unexpected(
        "'" + address +
        "' does not name an environment in another process. Write tcp://HOST:PORT, unix:PATH or stdio:COMMAND.");
  }
  RemoteProcessOptions processOptions;
  processOptions.stepTimeout = options.stepTimeout;
  processOptions.configurationJson = options.configurationJson;
  processOptions.keepsState = options.keepsState;
  auto process = std::make_unique<RemoteProcess>(std::move(link), std::move(processOptions));
  if (auto error = process->introduce(); error && !(options.isAbsenceTolerated && error->isRetryable)) {
    return tl::unexpected(std::move(error->message));
  }
  return process;
}

}  // namespace espalier::server
