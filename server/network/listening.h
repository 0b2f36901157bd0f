#pragma once

#include <boost/asio.hpp>
#include <boost/asio/ssl.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

namespace espalier::server {

// Only for the files that know the network library. Each function returns an error sentence, or nothing.

/// Binds and listens. `option` is the command line's name of the address, for the error.
[[nodiscard]] std::optional<std::string> listenOn(boost::asio::ip::tcp::acceptor& acceptor, const std::string& host,
                                                  std::uint16_t port, const std::string& option);
/// The same for a socket of the file system that only this user may connect to. A socket that a killed server left
/// there is removed.
[[nodiscard]] std::optional<std::string> listenOnUnixSocket(boost::asio::local::stream_protocol::acceptor& acceptor,
                                                            const std::string& path);
/// Device and number of a file, by which it is known from a later one of the same name.
using FileIdentity = std::pair<std::uint64_t, std::uint64_t>;
/// Of the file itself, when it is a link. Nothing: there is none.
[[nodiscard]] std::optional<FileIdentity> identityOf(const std::string& path);

/// Both files are PEM.
[[nodiscard]] std::optional<std::string> loadCertificate(boost::asio::ssl::context& encryption,
                                                         const std::string& certificateFile,
                                                         const std::string& keyFile);

/// Has the system allow so many open descriptors, when it can. How many it allows then.
std::size_t raiseDescriptorBound(std::size_t wanted);

}  // namespace espalier::server
