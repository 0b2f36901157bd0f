#include "server/session/session.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "protocol/codec.h"
#include "protocol/version.h"
#include "server/server_core.h"
#include "server/session/editor_conversation.h"
#include "server/session/methods.h"

namespace espalier::server {
namespace {

// of a peer that gets answers without having said hello
constexpr std::uint32_t kMostLinesBeforeHello = 100;
// smaller messages are not counted: requestsPerSession bounds them
constexpr std::size_t kFreeMessageBytes = 1'000;

/// The memory of a selection.
std::size_t bytesOf(const protocol::StreamSelection& select) {
  std::size_t bytes = select.plants.size() * sizeof(select.plants.front());
  for (const std::string& symbol : select.symbols) {
    bytes += sizeof(symbol) + symbol.size();
  }
  return bytes;
}

}  // namespace

Session::Session(std::string id, ServerCore& core, std::shared_ptr<Connection> connection)
    : id_(std::move(id)), core_(&core), connection_(std::move(connection)) {
  core_->enter(*this);
}

Session::~Session() {
  core_->leave(*this);
}

Account& Session::account() const {
  // a token is one owner, and the programs of this machine together are one
  return core_->accounts().of(std::string(tokenName()));
}

void Session::send(std::string line) {
  connection_->send(std::make_shared<const std::string>(std::move(line)));
}

void Session::respond(const protocol::MessageId& id, std::string_view resultJson) {
  const std::string warned = withWarnings(id, resultJson);
  resultJson = warned.empty() ? resultJson : std::string_view(warned);
  {
    const std::lock_guard lock(mutex_);
    inProgress_.erase(protocol::toText(id));
  }
  const std::uint64_t bound = core_->limits().outboxBytes;
  if (resultJson.size() > bound) {
    send(protocol::encodeError(id, protocol::limitError("outboxBytes", resultJson.size(), bound,
                                                        "Ask for less at a time, or start the server with a higher "
                                                        "--limit outboxBytes=N.")));
    return;
  }
  send(protocol::encodeResult(id, std::string(resultJson)));
}

void Session::warn(const protocol::MessageId& id, std::vector<std::string> warnings) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string>& all = warnings_[protocol::toText(id)];
  all.insert(all.end(), std::make_move_iterator(warnings.begin()), std::make_move_iterator(warnings.end()));
}

std::string Session::withWarnings(const protocol::MessageId& id, std::string_view resultJson) {
  std::vector<std::string> warnings;
  {
    const std::lock_guard lock(mutex_);
    auto found = warnings_.extract(protocol::toText(id));
    if (found.empty() || !resultJson.starts_with('{')) {
      return {};
    }
    warnings = std::move(found.mapped());
  }
  protocol::JsonWriter member;
  member.beginObject().key("warnings").texts(warnings);
  std::string text(member.view());
  resultJson.remove_prefix(1);
  return text + (resultJson == "}" ? "" : ",") + std::string(resultJson);
}

bool Session::isStrict() const {
  const std::lock_guard lock(mutex_);
  return isStrict_;
}

void Session::respondError(const protocol::MessageId& id, const protocol::Error& error) {
  {
    const std::lock_guard lock(mutex_);
    inProgress_.erase(protocol::toText(id));
  }
  static_cast<void>(withWarnings(id, {}));
  core_->log().debug("request " + protocol::toText(id) + ": " + error.message, {.session = id_});
  send(protocol::encodeError(id, error));
}

void Session::notify(std::string_view method, const protocol::Body& params) {
  send(protocol::encodeNotification(method, params));
}

void Session::refuse(const protocol::MessageId& id, const protocol::Error& error) {
  core_->log().info(connection_->peerName() + " is refused: " + error.message, {.session = id_, .token = tokenName()});
  send(protocol::encodeError(id, error));
  connection_->closeWhenSent();
}

