#include "server/remote/hosting/host_connections.h"

namespace espalier::server {

bool HostConnections::enter(const Socket& socket) {
  const std::lock_guard lock(mutex_);
  if (silent_.size() >= mostSilent_) {
    closeFirst(silent_);
  }
  if (places_.size() >= most_ && !closeFirst(silent_) && !closeFirst(idle_)) {
    return false;
  }
  silent_.push_back(socket);
  places_.insert_or_assign(socket.get(), Place{&silent_, std::prev(silent_.end())});
  return true;
}

bool HostConnections::begin(const Socket& socket) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(socket.get());
  if (found == places_.end()) {
    return false;
  }
  const bool wasSilent = found->second.list == &silent_;
  move(found->second, busy_);
  return wasSilent;
}

void HostConnections::end(const Socket& socket, bool hasSimulations) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(socket.get());
  if (found != places_.end() && found->second.list == &busy_ && !hasSimulations) {
    move(found->second, idle_);
  }
}

void HostConnections::leave(const Socket& socket) {
  const std::lock_guard lock(mutex_);
  if (const auto found = places_.find(socket.get()); found != places_.end()) {
    remove(found);
  }
}

bool HostConnections::leaveSilent(const Socket& socket) {
  const std::lock_guard lock(mutex_);
  const auto found = places_.find(socket.get());
  if (found == places_.end() || found->second.list != &silent_) {
    return false;
  }
  remove(found);
  return true;
}

bool HostConnections::closeOne() {
  const std::lock_guard lock(mutex_);
  return closeFirst(silent_) || closeFirst(idle_);
}

void HostConnections::remove(std::unordered_map<const void*, Place>::iterator place) {
  place->second.list->erase(place->second.position);
  places_.erase(place);
}

void HostConnections::move(Place& place, std::list<Socket>& list) {
  list.splice(list.end(), *place.list, place.position);
  place.list = &list;
}

bool HostConnections::closeFirst(std::list<Socket>& list) {
  if (list.empty()) {
    return false;
  }
  const Socket socket = list.front();
  list.pop_front();
  places_.erase(socket.get());
  // on its own strand
  boost::asio::post(socket->get_executor(), [socket] {
    boost::system::error_code ignored;
    socket->close(ignored);
  });
  return true;
}

}  // namespace espalier::server
