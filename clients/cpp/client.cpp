#include "clients/cpp/client.h"

#include <array>
#include <boost/asio.hpp>

#include "clients/cpp/conversation.h"
#include "protocol/codec.h"

namespace espalier::client {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using protocol::Error;

}  // namespace

class Client::Implementation {
 public:
  explicit Implementation(ClientOptions options) : conversation_(std::move(options)), socket_(context_) {}

  std::optional<Error> dial(const std::string& text) {
    auto parsed = parseAddress(text);
    if (!parsed) {
      return std::move(parsed.error());
    }
    const auto& address = *parsed;
    tcp::resolver resolver(context_);
    error_code error;
    const auto found = resolver.resolve(address.host, address.port, error);
    if (!error) {
      error = asio::error::timed_out;
      asio::async_connect(socket_, found, [&](const error_code& result, const tcp::endpoint&) { error = result; });
      runFor(conversation_.options().connectTimeout);
    }
    if (error) {
      closeSocket();
      return notReached(text, error.message());
    }
    isOpen_ = true;
    error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    return std::nullopt;
  }

  std::optional<Error> write(const std::string& line) {
    if (!isOpen_) {
      return lostConnection("it was closed");
    }
    error_code error;
    asio::write(socket_, asio::buffer(line), error);
    if (error) {
      closeSocket();
      return lostConnection(error.message());
    }
    return std::nullopt;
  }

  /// Takes in one message. False when the time is over or the connection closed.
  bool receive(Clock::time_point deadline) {
    while (isOpen_) {
      if (conversation_.takeMessage()) {
        return true;
      }
      if (auto broken = conversation_.broken()) {
        reason_ = std::move(*broken);
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
        conversation_.feed({bytes_.data(), count});
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
      if (auto answer = conversation_.takeAnswer(id)) {
        return std::move(*answer);
      }
      if (!receive(deadline)) {
        return tl::unexpected(isOpen_ ? lateAnswer(what, timeout)
                                      : conversation_.refusal().value_or(lostConnection(reason_)));
      }
    }
  }

  protocol::Expected<std::int64_t> send(std::string_view method, std::string_view paramsJson) {
    const std::int64_t id = conversation_.nextId();
    if (auto error = write(protocol::encodeRequest(protocol::MessageId::of(id), method, std::string(paramsJson)))) {
      return tl::unexpected(std::move(*error));
    }
    return id;
  }

  /// The item of `take`, waiting for messages meanwhile; nothing when the time is over or the connection closed.
  template <typename Take>
  auto waitUntil(std::chrono::milliseconds timeout, Take take) {
    const auto deadline = Clock::now() + timeout;
    auto found = take(conversation_);
    while (!found && receive(deadline)) {
      found = take(conversation_);
    }
    return found;
  }

  void closeSocket() {
    error_code ignored;
    socket_.close(ignored);
    isOpen_ = false;
  }

  Conversation conversation_;
  bool isOpen_ = false;

 private:
  /// Runs the started operation until it ends. When the time is over, cancels it and returns false.
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

  asio::io_context context_;
  tcp::socket socket_;
  std::array<char, 262'144> bytes_{};
  std::string reason_ = "it was closed";
};

Client::Client(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
Client::~Client() = default;

protocol::Expected<std::unique_ptr<Client>> Client::connect(const std::string& address, const ClientOptions& options) {
  std::unique_ptr<Client> client(new Client(std::make_unique<Implementation>(options)));
  Implementation& implementation = *client->implementation_;
  if (auto error = implementation.dial(address)) {
    return tl::unexpected(std::move(*error));
  }
  auto sent = implementation.send("hello", implementation.conversation_.helloJson());
  if (!sent) {
    return tl::unexpected(std::move(sent.error()));
  }
  auto outcome = implementation.waitFor(*sent, "hello", options.connectTimeout);
  if (!outcome) {
    return tl::unexpected(std::move(outcome.error()));
  }
  implementation.conversation_.agree(std::move(*outcome));
  return client;
}

const std::string& Client::helloResult() const {
  return implementation_->conversation_.helloResult();
}

Outcome Client::request(std::string_view method, std::string_view paramsJson) {
  auto sent = send(method, paramsJson);
  if (!sent) {
    return tl::unexpected(std::move(sent.error()));
  }
  return implementation_->waitFor(*sent, method, implementation_->conversation_.options().requestTimeout);
}

protocol::Expected<std::int64_t> Client::send(std::string_view method, std::string_view paramsJson) {
  return implementation_->send(method, paramsJson);
}

Outcome Client::waitFor(std::int64_t id, std::chrono::milliseconds timeout) {
  return implementation_->waitFor(id, "request " + std::to_string(id), timeout);
}

std::optional<Error> Client::notify(std::string_view method, std::string_view paramsJson) {
  return implementation_->write(protocol::encodeNotification(method, std::string(paramsJson)));
}

std::optional<Notification> Client::nextNotification(std::chrono::milliseconds timeout) {
  return implementation_->waitUntil(timeout,
                                    [](Conversation& conversation) { return conversation.takeNotification(); });
}

std::optional<IncomingRequest> Client::nextRequest(std::chrono::milliseconds timeout) {
  return implementation_->waitUntil(timeout, [](Conversation& conversation) { return conversation.takeRequest(); });
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
