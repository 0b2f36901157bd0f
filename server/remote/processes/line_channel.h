#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "protocol/framing.h"

namespace espalier::server {

using Deadline = std::chrono::steady_clock::time_point;

/// A file descriptor that is closed with its owner. -1: none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  [[nodiscard]] int number() const { return number_; }
  void close();

 private:
  int number_ = -1;
};

/// Bytes to and from another process over two descriptors, or over one socket. The calling thread waits. Everything has
/// a deadline, also when the peer sends without an end. Writing reads too, up to 64 MB, so two sides that write at once
/// do not block each other. Writing raises no SIGPIPE.
class LineChannel {
 public:
  enum class Status : std::uint8_t { Done, Timeout, Closed, Interrupted, Overflow };

  LineChannel(Descriptor input, Descriptor output, std::size_t maximumLineBytes);

  [[nodiscard]] Status write(std::string_view bytes, Deadline deadline);
  /// Replaces `bytes` by received bytes, at least one. Bytes that are there are received even after the deadline.
  [[nodiscard]] Status receive(std::string& bytes, Deadline deadline);
  /// The next line. Not together with receive().
  [[nodiscard]] Status readLine(std::string& line, Deadline deadline);
  /// Gives back memory. For a caller that may not use the channel for long.
  void rest();
  /// From any thread: a write or readLine that waits now ends with Interrupted.
  void interrupt();
  /// Forgets an interruption that came between two calls.
  void clearInterruption();
  /// No more output: the peer reads the end of its input.
  void closeOutput();

 private:
  /// Waits for the descriptors; Done when something can be done.
  [[nodiscard]] Status wait(bool wantsRead, bool wantsWrite, Deadline deadline, bool& canRead, bool& canWrite);
  [[nodiscard]] Status readAvailable();
  [[nodiscard]] int outputNumber() const { return output_.number() >= 0 ? output_.number() : input_.number(); }

  Descriptor input_;
  Descriptor output_;  // none: a socket, also written through input_
  Descriptor wakeUp_;  // eventfd
  bool isOutputSeparate_;
  bool isInputEnded_ = false;
  std::string received_;  // and not yet given out
  protocol::LineSplitter splitter_;
};

/// Connects a TCP socket. An error sentence when that fails before the deadline. `address` is HOST:PORT or [IPV6]:PORT.
[[nodiscard]] tl::expected<Descriptor, std::string> dialTcp(const std::string& address, Deadline deadline);

/// Connects a socket of the file system. An error sentence when that fails.
[[nodiscard]] tl::expected<Descriptor, std::string> dialUnix(const std::string& path);

/// Splits HOST:PORT. False when it is not of that form.
[[nodiscard]] bool splitAddress(std::string_view address, std::string& host, std::uint16_t& port);

/// A child process with pipes to its standard input and output. It has no other descriptor of this process but standard
/// error. The destructor ends it: it closes
/// the input, then sends SIGTERM, then SIGKILL.
class ChildProcess {
 public:
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();

  /// The child and the parent's ends of the pipes, or an error sentence.
  struct Started;
  /// The shell runs the command.
  [[nodiscard]] static tl::expected<std::unique_ptr<Started>, std::string> start(const std::string& command);
  /// Starts a program without a shell. The first word is the path of its file, the others are its arguments.
  [[nodiscard]] static tl::expected<std::unique_ptr<Started>, std::string> start(std::vector<std::string> words);

  /// Asks it to end at once (SIGTERM), as the destructor would after waiting.
  void end();
  /// How it ended, "ended with status 3" or "was ended by signal 9", or empty while it runs.
  [[nodiscard]] std::string fate();

 private:
  explicit ChildProcess(int processId) : processId_(processId) {}
  /// Whether it ended within the time.
  [[nodiscard]] bool waitFor(std::chrono::milliseconds time);

  int processId_ = -1;  // -1: reaped
  int status_ = 0;
  bool hasEnded_ = false;
};

struct ChildProcess::Started {
  ChildProcess process;
  Descriptor input;   // the child writes to it
  Descriptor output;  // the child reads from it
};

}  // namespace espalier::server
