#include "server/network/listening.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>

namespace espalier::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

}  // namespace

std::optional<std::string> loadCertificate(asio::ssl::context& encryption, const std::string& certificateFile,
                                           const std::string& keyFile) {
  error_code error;
  encryption.set_options(
      asio::ssl::context::default_workarounds | asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1, error);
  encryption.use_certificate_chain_file(certificateFile, error);
  if (error) {
    return "the certificate '" + certificateFile + "' cannot be used: " + error.message() +
           ". ./dev certificate makes one for tests.";
  }
  encryption.use_private_key_file(keyFile, asio::ssl::context::pem, error);
  if (error) {
    return "the key '" + keyFile + "' cannot be used: " + error.message() +
           ". Give --key the private key of the certificate.";
  }
  // OpenSSL takes a key of another kind than the certificate's without a word
  if (SSL_CTX_check_private_key(encryption.native_handle()) != 1) {
    return "the key '" + keyFile + "' is not that of the certificate '" + certificateFile +
           "'. Give --key the private key of the certificate.";
  }
  return std::nullopt;
}

std::optional<std::string> listenOn(tcp::acceptor& acceptor, const std::string& host, std::uint16_t port,
                                    const std::string& option) {
  error_code error;
  tcp::resolver resolver(acceptor.get_executor());
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
  if (error || found.empty()) {
    return "cannot listen on '" + host + "': the address is unknown. Use 127.0.0.1 or an address of this machine.";
  }
  const tcp::endpoint endpoint = found.begin()->endpoint();
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    acceptor.bind(endpoint, error);
  }
  if (!error) {
    acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error == asio::error::address_in_use) {
    return "cannot listen on " + host + ":" + std::to_string(port) + ": the port is in use. Choose another with " +
           option + ", or port 0 for a free one.";
  }
  if (error) {
    return "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message() +
           ". Choose another address with " + option + ".";
  }
  return std::nullopt;
}

std::optional<std::string> listenOnUnixSocket(asio::local::stream_protocol::acceptor& acceptor,
                                              const std::string& path) {
  constexpr std::size_t kLongestPath = sizeof(::sockaddr_un::sun_path) - 1;
  if (path.size() > kLongestPath) {
    return "cannot listen on unix:" + path + ": the path has " + std::to_string(path.size()) + " bytes, and " +
           std::to_string(kLongestPath) + " are the most. Choose a shorter path with --listen.";
  }
  error_code error;
  const asio::local::stream_protocol::endpoint endpoint(path);
  // a socket that a killed server left behind is removed, that of a living server and any other file are not
  struct stat found {};
  const bool isThere = ::lstat(path.c_str(), &found) == 0;
  if (isThere && !S_ISSOCK(found.st_mode)) {
    return "cannot listen on unix:" + path +
           ": a file that is no socket has this name. Choose another path with --listen.";
  }
  asio::local::stream_protocol::socket probe(acceptor.get_executor());
  probe.connect(endpoint, error);
  if (!error) {
    return "cannot listen on unix:" + path + ": another server does. Choose another path with --listen.";
  }
  if (isThere && error == asio::error::connection_refused) {
    ::unlink(path.c_str());
  }
  error.clear();
  acceptor.open(endpoint.protocol(), error);
  // only this user may connect
  const mode_t before = ::umask(0177);
  if (!error) {
    acceptor.bind(endpoint, error);
  }
  ::umask(before);
  if (!error) {
    acceptor.listen(asio::socket_base::max_listen_connections, error);
  }
  if (error) {
    return "cannot listen on unix:" + path + ": " + error.message() + ". Choose another path with --listen.";
  }
  return std::nullopt;
}

std::optional<FileIdentity> identityOf(const std::string& path) {
  struct stat found {};
  return ::lstat(path.c_str(), &found) == 0 ? std::optional(FileIdentity(found.st_dev, found.st_ino)) : std::nullopt;
}

std::size_t raiseDescriptorBound(std::size_t wanted) {
  ::rlimit bound{};
  if (::getrlimit(RLIMIT_NOFILE, &bound) != 0) {
    return wanted;
  }
  if (bound.rlim_cur < wanted) {
    const ::rlimit raised{std::min<rlim_t>(wanted, bound.rlim_max), bound.rlim_max};
    if (::setrlimit(RLIMIT_NOFILE, &raised) == 0) {
      bound = raised;
    }
  }
  return static_cast<std::size_t>(bound.rlim_cur);
}

}  // namespace espalier::server
