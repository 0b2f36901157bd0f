#include "clients/cpp/client.h"

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <deque>
#include <map>

#include "protocol/codec.h"
#include "protocol/framing.h"
#include "protocol/version.h"

namespace espalier::client {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using protocol::Error;
using protocol::ErrorCode;
using Clock = std::chrono::steady_clock;

Error lost(const std::string& what) {
  return {ErrorCode::Internal, "The connection to the server is lost: " + what + ". Connect again.", {}};
}

Error late(std::string_view what, std::chrono::milliseconds timeout) {
  return {ErrorCode::Timeout,
          "No answer to " + std::string(what) + " within " + std::to_string(timeout.count()) + " ms.",
          {}};
}

}  // namespace

class Client::Implementation {
 public:
  explicit Implementation(ClientOptions options)
      : options_(std::move(options)), socket_(context_), reader_(options_.limits) {}

  std::optional<Error> dial(const std::string& address) {
    const std::size_t colon = address.rfind(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == address.size()) {
      return Error{ErrorCode::InvalidParams,
                   "'" + address + "' is not an address; write HOST:PORT, for example 127.0.0.1:4321.",
                   {}};
    }
    std::string host = address.substr(0, colon);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
      host = host.substr(1, host.size() - 2);
    }
    tcp::resolver resolver(context_);
    error_code error;
    const auto found = resolver.resolve(host, address.substr(colon + 1), error);
    if (!error) {
      error = asio::error::timed_out;
      asio::async_connect(socket_, found, [&](const error_code& result, const tcp::endpoint&) { error = result; });
      runFor(options_.connectTimeout);
    }
    if (error) {
      closeSocket();
      return Error{ErrorCode::Internal,
                   "Cannot connect to " + address + ": " + error.message() +
                       ". Start the server (espalier serve) or correct the address.",
                   {}};
    }
    isOpen_ = true;
    error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    return std::nullopt;
  }

  std::optional<Error> write(const std::string& line) {
    if (!isOpen_) {
      return lost("it was closed");
    }
    error_code error;
    asio::write(socket_, asio::buffer(line), error);
    if (error) {
      closeSocket();
      return lost(error.message());
    }
    return std::nullopt;
  }

  /// Takes in one message. False when the time is over or the connection closed.
  bool receive(Clock::time_point deadline) {
    while (isOpen_) {
      if (auto read = reader_.next()) {
        sort(*read);
        return true;
      }
      if (reader_.lost()) {
        reason_ = "the server sent what cannot be read: " + reader_.lost()->message;
        closeSocket();
        return false;
      }
      error_code error = asio::error::would_block;
      std::size_t count = 0;
      socket_.async_read_some(asio::buffer(bytes_), [&](const error_code& result, std::size_t transferred) {
        error = result;
        count = transferred;
      });
      const bool isInTime = runFor(std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now()));
      if (count > 0) {
        reader_.feed({bytes_.data(), count});
        continue;
      }
      if (!isInTime) {
        return false;
      }
      reason_ = error == asio::error::eof ? "the server closed it" : error.message();
      closeSocket();
    }
    return false;
  }

  Outcome waitFor(std::int64_t id, std::string_view what, std::chrono::milliseconds timeout) {
    const auto deadline = Clock::now() + timeout;
    while (true) {
      const auto found = answers_.find(id);
      if (found != answers_.end()) {
        Outcome outcome = std::move(found->second);
        answers_.erase(found);
        return outcome;
      }
      if (!receive(deadline)) {
        if (answers_.contains(id)) {
          continue;
        }
        return isOpen_ ? late(what, timeout) : refusal_.value_or(lost(reason_));
      }
    }
  }

  std::variant<std::int64_t, Error> send(std::string_view method, std::string_view paramsJson) {
    const std::int64_t id = ++lastId_;
    if (auto error = write(protocol::encodeRequest(protocol::MessageId::of(id), method, std::string(paramsJson)))) {
      return std::move(*error);
    }
    return id;
  }

  /// Accepts blocks when the server named them too.
  void agree() {
    const auto capabilities = protocol::memberOf(helloResult_, "capabilities");
    const auto& own = options_.capabilities;
    if (capabilities && capabilities->find("\"bin\"") != std::string::npos &&
        std::find(own.begin(), own.end(), "bin") != own.end()) {
      reader_.allowBlocks();
    }
  }

  void closeSocket() {
    error_code ignored;
    socket_.close(ignored);
    isOpen_ = false;
  }

  ClientOptions options_;
  std::string helloResult_;
  std::deque<Notification> notifications_;
  std::deque<IncomingRequest> requests_;
  bool isOpen_ = false;

 private:
  /// Runs what was started until it is done; cancels it when the time is over and returns false.
  bool runFor(std::chrono::milliseconds time) {
    context_.restart();
    context_.run_for(time.count() > 0 ? time : std::chrono::milliseconds(0));
    if (context_.stopped()) {
      return true;
    }
    error_code ignored;
    socket_.cancel(ignored);
    context_.run();
    return false;
  }

  void sort(protocol::MessageReader::Read& read) {
    auto* message = std::get_if<protocol::Message>(&read);
    if (message == nullptr) {
      return;
    }
    switch (message->kind) {
      case protocol::Message::Kind::Notification:
        notifications_.push_back({std::move(message->method), message->payload.toText(), message->payload});
        break;
      case protocol::Message::Kind::Request:
        requests_.push_back({std::move(message->id), std::move(message->method), std::move(message->payload)});
        break;
      case protocol::Message::Kind::Result:
        answers_.insert_or_assign(message->id.number, message->payload.toText());
        break;
      case protocol::Message::Kind::Error:
        if (message->id.kind == protocol::MessageId::Kind::Number) {
          answers_.insert_or_assign(message->id.number, std::move(message->error));
        } else {
          refusal_ = std::move(message->error);
        }
        break;
    }
  }

  asio::io_context context_;
  tcp::socket socket_;
  protocol::MessageReader reader_;
  std::array<char, 262'144> bytes_{};
  std::map<std::int64_t, Outcome> answers_;  // by request, not yet waited for
  std::optional<Error> refusal_;             // an error without id: why the server closes
  std::string reason_ = "it was closed";
  std::int64_t lastId_ = 0;
};