void Session::onRead(const protocol::MessageReader::Read& read, std::size_t bytes) {
  // a stranger's flood of short lines would keep the network thread from others
  if (!isGreeted_ && ++linesBeforeHello_ > kMostLinesBeforeHello) {
    if (linesBeforeHello_ == kMostLinesBeforeHello + 1) {
      refuse({}, {protocol::ErrorCode::HelloMissing,
                  std::to_string(kMostLinesBeforeHello) +
                      " messages came, and none was a hello that holds. Connect again and say hello first.",
                  {}});
    }
    return;
  }
  if (!read) {
    respondError(read.error().id, read.error().error);
    // a step may be waiting for this line as its answer
    failPendingCalls(
        {LinkFailure::Kind::Garbage, "sent a line that is not a message: " + read.error().error.message, {}});
    return;
  }
  onMessage(*read, bytes);
}

void Session::onMessage(const protocol::Message& message, std::size_t bytes) {
  {
    const std::lock_guard lock(mutex_);
    isHeartbeatOwed_ = false;
  }
  ++core_->metrics.requests;
  if (message.kind == protocol::Message::Kind::Result || message.kind == protocol::Message::Kind::Error) {
    onAnswer(message);
    return;
  }
  if (message.method == "hello") {
    onHello(message);
    return;
  }
  if (!isGreeted_) {
    if (message.kind == protocol::Message::Kind::Request) {
      respondError(message.id,
                   {protocol::ErrorCode::HelloMissing,
                    "Say hello first: {\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"hello\",\"params\":{\"protocol\":[1],"
                    "\"roles\":[\"controller\"],\"name\":\"...\",\"version\":\"...\"}}.",
                    {}});
    }
    return;
  }
  if (const auto problem = core_->access().problemOf(grant_)) {
    refuse(message.id, {protocol::ErrorCode::Unauthorised, *problem, {}});
    return;
  }
  if (message.kind == protocol::Message::Kind::Request) {
    protocol::Expected<std::shared_ptr<void>> memory;
    if (bytes > kFreeMessageBytes) {
      memory = reserve(MemoryKind::Decoding, bytes);
    }
    std::optional<protocol::Error> refusal;
    if (!memory) {
      refusal = std::move(memory.error());
    } else {
      const std::lock_guard lock(mutex_);
      const std::uint64_t bound = core_->limits().requestsPerSession;
      if (inProgress_.size() >= bound) {
        refusal = protocol::limitError("requestsPerSession", inProgress_.size() + 1, bound,
                                       "Wait for answers before asking more.");
      } else if (!inProgress_.emplace(protocol::toText(message.id), InProgress{{}, std::move(*memory)}).second) {
        refusal = protocol::Error{protocol::ErrorCode::InvalidRequest,
                                  "The id " + protocol::toText(message.id) +
                                      " belongs to a request in progress. Give each request an id of its own.",
                                  {}};
      }
    }
    if (refusal) {
      send(protocol::encodeError(message.id, *refusal));
      return;
    }
  }
  dispatch(*this, message);
}

protocol::Expected<std::shared_ptr<void>> Session::reserve(MemoryKind kind, std::size_t bytes) {
  Account& owner = account();
  if (!owner.take(kind, bytes)) {
    return tl::unexpected(owner.memoryError());
  }
  return std::shared_ptr<void>(nullptr,
                               [&owner, kind, bytes](void*) { owner.add(kind, -static_cast<std::int64_t>(bytes)); });
}

void Session::holdForRequest(const protocol::MessageId& id, std::size_t bytes) {
  // the worker that decoded it had taken it from the account
  Account& owner = account();
  const auto size = static_cast<std::int64_t>(bytes);
  owner.add(MemoryKind::Decoding, size);
  std::shared_ptr<void> memory(nullptr, [&owner, size](void*) { owner.add(MemoryKind::Decoding, -size); });
  const std::lock_guard lock(mutex_);
  if (const auto found = inProgress_.find(protocol::toText(id)); found != inProgress_.end()) {
    found->second.memory = std::move(memory);
  }
}

