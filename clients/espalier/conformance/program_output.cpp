#include "clients/espalier/conformance/program_output.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>

extern char** environ;

namespace espalier::conformance {
namespace {

using Clock = std::chrono::steady_clock;

/// A child and the ends of its pipes. Whatever happens, the child and its group are gone in the end.
struct Child {
  pid_t id = -1;
  std::array<int, 2> pipes{-1, -1};  // its output and errors
  bool hasEnded = false;

  ~Child() {
    for (const int pipe : pipes) {
      if (pipe >= 0) {
        ::close(pipe);
      }
    }
    if (id > 0) {
      // also what the program left running
      ::kill(-id, SIGKILL);
      if (!hasEnded) {
        ::waitpid(id, nullptr, 0);
      }
    }
  }
};

std::optional<std::string> start(const std::string& command, const std::string& folder, Child& child) {
  std::array<std::array<int, 2>, 2> pipes{};
  for (std::size_t i = 0; i < 2; ++i) {
    if (::pipe2(pipes[i].data(), O_CLOEXEC) != 0) {
      return std::string("cannot be started: ") + std::strerror(errno);
    }
    child.pipes[i] = pipes[i][0];
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, pipes[0][1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipes[1][1], STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string shell = "/bin/sh";
  std::string option = "-c";
  std::string text = command;
  std::array<char*, 4> arguments{shell.data(), option.data(), text.data(), nullptr};
  const int reason = ::posix_spawn(&child.id, shell.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  ::close(pipes[0][1]);
  ::close(pipes[1][1]);
  if (reason != 0) {
    child.id = -1;
    return std::string("cannot be started: ") + std::strerror(reason);
  }
  return std::nullopt;
}

std::string tooLong(const ProgramLimits& limits) {
  const std::string seconds = std::to_string(static_cast<double>(limits.time.count()) / 1e3);
  return "does not end within " + seconds.substr(0, seconds.find('.') + 2) + " s";
}

// reads both pipes to their ends; a sentence when a limit is reached
std::optional<std::string> readAll(Child& child, const ProgramLimits& limits, Clock::time_point deadline,
                                   std::array<std::string, 2>& texts) {
  std::array<char, 65'536> buffer{};
  while (child.pipes[0] >= 0 || child.pipes[1] >= 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    std::array<pollfd, 2> waiting{pollfd{child.pipes[0], POLLIN, 0}, pollfd{child.pipes[1], POLLIN, 0}};
    if (left <= 0 || ::poll(waiting.data(), waiting.size(), static_cast<int>(left)) == 0) {
      return tooLong(limits);
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (child.pipes[i] < 0 || waiting[i].revents == 0) {
        continue;
      }
      const ssize_t count = ::read(child.pipes[i], buffer.data(), buffer.size());
      if (count == 0 || (count < 0 && errno != EINTR)) {
        ::close(child.pipes[i]);
        child.pipes[i] = -1;
      } else if (count > 0) {
        texts[i].append(buffer.data(), static_cast<std::size_t>(count));
      }
      if (texts[i].size() > limits.outputBytes) {
        return "prints more than " + std::to_string(limits.outputBytes / 1'000'000) + " MB";
      }
    }
  }
  return std::nullopt;
}

// waits for the end of a child that has closed its output
std::optional<int> waitUntil(Child& child, Clock::time_point deadline) {
  for (;;) {
    int status = 0;
    if (::waitpid(child.id, &status, WNOHANG) == child.id) {
      child.hasEnded = true;
      return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    if (Clock::now() >= deadline) {
      return std::nullopt;
    }
    ::poll(nullptr, 0, 1);
  }
}

}  // namespace

tl::expected<ProgramOutput, std::string> runProgram(const std::string& command, const std::string& folder,
                                                    const ProgramLimits& limits) {
  const Clock::time_point deadline = Clock::now() + limits.time;
  Child child;
  if (auto problem = start(command, folder, child)) {
    return tl::unexpected(std::move(*problem));
  }
  std::array<std::string, 2> texts;
  if (auto problem = readAll(child, limits, deadline, texts)) {
    return tl::unexpected(std::move(*problem));
  }
  const std::optional<int> status = waitUntil(child, deadline);
  if (!status) {
    return tl::unexpected(tooLong(limits));
  }
  return ProgramOutput{std::move(texts[0]), std::move(texts[1]), *status};
}

std::string quoted(const std::string& text) {
  std::string word = "'";
  for (const char c : text) {
    word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return word + "'";
}

}  // namespace espalier::conformance
