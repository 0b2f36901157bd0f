#pragma once

#include <boost/asio.hpp>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

namespace espalier::server {

/// The open connections of a host, and which of them gives way to a new one. Thread-safe.
///
/// A connection is *silent* until its peer has sent a message, *busy* while it is answered or has simulations, and else
/// *idle*. The silent connection that has waited longest gives way first, then the one that has been idle longest.
/// Busy ones never do: what their simulations have computed would be lost.
class HostConnections {
 public:
  using Socket = std::shared_ptr<boost::asio::ip::tcp::socket>;

  /// `most`: connections at a time, at least 1; `mostSilent`: silent ones among them.
  HostConnections(std::size_t most, std::size_t mostSilent) : most_(most), mostSilent_(mostSilent) {}

  /// A new connection, which is silent. False: all places are taken by busy ones.
  [[nodiscard]] bool enter(const Socket& socket);
  /// Its peer has sent a message, which is answered now. True: that was the first one.
  bool begin(const Socket& socket);
  /// Its peer has its answers.
  void end(const Socket& socket, bool hasSimulations);
  /// It is closed.
  void leave(const Socket& socket);
  /// The same if it is still silent; else false, and it stays.
  [[nodiscard]] bool leaveSilent(const Socket& socket);
  /// One connection gives way. False: all are busy.
  bool closeOne();

  [[nodiscard]] std::size_t most() const { return most_; }

 private:
  struct Place {
    std::list<Socket>* list;  // silent_, idle_ or busy_
    std::list<Socket>::iterator position;
  };
  void remove(std::unordered_map<const void*, Place>::iterator place);
  static void move(Place& place, std::list<Socket>& list);
  bool closeFirst(std::list<Socket>& list);

  std::mutex mutex_;
  std::size_t most_;
  std::size_t mostSilent_;
  // each with the longest first
  std::list<Socket> silent_;
  std::list<Socket> idle_;
  std::list<Socket> busy_;
  std::unordered_map<const void*, Place> places_;  // by socket
};

}  // namespace espalier::server