void Session::onAnswer(const protocol::Message& message) {
  std::shared_ptr<PendingCall> call;
  if (message.id.kind == protocol::MessageId::Kind::Text) {
    const std::lock_guard lock(mutex_);
    const auto found = pending_.find(message.id.text);
    if (found != pending_.end()) {
      call = found->second;
      pending_.erase(found);
    }
  }
  if (call == nullptr) {
    // the question timed out, or there was none
    core_->log().debug("answers " + protocol::toText(message.id) + ", but no question waits for it", {.session = id_});
    return;
  }
  if (message.kind == protocol::Message::Kind::Result) {
    call->complete(message.payload);
  } else {
    call->fail(refusedWith(message.error));
  }
}

void Session::onHello(const protocol::Message& message) {
  if (message.kind != protocol::Message::Kind::Request) {
    return;
  }
  if (isGreeted_) {
    respondError(message.id, {protocol::ErrorCode::InvalidRequest,
                              "Hello was said already on this connection. Go on with other requests.",
                              {}});
    return;
  }
  auto decoded = protocol::decodeHelloParams(message.payload);
  if (!decoded) {
    respondError(message.id, decoded.error());
    return;
  }
  const auto& hello = *decoded;
  if (std::find(hello.protocol.begin(), hello.protocol.end(), protocol::kProtocolVersion) == hello.protocol.end()) {
    protocol::JsonWriter data;
    data.beginObject().key("supported").beginArray().integer(protocol::kProtocolVersion).endArray().endObject();
    refuse(message.id,
           {protocol::ErrorCode::Version,
            "No common protocol version: this server speaks 1. Use a client that speaks espalier/1.", data.take()});
    return;
  }
  auto grant = core_->access().grant(hello.token, hello.roles);
  if (!grant) {
    refuse(message.id, {protocol::ErrorCode::Unauthorised, std::move(grant.error()), {}});
    return;
  }
  // the connection counts for the account of the token from then on
  grant_ = std::move(*grant);
  if (const auto refusal = connection_->admit()) {
    refuse(message.id, *refusal);
    return;
  }
  isGreeted_ = true;
  {
    const std::lock_guard lock(mutex_);
    terms_ = termsOf(hello.capabilities, hello.limits);
    isStrict_ = std::find(hello.capabilities.begin(), hello.capabilities.end(), "strict") != hello.capabilities.end();
    takesHeartbeats_ =
        std::find(hello.capabilities.begin(), hello.capabilities.end(), "heartbeat") != hello.capabilities.end();
  }
  core_->log().info((hello.name.empty() ? std::string("a peer") : hello.name) +
                        (hello.version.empty() ? "" : " " + hello.version) + " from " + connection_->peerName() +
                        " has the role " + grant_.roles.text(),
                    {.session = id_, .token = tokenName()});
  std::vector<std::pair<std::string, std::uint64_t>> limits;
  for (const LimitEntry& entry : limitEntries()) {
    limits.emplace_back(entry.name, entry.get(core_->limits()));
  }
  const protocol::HelloResult result{.protocol = protocol::kProtocolVersion,
                                     .session = id_,
                                     .server = "espalier " + std::string(protocol::kProgramVersion),
                                     .roles = grant_.roles.names(),
                                     .capabilities = {"bin", "checkpoint", "cancel", "streams", "credits", "delta",
                                                      "offer", "geometry", "iterate", "heartbeat", "strict"},
                                     .limits = std::move(limits)};
  respond(message.id, protocol::encode(result));
}

void Session::onLost(const protocol::Error& error) {
  refuse({}, error);
}

void Session::onHandshakeTimeout() {
  if (!isGreeted_) {
    const std::uint32_t bound = core_->limits().handshakeMilliseconds;
    protocol::JsonWriter data;
    data.beginObject().key("milliseconds").integer(bound).endObject();
    refuse({},
           {protocol::ErrorCode::Timeout,
            "No hello came within " + std::to_string(bound) + " ms. Connect again and say hello first.", data.take()});
  }
}

