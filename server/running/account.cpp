#include "server/running/account.h"

#include <algorithm>
#include <cmath>

#include "protocol/json_writer.h"
#include "server/remote/control_group.h"
#include "server/remote/limits.h"

namespace espalier::server {
namespace {

/// 0 in a limit is no bound.
std::uint64_t orNone(std::uint64_t bound) {
  return bound == 0 ? UINT64_MAX : bound;
}

Account::Bounds boundsOfOwner(const ServerLimits& limits) {
  return {.memoryBytes = orNone(limits.accountMemoryBytes),
          .simulations = orNone(limits.accountSimulations),
          .streams = orNone(limits.accountStreams),
          .cpuSeconds = orNone(limits.accountCpuSeconds),
          .traceBytes = orNone(limits.accountTraceBytes)};
}

Account::Bounds boundsOfServer(const ServerLimits& limits) {
  return {.memoryBytes = limits.memoryBytes == 0 ? usableMemoryBytes() : limits.memoryBytes,
          .traceBytes = orNone(limits.traceBytes)};
}

}  // namespace

Account::Account(std::string owner, const Bounds& bounds, Account* parent)
    : owner_(std::move(owner)),
      parent_(parent),
      traceRoom_(parent_ == nullptr ? "all traces together" : "all traces of the account '" + owner_ + "'",
                 parent_ == nullptr ? "traceBytes" : "accountTraceBytes",
                 parent_ == nullptr ? nullptr : &parent_->traceRoom_) {
  setBounds(bounds);
}

void Account::setBounds(const Bounds& bounds) {
  boundBytes_ = bounds.memoryBytes;
  boundSimulations_ = bounds.simulations;
  boundStreams_ = bounds.streams;
  boundCpuSeconds_ = bounds.cpuSeconds;
  traceRoom_.setBound(bounds.traceBytes);
}

bool Account::take(MemoryKind kind, std::uint64_t bytes) {
  if (isFull(memoryBytes_ += bytes)) {
    memoryBytes_ -= bytes;
    return false;
  }
  if (parent_ != nullptr && !parent_->take(kind, bytes)) {
    memoryBytes_ -= bytes;
    return false;
  }
  bytes_[static_cast<std::size_t>(kind)] += static_cast<std::int64_t>(bytes);
  return true;
}

void Account::add(MemoryKind kind, std::int64_t bytes) {
  memoryBytes_ += static_cast<std::uint64_t>(bytes);
  bytes_[static_cast<std::size_t>(kind)] += bytes;
  if (parent_ != nullptr) {
    parent_->add(kind, bytes);
  }
}

std::uint64_t Account::bytes(MemoryKind kind) const {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(bytes_[static_cast<std::size_t>(kind)], 0));
}

protocol::Error Account::memoryError() const {
  // the bound that is nearer
  const auto left = [](const Account& account) {
    const std::uint64_t bound = account.boundBytes_;
    return bound - std::min<std::uint64_t>(account.memoryBytes_, bound);
  };
  const bool isOfOwner = parent_ != nullptr && left(*this) <= left(*parent_);
  const Account& full = isOfOwner || parent_ == nullptr ? *this : *parent_;
  protocol::JsonWriter data;
  const std::string name = isOfOwner ? "accountMemoryBytes" : "memoryBytes";
  data.beginObject().key("limit").text(name).key("value").integer(std::uint64_t{full.memoryBytes_});
  data.key("bound").integer(full.boundBytes_.load()).endObject();
  return {
      protocol::ErrorCode::Limit,
      (isOfOwner ? "the account '" + owner_ + "'" : "all simulations, streams and messages of this server together") +
          (isOfOwner ? " has " : " have ") + std::to_string(full.memoryBytes_.load()) + " of " +
          std::to_string(full.boundBytes_.load()) + " bytes (limit " + name +
          "), and this needs more. Delete simulations, close streams, or start the server with a higher --limit " +
          name + "=N.",
      data.take()};
}

void Account::addSimulations(std::int64_t count) {
  simulations_ += static_cast<std::uint64_t>(count);
  if (parent_ != nullptr) {
    parent_->addSimulations(count);
  }
}

void Account::addStreams(std::int64_t count) {
  streams_ += static_cast<std::uint64_t>(count);
  if (parent_ != nullptr) {
    parent_->addStreams(count);
  }
}

void Account::spend(std::uint64_t nanoseconds) {
  nanoseconds_ += nanoseconds;
  if (parent_ != nullptr) {
    parent_->spend(nanoseconds);
  }
}

bool Account::beginDownload(std::uint64_t most) {
  if (++downloads_ > most) {
    --downloads_;
    return false;
  }
  return true;
}

std::optional<protocol::Error> Account::cpuProblem() const {
  const double spent = cpuSeconds();
  const std::uint64_t bound = boundCpuSeconds_;
  if (spent <= static_cast<double>(bound)) {
    return std::nullopt;
  }
  return protocol::limitError("accountCpuSeconds", static_cast<std::uint64_t>(std::ceil(spent)), bound,
                              "The account '" + owner_ +
                                  "' computes no more until the server is started again with a "
                                  "higher --limit accountCpuSeconds=N.");
}

Accounts::Accounts(const ServerLimits& limits)
    : server_("", boundsOfServer(limits), nullptr), ownerBounds_(boundsOfOwner(limits)) {}

void Accounts::setLimits(const ServerLimits& limits) {
  server_.setBounds(boundsOfServer(limits));
  const std::lock_guard lock(mutex_);
  ownerBounds_ = boundsOfOwner(limits);
  for (const auto& [owner, account] : owners_) {
    account->setBounds(ownerBounds_);
  }
}

Account& Accounts::of(const std::string& token) {
  const std::string owner = token.empty() ? "local" : token;
  const std::lock_guard lock(mutex_);
  std::unique_ptr<Account>& account = owners_[owner];
  if (account == nullptr) {
    account = std::make_unique<Account>(owner, ownerBounds_, &server_);
  }
  return *account;
}

std::vector<const Account*> Accounts::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<const Account*> accounts;
  for (const auto& [owner, account] : owners_) {
    accounts.push_back(account.get());
  }
  return accounts;
}

}  // namespace espalier::server
