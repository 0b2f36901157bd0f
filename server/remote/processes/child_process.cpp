#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "server/remote/processes/line_channel.h"

extern char** environ;

namespace espalier::server {
namespace {

constexpr std::chrono::milliseconds kTimeToEndByItself{2'000};
constexpr std::chrono::milliseconds kTimeToEndWhenAsked{2'000};

}  // namespace

tl::expected<std::unique_ptr<ChildProcess::Started>, std::string> ChildProcess::start(const std::string& command) {
  return start(std::vector<std::string>{"/bin/sh", "-c", command});
}

tl::expected<std::unique_ptr<ChildProcess::Started>, std::string> ChildProcess::start(std::vector<std::string> words) {
  std::array<int, 2> toChild{-1, -1};
  std::array<int, 2> fromChild{-1, -1};
  if (::pipe2(toChild.data(), O_CLOEXEC) != 0) {
    return tl::unexpected(std::string("cannot make a pipe: ") + std::strerror(errno) + ".");
  }
  Descriptor childInput(toChild[0]);
  Descriptor output(toChild[1]);
  if (::pipe2(fromChild.data(), O_CLOEXEC) != 0) {
    return tl::unexpected(std::string("cannot make a pipe: ") + std::strerror(errno) + ".");
  }
  Descriptor input(fromChild[0]);
  Descriptor childOutput(fromChild[1]);

  // its own process group, so that the children of a shell end with it; default signals; no descriptors of ours
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, childInput.number(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, childOutput.number(), STDOUT_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::vector<char*> arguments;
  for (std::string& word : words) {
    arguments.push_back(word.data());
  }
  arguments.push_back(nullptr);
  pid_t processId = -1;
  const int reason = ::posix_spawn(&processId, arguments.front(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (reason != 0) {
    return tl::unexpected("cannot start '" + words.back() + "': " + std::strerror(reason) + ".");
  }
  return std::unique_ptr<Started>(new Started{ChildProcess(processId), std::move(input), std::move(output)});
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : processId_(std::exchange(other.processId_, -1)), status_(other.status_), hasEnded_(other.hasEnded_) {}

ChildProcess::~ChildProcess() {
  if (processId_ < 0) {
    return;
  }
  const pid_t group = processId_;
  if (!waitFor(kTimeToEndByItself)) {
    ::kill(-group, SIGTERM);
    if (!waitFor(kTimeToEndWhenAsked)) {
      ::kill(-group, SIGKILL);
      (void)waitFor(std::chrono::milliseconds(10'000));
    }
  }
  // children that the shell left behind
  ::kill(-group, SIGTERM);
}

void ChildProcess::end() {
  if (processId_ >= 0) {
    ::kill(-processId_, SIGTERM);
  }
}

bool ChildProcess::waitFor(std::chrono::milliseconds time) {
  if (hasEnded_) {
    return true;
  }
  const Descriptor handle(static_cast<int>(::syscall(SYS_pidfd_open, processId_, 0)));
  if (handle.number() >= 0) {
    pollfd polled{handle.number(), POLLIN, 0};
    const Deadline deadline = std::chrono::steady_clock::now() + time;
    int count = 0;
    do {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
      count = ::poll(&polled, 1, left > 0 ? static_cast<int>(left) : 0);
    } while (count < 0 && errno == EINTR);
    if (count <= 0) {
      return false;
    }
  }
  if (::waitpid(processId_, &status_, handle.number() >= 0 ? 0 : WNOHANG) == processId_) {
    hasEnded_ = true;
    processId_ = -1;
  }
  return hasEnded_;
}

std::string ChildProcess::fate() {
  if (!hasEnded_ && processId_ >= 0) {
    const pid_t group = processId_;
    if (!waitFor(std::chrono::milliseconds(1'000))) {
      return {};
    }
    ::kill(-group, SIGTERM);
  }
  if (WIFSIGNALED(status_)) {
    return "was ended by signal " + std::to_string(WTERMSIG(status_));
  }
  return "ended with status " + std::to_string(WEXITSTATUS(status_));
}

}  // namespace espalier::server