bool Session::onHeartbeat(bool wasHeard) {
  std::string id;
  {
    const std::lock_guard lock(mutex_);
    // a peer that computes a step may be silent: a step has a limit of its own
    if (!takesHeartbeats_ || wasHeard || !pending_.empty()) {
      isHeartbeatOwed_ = false;
      return true;
    }
    if (isHeartbeatOwed_) {
      return false;
    }
    isHeartbeatOwed_ = true;
    id = "h" + std::to_string(++heartbeatCount_);
  }
  send(protocol::encodeRequest(protocol::MessageId::of(id), "ping", "{}"));
  return true;
}

bool Session::checkAccess() {
  const auto problem = core_->access().problemOf(grant_);
  if (problem) {
    refuse({}, {protocol::ErrorCode::Unauthorised, *problem, {}});
  }
  return !problem;
}

bool Session::hasMissedHeartbeat() const {
  const std::lock_guard lock(mutex_);
  return isHeartbeatOwed_;
}

void Session::onDrained() {
  std::vector<std::shared_ptr<SimulationRunner>> runners;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [name, entry] : streams_) {
      auto runner = entry.runner.lock();
      if (runner != nullptr && entry.stream->wantsToCatchUp()) {
        runners.push_back(std::move(runner));
      }
    }
  }
  for (const auto& runner : runners) {
    runner->catchUp();
  }
}

void Session::failPendingCalls(const LinkFailure& failure) {
  std::map<std::string, std::shared_ptr<PendingCall>> calls;
  {
    const std::lock_guard lock(mutex_);
    calls.swap(pending_);
  }
  for (const auto& [id, call] : calls) {
    call->fail(failure);
  }
}

void Session::onPeerEnded() {
  {
    const std::lock_guard lock(mutex_);
    isEnded_ = true;
  }
  core_->offered().withdraw(this);
  failPendingCalls({LinkFailure::Kind::Closed, "closed the connection", {}});
}

bool Session::isAnswering() const {
  const std::lock_guard lock(mutex_);
  return !inProgress_.empty();
}

void Session::onClosed() {
  onPeerEnded();
  std::map<std::string, InProgress> requests;
  {
    const std::lock_guard lock(mutex_);
    isClosed_ = true;
    requests.swap(inProgress_);
    for (const auto& [name, entry] : streams_) {
      entry.stream->close();
    }
    streams_.clear();
  }
  // a request ends with its connection, also within a step: a peer that has left keeps no worker busy
  for (const auto& [id, request] : requests) {
    if (request.cancel) {
      request.cancel();
    }
  }
  core_->log().debug("closed", {.session = id_});
}

PeerTerms Session::terms() const {
  const std::lock_guard lock(mutex_);
  return terms_;
}

std::string Session::ask(std::string_view method, const protocol::Body& params, std::shared_ptr<PendingCall> call) {
  const std::uint64_t bytes = params.json.size() + params.blocks.totalBytes();
  if (const std::uint64_t bound = core_->limits().outboxBytes; bytes > bound) {
    call->fail({LinkFailure::Kind::Refused,
                "was not asked: " + std::to_string(bytes) +
                    " bytes are more than a session may have on their way (outboxBytes=" + std::to_string(bound) +
                    "; espalier serve --limit outboxBytes=N raises it)",
                {protocol::ErrorCode::InvalidParams, {}, {}}});
    return {};
  }
  std::string id;
  bool isGone = false;
  {
    const std::lock_guard lock(mutex_);
    id = "s" + std::to_string(++askedCount_);
    isGone = isClosed_ || isEnded_;
    if (!isGone) {
      pending_.emplace(id, call);
    }
  }
  if (isGone) {
    call->fail({LinkFailure::Kind::Closed, "closed the connection", {}});
  } else {
    send(protocol::encodeRequest(protocol::MessageId::of(id), method, params));
  }
  return id;
}

