#include "server/store/durability.h"

namespace espalier::server {

std::string_view nameOf(Durability durability) {
  return durability == Durability::Power ? "power" : "process";
}

std::optional<Durability> durabilityOf(std::string_view name) {
  for (const Durability known : {Durability::Process, Durability::Power}) {
    if (name == nameOf(known)) {
      return known;
    }
  }
  return std::nullopt;
}

int GroupCommit::waitFor(std::uint64_t number) {
  std::unique_lock lock(mutex_);
  while (safe_ < number && failure_ == 0) {
    if (isForcing_) {
      done_.wait(lock);
      continue;
    }
    // this thread asks for all that are committed by now
    isForcing_ = true;
    const std::uint64_t reached = committed_;
    lock.unlock();
    const int outcome = force_();
    ++requestCount_;
    lock.lock();
    isForcing_ = false;
    if (outcome == 0) {
      safe_ = reached;
    } else {
      failure_ = outcome;
    }
    done_.notify_all();
  }
  return failure_;
}

}  // namespace espalier::server
