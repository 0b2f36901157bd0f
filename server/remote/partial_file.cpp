#include "server/remote/partial_file.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace espalier::server {
namespace {

// A signal handler sees nothing but such a table. Files beyond it are removed by their destructors only.
constexpr std::size_t kMostFiles = 256;
std::array<std::atomic<char*>, kMostFiles> namesOfPartialFiles;
std::atomic<pid_t> owningProcess{0};

static_assert(std::atomic<char*>::is_always_lock_free && std::atomic<pid_t>::is_always_lock_free);

// the place of the name in the table; kMostFiles: there is none
std::size_t remember(const std::string& name) {
  char* const copy = ::strdup(name.c_str());
  for (std::size_t slot = 0; copy != nullptr && slot < kMostFiles; ++slot) {
    char* free = nullptr;
    if (namesOfPartialFiles[slot].compare_exchange_strong(free, copy)) {
      return slot;
    }
  }
  std::free(copy);
  return kMostFiles;
}

void forget(std::size_t slot) {
  if (slot < kMostFiles) {
    std::free(namesOfPartialFiles[slot].exchange(nullptr));
  }
}

// calls only functions that are safe in a signal handler
extern "C" void removeAndEnd(int signal) {
  // a child between fork and exec has the table of its parent
  if (::getpid() == owningProcess.load()) {
    for (std::atomic<char*>& slot : namesOfPartialFiles) {
      if (const char* const name = slot.exchange(nullptr); name != nullptr) {
        ::unlink(name);
      }
    }
  }
  // the handler is gone by now, so the signal ends the program as it does without a handler
  ::raise(signal);
}

}  // namespace

PartialFile::PartialFile(std::string name) : name_(std::move(name)), slot_(remember(name_)) {}

PartialFile::~PartialFile() {
  if (!name_.empty()) {
    ::unlink(name_.c_str());
    forget(slot_);
  }
}

int PartialFile::complete(const std::string& whole) {
  if (std::rename(name_.c_str(), whole.c_str()) != 0) {
    return errno;
  }
  forget(slot_);
  name_.clear();
  return 0;
}

void removePartialFilesAtSignal(int signal) {
  owningProcess = ::getpid();
  struct sigaction present {};
  if (::sigaction(signal, nullptr, &present) == 0 && present.sa_handler == SIG_IGN) {
    return;
  }
  struct sigaction action {};
  action.sa_handler = removeAndEnd;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  ::sigemptyset(&action.sa_mask);
  (void)::sigaction(signal, &action, nullptr);
}

void removePartialFilesAtSignals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    removePartialFilesAtSignal(signal);
  }
}

}  // namespace espalier::server