void Session::forget(const std::string& id) {
  const std::lock_guard lock(mutex_);
  pending_.erase(id);
}

void Session::submit(const protocol::MessageId& id, std::shared_ptr<SimulationRunner> runner,
                     std::shared_ptr<Command> command) {
  onCancel(id, [weakRunner = std::weak_ptr(runner), weakCommand = std::weak_ptr(command)] {
    const auto owner = weakRunner.lock();
    const auto submitted = weakCommand.lock();
    if (owner != nullptr && submitted != nullptr) {
      owner->cancel(submitted);
    }
  });
  runner->submit(std::move(command));
}

void Session::onCancel(const protocol::MessageId& id, std::function<void()> cancel) {
  const std::lock_guard lock(mutex_);
  inProgress_[protocol::toText(id)].cancel = std::move(cancel);
}

std::shared_ptr<EditorConversation> Session::editor() {
  const std::lock_guard lock(mutex_);
  if (editor_ == nullptr) {
    // its documents may take long to destroy, and the last reference may be dropped on the network's thread
    const auto destroyOnWorker = [core = core_](EditorConversation* done) {
      core->pool().post({.run = [done] { delete done; }, .owner = "closing"});
    };
    editor_ = std::shared_ptr<EditorConversation>(new EditorConversation(account()), destroyOnWorker);
  }
  return editor_;
}

void Session::cancelRequest(const protocol::MessageId& id) {
  std::function<void()> cancel;
  {
    const std::lock_guard lock(mutex_);
    const auto found = inProgress_.find(protocol::toText(id));
    if (found == inProgress_.end()) {
      return;
    }
    cancel = found->second.cancel;
  }
  if (cancel) {
    cancel();
  }
}

protocol::Expected<std::shared_ptr<Stream>> Session::openStream(protocol::StreamOpenParams params,
                                                                SimulationRunner& runner) {
  const ServerLimits& limits = core_->limits();
  Account& owner = account();
  const std::lock_guard lock(mutex_);
  // streams that ended by themselves do not count
  if (streams_.size() >= limits.streamsPerSession || owner.streams() >= owner.bounds().streams) {
    std::erase_if(streams_, [](const auto& entry) { return entry.second.stream->isClosed(); });
  }
  if (isClosed_ || streams_.size() >= limits.streamsPerSession) {
    const std::uint64_t bound = limits.streamsPerSession;
    return tl::unexpected(protocol::limitError("streamsPerSession", bound + 1, bound, "Close one first."));
  }
  if (const std::uint64_t bound = owner.bounds().streams; owner.streams() >= bound) {
    return tl::unexpected(protocol::limitError("accountStreams", bound + 1, bound, "Close one first."));
  }
  auto memory = reserve(MemoryKind::Frames, bytesOf(params.select));
  if (!memory) {
    return tl::unexpected(std::move(memory.error()));
  }
  std::string name = "stream-" + id_ + "-" + std::to_string(++streamCount_);
  auto stream =
      std::make_shared<Stream>(name, std::move(params), weak_from_this(), static_cast<std::size_t>(limits.outboxBytes));
  owner.addStreams(1);
  std::shared_ptr<void> place(nullptr, [&owner, memory = std::move(*memory)](void*) { owner.addStreams(-1); });
  streams_.emplace(std::move(name), OpenStream{stream, runner.weak_from_this(), std::move(place)});
  return stream;
}

std::shared_ptr<Stream> Session::findStream(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = streams_.find(id);
  return found == streams_.end() ? nullptr : found->second.stream;
}

bool Session::closeStream(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto found = streams_.find(id);
  if (found == streams_.end()) {
    return false;
  }
  found->second.stream->close();
  streams_.erase(found);
  return true;
}

}  // namespace espalier::server
