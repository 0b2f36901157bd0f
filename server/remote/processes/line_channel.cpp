#include "server/remote/processes/line_channel.h"

#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace espalier::server {
namespace {

constexpr int kKeepAliveSeconds = 15;  // of silence, and between probes
// what a peer sends while we write to it: more than answers to one question take
constexpr std::size_t kMostUnread = 64'000'000;

int millisecondsUntil(Deadline deadline) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
  return static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000));
}

void setNonBlocking(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL, 0) | O_NONBLOCK);
}

/// write() to a pipe without SIGPIPE: the signal is held back for this thread and taken away when it came.
ssize_t writeWithoutSignal(int descriptor, std::string_view bytes) {
  sigset_t pipeSignal;
  sigset_t previous;
  sigemptyset(&pipeSignal);
  sigaddset(&pipeSignal, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipeSignal, &previous);
  const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
  const int reason = errno;
  if (written < 0 && reason == EPIPE) {
    const timespec now{0, 0};
    sigtimedwait(&pipeSignal, nullptr, &now);
  }
  pthread_sigmask(SIG_SETMASK, &previous, nullptr);
  errno = reason;
  return written;
}

}  // namespace

void Descriptor::close() {
  if (number_ >= 0) {
    ::close(number_);
    number_ = -1;
  }
}

LineChannel::LineChannel(Descriptor input, Descriptor output, std::size_t maximumLineBytes)
    : input_(std::move(input)),
      output_(std::move(output)),
      wakeUp_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      isOutputSeparate_(output_.number() >= 0),
      splitter_(maximumLineBytes) {
  setNonBlocking(input_.number());
  if (isOutputSeparate_) {
    setNonBlocking(output_.number());
  }
}

LineChannel::Status LineChannel::wait(bool wantsRead, bool wantsWrite, Deadline deadline, bool& canRead,
                                      bool& canWrite) {
  std::array<pollfd, 3> polled{pollfd{isInputEnded_ || !wantsRead ? -1 : input_.number(), POLLIN, 0},
                               pollfd{wantsWrite ? outputNumber() : -1, POLLOUT, 0},
                               pollfd{wakeUp_.number(), POLLIN, 0}};
  const int count = ::poll(polled.data(), polled.size(), millisecondsUntil(deadline));
  if (count < 0 && errno != EINTR) {
    return Status::Closed;
  }
  if (count == 0) {
    return std::chrono::steady_clock::now() < deadline ? Status::Done : Status::Timeout;
  }
  if (count > 0 && polled[2].revents != 0) {
    clearInterruption();
    return Status::Interrupted;
  }
  canRead = count > 0 && polled[0].revents != 0;
  canWrite = count > 0 && polled[1].revents != 0;
  return Status::Done;
}

LineChannel::Status LineChannel::readAvailable() {
  std::array<char, 262'144> bytes;
  const ssize_t count = ::read(input_.number(), bytes.data(), bytes.size());
  if (count > 0) {
    received_.append(bytes.data(), static_cast<std::size_t>(count));
    return Status::Done;
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
    return Status::Done;
  }
  isInputEnded_ = true;
  return Status::Closed;
}

LineChannel::Status LineChannel::write(std::string_view bytes, Deadline deadline) {
  while (!bytes.empty()) {
    const ssize_t count = isOutputSeparate_ ? writeWithoutSignal(output_.number(), bytes)
                                            : ::send(input_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
      continue;
    }
    if (count < 0 && errno != EAGAIN && errno != EINTR) {
      return Status::Closed;
    }
    if (std::chrono::steady_clock::now() >= deadline) {
      return Status::Timeout;
    }
    // the peer may itself be waiting until we read; one that only sends is not read without an end
    bool canRead = false;
    bool canWrite = false;
    const bool wantsRead = received_.size() < kMostUnread;
    if (const Status status = wait(wantsRead, true, deadline, canRead, canWrite); status != Status::Done) {
      return status;
    }
    if (canRead && !isInputEnded_) {
      (void)readAvailable();
    }
  }
  return Status::Done;
}

LineChannel::Status LineChannel::receive(std::string& bytes, Deadline deadline) {
  while (received_.empty()) {
    if (isInputEnded_) {
      return Status::Closed;
    }
    bool canRead = false;
    bool canWrite = false;
    if (const Status status = wait(true, false, deadline, canRead, canWrite); status != Status::Done) {
      return status;
    }
    if (canRead) {
      (void)readAvailable();
    }
  }
  bytes.swap(received_);
  received_.clear();
  return Status::Done;
}