Client::Client(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
Client::~Client() = default;

std::variant<std::unique_ptr<Client>, Error> Client::connect(const std::string& address, const ClientOptions& options) {
  std::unique_ptr<Client> client(new Client(std::make_unique<Implementation>(options)));
  Implementation& implementation = *client->implementation_;
  if (auto error = implementation.dial(address)) {
    return std::move(*error);
  }
  const protocol::HelloParams hello{
      .protocol = {protocol::kProtocolVersion},
      .roles = options.roles,
      .name = options.name,
      .version = options.version,
      .capabilities = options.capabilities,
      .token = options.token,
      .limits = {{"lineBytes", options.limits.lineBytes}, {"blockBytes", options.limits.blockBytes}}};
  auto sent = implementation.send("hello", protocol::encode(hello));
  if (auto* error = std::get_if<Error>(&sent)) {
    return std::move(*error);
  }
  auto outcome = implementation.waitFor(std::get<std::int64_t>(sent), "hello", options.connectTimeout);
  if (auto* error = std::get_if<Error>(&outcome)) {
    return std::move(*error);
  }
  implementation.helloResult_ = std::move(std::get<std::string>(outcome));
  implementation.agree();
  return client;
}

const std::string& Client::helloResult() const {
  return implementation_->helloResult_;
}

Outcome Client::request(std::string_view method, std::string_view paramsJson) {
  auto sent = send(method, paramsJson);
  if (auto* error = std::get_if<Error>(&sent)) {
    return std::move(*error);
  }
  return implementation_->waitFor(std::get<std::int64_t>(sent), method, implementation_->options_.requestTimeout);
}

std::variant<std::int64_t, Error> Client::send(std::string_view method, std::string_view paramsJson) {
  return implementation_->send(method, paramsJson);
}

Outcome Client::waitFor(std::int64_t id, std::chrono::milliseconds timeout) {
  return implementation_->waitFor(id, "request " + std::to_string(id), timeout);
}

std::optional<Error> Client::notify(std::string_view method, std::string_view paramsJson) {
  return implementation_->write(protocol::encodeNotification(method, std::string(paramsJson)));
}

std::optional<Notification> Client::nextNotification(std::chrono::milliseconds timeout) {
  auto& queue = implementation_->notifications_;
  const auto deadline = Clock::now() + timeout;
  while (queue.empty()) {
    if (!implementation_->receive(deadline)) {
      return std::nullopt;
    }
  }
  Notification next = std::move(queue.front());
  queue.pop_front();
  return next;
}

std::optional<IncomingRequest> Client::nextRequest(std::chrono::milliseconds timeout) {
  auto& queue = implementation_->requests_;
  const auto deadline = Clock::now() + timeout;
  while (queue.empty()) {
    if (!implementation_->receive(deadline)) {
      return std::nullopt;
    }
  }
  IncomingRequest next = std::move(queue.front());
  queue.pop_front();
  return next;
}

std::optional<Error> Client::respond(const protocol::MessageId& id, const protocol::Body& result) {
  return implementation_->write(protocol::encodeResult(id, result));
}

std::optional<Error> Client::respondError(const protocol::MessageId& id, const Error& error) {
  return implementation_->write(protocol::encodeError(id, error));
}

bool Client::isOpen() const {
  return implementation_->isOpen_;
}

void Client::close() {
  implementation_->closeSocket();
}

}  // namespace espalier::client
