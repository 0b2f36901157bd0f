#include "server/remote/offered_environments.h"

#include <algorithm>

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

OfferedEnvironments::Outcome OfferedEnvironments::offer(const std::string& name, const std::shared_ptr<AskedPeer>& peer,
                                                        const std::function<void()>& announce) {
  std::vector<std::weak_ptr<PendingCall>> calls;
  bool isReplacing = false;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = offers_.find(name); found != offers_.end()) {
      const auto before = found->second.offer.peer.lock();
      isReplacing = before != nullptr && before != peer;
      // without tokens everybody has the same, empty owner
      if (isReplacing && !(before->owner().empty() ? before->hasMissedHeartbeat() : before->owner() == peer->owner())) {
        return Outcome::Taken;
      }
      if (isReplacing) {
        calls.swap(found->second.calls);
      }
    }
    announce();
    offers_.insert_or_assign(name, Entry{{peer, ++lastSerial_}, {}});
  }
  for (const auto& weak : calls) {
    if (const auto call = weak.lock()) {
      call->fail({LinkFailure::Kind::Closed, "was replaced by another connection that offers the name", {}});
    }
  }
  return isReplacing ? Outcome::Replaced : Outcome::New;
}

void OfferedEnvironments::withdraw(const AskedPeer* peer) {
  const std::lock_guard lock(mutex_);
  std::erase_if(offers_, [peer](const auto& entry) {
    const auto owner = entry.second.offer.peer.lock();
    return owner == nullptr || owner.get() == peer;
  });
}

std::optional<OfferedEnvironments::Offer> OfferedEnvironments::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = offers_.find(name);
  return found == offers_.end() ? std::nullopt : std::optional<Offer>(found->second.offer);
}

std::optional<OfferedEnvironments::Offer> OfferedEnvironments::find(const std::string& name,
                                                                    const std::shared_ptr<PendingCall>& call) {
  const std::lock_guard lock(mutex_);
  const auto found = offers_.find(name);
  if (found == offers_.end()) {
    return std::nullopt;
  }
  std::erase_if(found->second.calls, [](const auto& each) { return each.expired(); });
  found->second.calls.push_back(call);
  return found->second.offer;
}

std::vector<std::string> OfferedEnvironments::names() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (const auto& [name, offer] : offers_) {
    names.push_back(name);
  }
  return names;
}

std::size_t OfferedEnvironments::count(const AskedPeer* peer) const {
  const std::lock_guard lock(mutex_);
  return static_cast<std::size_t>(std::count_if(offers_.begin(), offers_.end(), [peer](const auto& entry) {
    return entry.second.offer.peer.lock().get() == peer;
  }));
}

std::string OfferedLink::remedy() const {
  return "Connect it again and offer it as '" + name_ + "', then try again.";
}

std::shared_ptr<AskedPeer> OfferedLink::peerOf(const std::optional<OfferedEnvironments::Offer>& offer) const {
  auto peer = offer ? offer->peer.lock() : nullptr;
  return peer != nullptr && owner_ && peer->owner() != *owner_ ? nullptr : peer;
}

LinkFailure OfferedLink::away() const {
  if (const auto offer = offered_->find(name_); offer && offer->peer.lock() != nullptr && peerOf(offer) == nullptr) {
    return {LinkFailure::Kind::Away, "is offered with another token than before ('" + *owner_ + "')", {}};
  }
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
  return peerOf(offer) != nullptr ? offer->serial : 0;
}

PeerTerms OfferedLink::terms() const {
  const auto peer = peerOf(offered_->find(name_));
  return peer == nullptr ? PeerTerms{} : peer->terms();
}

LinkOutcome OfferedLink::call(std::string_view method, const protocol::Body& params,
                              std::chrono::milliseconds timeout) {
  const auto pending = std::make_shared<PendingCall>();
  const auto peer = peerOf(offered_->find(name_, pending));
  if (peer == nullptr) {
    return tl::unexpected(away());
  }
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
  if (*outcome) {
    owner_ = peer->owner();
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