LineChannel::Status LineChannel::readLine(std::string& line, Deadline deadline) {
  std::string bytes;
  for (bool isOver = false;; isOver = std::chrono::steady_clock::now() >= deadline) {
    const std::string_view next = splitter_.next();
    if (next.data() != nullptr) {
      line.assign(next);
      return Status::Done;
    }
    if (splitter_.isOverflowed()) {
      return Status::Overflow;
    }
    if (isOver) {
      return Status::Timeout;
    }
    if (const Status status = receive(bytes, deadline); status != Status::Done) {
      return status;
    }
    splitter_.feed(bytes);
  }
}

void LineChannel::rest() {
  if (received_.empty()) {
    received_.shrink_to_fit();
  }
  splitter_.rest();
}

void LineChannel::interrupt() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wakeUp_.number(), &one, sizeof(one));
}

void LineChannel::clearInterruption() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t taken = ::read(wakeUp_.number(), &count, sizeof(count));
}

void LineChannel::closeOutput() {
  if (isOutputSeparate_) {
    output_.close();
  } else {
    ::shutdown(input_.number(), SHUT_WR);
  }
}

bool splitAddress(std::string_view address, std::string& host, std::uint16_t& port) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string_view::npos || colon == 0) {
    return false;
  }
  std::string_view name = address.substr(0, colon);
  if (name.front() == '[' && name.back() == ']' && name.size() > 2) {
    name = name.substr(1, name.size() - 2);
  } else if (name.find(':') != std::string_view::npos) {
    return false;
  }
  const std::string_view digits = address.substr(colon + 1);
  unsigned value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || result.ec != std::errc() || result.ptr != digits.data() + digits.size() || value > 65535) {
    return false;
  }
  host = name;
  port = static_cast<std::uint16_t>(value);
  return true;
}

tl::expected<Descriptor, std::string> dialTcp(const std::string& address, Deadline deadline) {
  std::string host;
  std::uint16_t port = 0;
  if (!splitAddress(address, host, port) || port == 0) {
    return tl::unexpected("'" + address + "' is not an address; write HOST:PORT, for example 127.0.0.1:4000.");
  }
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int code = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found); code != 0) {
    return tl::unexpected("the host '" + host + "' is unknown (" + ::gai_strerror(code) + "). Check the name.");
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);

  // the first address that answers
  int reason = 0;
  for (const addrinfo* candidate = found; candidate != nullptr; candidate = candidate->ai_next) {
    Descriptor socket(
        ::socket(candidate->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, candidate->ai_protocol));
    if (socket.number() < 0) {
      reason = errno;
      continue;
    }
    if (::connect(socket.number(), candidate->ai_addr, candidate->ai_addrlen) != 0 && errno != EINPROGRESS) {
      reason = errno;
      continue;
    }
    pollfd polled{socket.number(), POLLOUT, 0};
    int count = 0;
    do {
      count = ::poll(&polled, 1, millisecondsUntil(deadline));
    } while (count < 0 && errno == EINTR);
    if (count <= 0) {
      reason = ETIMEDOUT;
      continue;
    }
    socklen_t length = sizeof(reason);
    ::getsockopt(socket.number(), SOL_SOCKET, SO_ERROR, &reason, &length);
    if (reason == 0) {
      const int one = 1;
      ::setsockopt(socket.number(), IPPROTO_TCP, TCP_NODELAY, &one, sizeof(one));
      // a machine that went away without a word is noticed while its answer is waited for
      ::setsockopt(socket.number(), SOL_SOCKET, SO_KEEPALIVE, &one, sizeof(one));
      ::setsockopt(socket.number(), IPPROTO_TCP, TCP_KEEPIDLE, &kKeepAliveSeconds, sizeof(kKeepAliveSeconds));
      ::setsockopt(socket.number(), IPPROTO_TCP, TCP_KEEPINTVL, &kKeepAliveSeconds, sizeof(kKeepAliveSeconds));
      return socket;
    }
  }
  return tl::unexpected("cannot connect to " + address + ": " + std::strerror(reason));
}

tl::expected<Descriptor, std::string> dialUnix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof(address.sun_path)) {
    return tl::unexpected("'" + path + "' is not a socket's path; write unix:PATH with at most " +
                          std::to_string(sizeof(address.sun_path) - 1) + " bytes.");
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  Descriptor socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (socket.number() < 0 ||
      ::connect(socket.number(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      ::fcntl(socket.number(), F_SETFL, O_NONBLOCK) != 0) {
    return tl::unexpected("cannot connect to " + path + ": " + std::strerror(errno));
  }
  return socket;
}

}  // namespace espalier::server
