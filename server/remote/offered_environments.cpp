#include "server/remote/offered_environments.h"

namespace espalier::server {

void PendingCall::complete(LinkOutcome outcome) {
  {
    const std::lock_guard lock(mutex_);
    if (outcome_) {
      return;
    }
    outcome_ = std::move(outcome);
  }
  changed_.notify_all();
}

std::optional<LinkOutcome> PendingCall::wait(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return outcome_.has_value(); });
  return std::move(outcome_);
}

bool OfferedEnvironments::offer(const std::string& name, const std::shared_ptr<AskedPeer>& peer) {
  const std::lock_guard lock(mutex_);
  Offer& offer = offers_[name];
  const auto before = offer.peer.lock();
  offer = {peer, ++lastSerial_};
  return before != nullptr && before != peer;
}

void OfferedEnvironments::withdraw(const AskedPeer* peer) {
  const std::lock_guard lock(mutex_);
  std::erase_if(offers_, [peer](const auto& entry) {
    const auto owner = entry.second.peer.lock();
    return owner == nullptr || owner.get() == peer;
  });
}

std::optional<OfferedEnvironments::Offer> OfferedEnvironments::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = offers_.find(name);
  return found == offers_.end() ? std::nullopt : std::optional<Offer>(found->second);
}

std::vector<std::string> OfferedEnvironments::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, offer] : offers_) {
    names.push_back(name);
  }
  return names;
}

std::string OfferedLink::remedy() const {
  return "Connect it again and offer it as '" + name_ + "', then ask for the step again.";
}

LinkFailure OfferedLink::away() const {
  std::string list;
  for (const std::string& name : offered_->names()) {
    list += (list.empty() ? "" : ", ") + name;
  }
  return {LinkFailure::Kind::Away, "is not connected; offered now: " + (list.empty() ? std::string("none") : list), {}};
}

std::optional<LinkFailure> OfferedLink::connect() {
  return generation() == 0 ? std::optional<LinkFailure>(away()) : std::nullopt;
}

std::uint64_t OfferedLink::generation() const {
  const auto offer = offered_->find(name_);
  return offer && !offer->peer.expired() ? offer->serial : 0;
}

PeerTerms OfferedLink::terms() const {
  const auto offer = offered_->find(name_);
  const auto peer = offer ? offer->peer.lock() : nullptr;
  return peer == nullptr ? PeerTerms{} : peer->terms();
}

LinkOutcome OfferedLink::call(std::string_view method, const protocol::Body& params,
                              std::chrono::milliseconds timeout) {
  const auto offer = offered_->find(name_);
  const auto peer = offer ? offer->peer.lock() : nullptr;
  if (peer == nullptr) {
    return tl::unexpected(away());
  }
  const auto pending = std::make_shared<PendingCall>();
  {
    const std::lock_guard lock(mutex_);
    current_ = pending;
  }
  const std::string id = peer->ask(method, params, pending);
  auto outcome = pending->wait(timeout);
  peer->forget(id);
  {
    const std::lock_guard lock(mutex_);
    current_.reset();
  }
  if (!outcome) {
    return tl::unexpected(LinkFailure{
        LinkFailure::Kind::Timeout, "did not answer within " + std::to_string(timeout.count()) + " ms", {}});
  }
  return std::move(*outcome);
}

void OfferedLink::interrupt() {
  const std::lock_guard lock(mutex_);
  if (current_ != nullptr) {
    current_->fail({LinkFailure::Kind::Interrupted, "was given up with the step", {}});
  }
}

}  // namespace espalier::server
