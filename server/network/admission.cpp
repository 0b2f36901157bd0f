#include "server/network/admission.h"

#include <algorithm>
#include <utility>

#include "server/remote/limits.h"

namespace espalier::server {
namespace {

// for the data folder, files of models, and environments in other processes
constexpr std::size_t kReservedDescriptors = 256;

}  // namespace

std::size_t AdmissionBounds::neededDescriptors(const ServerLimits& limits) {
  return std::size_t{limits.sessions} + 2 * std::size_t{limits.waitingConnections} + kReservedDescriptors;
}

AdmissionBounds AdmissionBounds::of(const ServerLimits& limits, std::size_t descriptors) {
  AdmissionBounds bounds{limits.sessions, limits.waitingConnections, limits.connectionsPerAddress};
  if (descriptors >= neededDescriptors(limits)) {
    return bounds;
  }
  // half of what is left for sessions, a quarter for those that wait on each side
  const std::size_t left = std::max<std::size_t>(descriptors - std::min(descriptors / 2, kReservedDescriptors), 8);
  bounds.sessions = std::min(bounds.sessions, left / 2);
  bounds.waiting = std::min(bounds.waiting, left / 4);
  return bounds;
}

Admission::Place::Place(Admission& admission, Side side, std::string address)
    : admission_(&admission), side_(side), address_(std::move(address)) {
  auto& queue = admission_->queues_[static_cast<std::size_t>(side_)];
  position_ = queue.insert(queue.end(), this);
  if (!address_.empty()) {
    const std::size_t count = ++admission_->addressCounts_[address_];
    const std::size_t bound = admission_->bounds_.perAddress;
    isBeyondAddressBound_ = bound > 0 && count > bound;
  }
}

Admission::Place::~Place() {
  leaveQueue();
  if (state_ == State::Trusted) {
    --admission_->trustedCount_;
  }
  const auto count = admission_->addressCounts_.find(address_);
  if (count != admission_->addressCounts_.end() && --count->second == 0) {
    admission_->addressCounts_.erase(count);
  }
}

void Admission::Place::leaveQueue() {
  if (state_ == State::Waiting) {
    admission_->queues_[static_cast<std::size_t>(side_)].erase(position_);
  }
}

bool Admission::Place::trust() {
  if (state_ == State::Waiting && admission_->trustedCount_ < admission_->bounds_.sessions) {
    leaveQueue();
    state_ = State::Trusted;
    ++admission_->trustedCount_;
  }
  return state_ == State::Trusted;
}

void Admission::Place::renew() {
  if (state_ == State::Waiting) {
    auto& queue = admission_->queues_[static_cast<std::size_t>(side_)];
    queue.splice(queue.end(), queue, position_);
  }
}

std::unique_ptr<Admission::Place> Admission::enter(Side side, const std::string& address) {
  while (waitingCount(side) > 0 && waitingCount(side) >= bounds_.waiting) {
    evictFirst(side);
  }
  return std::make_unique<Place>(*this, side, address);
}

bool Admission::evictOne() {
  const Side side = waitingCount(Side::Http) > waitingCount(Side::Protocol) ? Side::Http : Side::Protocol;
  if (waitingCount(side) == 0) {
    return false;
  }
  evictFirst(side);
  return true;
}

void Admission::evictFirst(Side side) {
  Place& first = *queues_[static_cast<std::size_t>(side)].front();
  first.leaveQueue();
  first.state_ = Place::State::Evicted;
  // the call may destroy the place
  if (const auto close = std::exchange(first.close_, nullptr)) {
    close();
  }
}

}  // namespace espalier::server
