#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>

namespace espalier::server {

struct ServerLimits;

/// Where a connection came in: the listener of the protocol or the one of HTTP.
enum class Side : std::uint8_t { Protocol, Http };

struct AdmissionBounds {
  std::size_t sessions = 0;    // connections that are trusted
  std::size_t waiting = 0;     // connections of one side that are not
  std::size_t perAddress = 0;  // connections of one address, but loopback; 0: no bound

  /// The bounds that the limits ask for, as far as so many descriptors allow. Some are kept in reserve for files and
  /// environments.
  [[nodiscard]] static AdmissionBounds of(const ServerLimits& limits, std::size_t descriptors);
  /// How many descriptors the limits need, the reserve included.
  [[nodiscard]] static std::size_t neededDescriptors(const ServerLimits& limits);
};

/// Counts the connections of a server. A connection waits until its peer has said hello; then it is trusted. Each side
/// has a number of places for connections that wait. When they are all taken, the next connection closes the one that
/// has waited longest, so silent strangers never lock out a client that says hello. For one thread.
///
///     auto place = admission.enter(Side::Protocol, "192.0.2.7");
///     place->onEvicted([weak] { ... close the connection ... });
///     if (!place->trust()) { ... refuse: there are as many sessions as there may be ... }
class Admission {
 public:
  /// The place of one connection, given back by the destructor. The Admission outlives it.
  class Place {
   public:
    Place(Admission& admission, Side side, std::string address);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    /// `close` closes the connection. Called at most once, when another connection needs the place.
    void onEvicted(std::function<void()> close) { close_ = std::move(close); }
    /// Its address has more connections than it may have. The peer is to be told, then the connection closed.
    [[nodiscard]] bool isBeyondAddressBound() const { return isBeyondAddressBound_; }
    /// The peer may do what it asks for. False: there are as many trusted connections as there may be.
    [[nodiscard]] bool trust();
    [[nodiscard]] const AdmissionBounds& bounds() const { return admission_->bounds_; }
    /// The peer was heard: the others have waited longer now.
    void renew();

   private:
    friend class Admission;
    using Position = std::list<Place*>::iterator;
    enum class State : std::uint8_t { Waiting, Trusted, Evicted };

    void leaveQueue();

    Admission* admission_;
    const Side side_;
    const std::string address_;  // empty: not counted
    std::function<void()> close_;
    Position position_;  // in the queue of the side, while it waits
    State state_ = State::Waiting;
    bool isBeyondAddressBound_ = false;
  };

  void setBounds(const AdmissionBounds& bounds) { bounds_ = bounds; }
  [[nodiscard]] const AdmissionBounds& bounds() const { return bounds_; }

  /// A place for a connection that was just accepted. `address`: of the peer; empty: loopback.
  [[nodiscard]] std::unique_ptr<Place> enter(Side side, const std::string& address);
  /// Closes the connection that has waited longest, of the side with more of them. False: none waits.
  bool evictOne();

  [[nodiscard]] std::size_t trustedCount() const { return trustedCount_; }
  [[nodiscard]] std::size_t waitingCount(Side side) const { return queues_[static_cast<std::size_t>(side)].size(); }

 private:
  void evictFirst(Side side);

  AdmissionBounds bounds_;
  std::array<std::list<Place*>, 2> queues_;           // of each side: those that wait, the longest first
  std::map<std::string, std::size_t> addressCounts_;  // connections of each address
  std::size_t trustedCount_ = 0;
};

}  // namespace espalier::server
