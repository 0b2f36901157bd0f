#include "clients/cpp/coroutine_client.h"

#include <array>
#include <boost/asio.hpp>
#include <deque>
#include <map>

#include "clients/cpp/conversation.h"
#include "protocol/codec.h"

namespace espalier::client {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using protocol::Error;

namespace {

// a coroutine may also wait for these; the ids of requests begin at 1
constexpr std::int64_t kNotification = 0;
constexpr std::int64_t kRequest = -1;

}  // namespace

/// Owned by the client and by every coroutine that works for it, so that it outlives the last of them.
class CoroutineClient::State : public std::enable_shared_from_this<State> {
 public:
  State(asio::any_io_executor executor, ClientOptions options)
      : conversation_(std::move(options)), executor_(executor), socket_(executor), resolver_(executor) {}

  asio::awaitable<std::optional<Error>> dial(std::string text) {
    auto parsed = parseAddress(text);
    if (!parsed) {
      co_return std::move(parsed.error());
    }
    const Address address = *parsed;
    asio::steady_timer timer(executor_, conversation_.options().connectTimeout);
    bool isLate = false;
    timer.async_wait([self = shared_from_this(), &isLate](const error_code& cancelled) {
      if (!cancelled) {
        isLate = true;
        self->resolver_.cancel();
        self->closeSocket("it took too long");
      }
    });
    error_code error;
    const auto found =
        co_await resolver_.async_resolve(address.host, address.port, asio::redirect_error(asio::use_awaitable, error));
    if (!error) {
      co_await asio::async_connect(socket_, found, asio::redirect_error(asio::use_awaitable, error));
    }
    timer.cancel();
    if (error || isLate) {
      closeSocket("it was never made");
      co_return notReached(text, isLate ? "it does not answer in time" : error.message());
    }
    isOpen_ = true;
    socket_.set_option(tcp::no_delay(true), error);
    asio::co_spawn(executor_, read(shared_from_this()), asio::detached);
    co_return std::nullopt;
  }

  asio::awaitable<Outcome> request(std::string method, std::string paramsJson, std::chrono::milliseconds timeout) {
    if (!isOpen_) {
      co_return tl::unexpected(lostConnection(reason_));
    }
    const std::int64_t id = conversation_.nextId();
    post(protocol::encodeRequest(protocol::MessageId::of(id), method, std::move(paramsJson)));
    const auto deadline = Clock::now() + timeout;
    try {
      while (true) {
        if (auto answer = conversation_.takeAnswer(id)) {
          co_return std::move(*answer);
        }
        if (!isOpen_) {
          co_return tl::unexpected(conversation_.refusal().value_or(lostConnection(reason_)));
        }
        if (Clock::now() >= deadline) {
          break;
        }
        co_await wait(id, deadline);
      }
    } catch (const boost::system::system_error&) {
      abandon(id);
      throw;
    }
    abandon(id);
    co_return tl::unexpected(lateAnswer(method, timeout));
  }

  /// The item that `take` finds; nothing once the connection has closed.
  template <typename Item>
  asio::awaitable<std::optional<Item>> next(std::int64_t what, std::optional<Item> (Conversation::*take)()) {
    auto found = (conversation_.*take)();
    while (!found && isOpen_) {
      co_await wait(what, Clock::time_point::max());
      found = (conversation_.*take)();
    }
    co_return found;
  }

  /// Queues bytes to be sent.
  void post(std::string bytes) {
    if (!isOpen_) {
      return;
    }
    outbox_.push_back(std::move(bytes));
    if (!isWriting_) {
      isWriting_ = true;
      asio::co_spawn(executor_, write(shared_from_this()), asio::detached);
    }
  }

  void closeSocket(const std::string& reason) {
    if (isOpen_) {
      isOpen_ = false;
      reason_ = reason;
    }
    error_code ignored;
    socket_.close(ignored);
    for (const auto& [what, timer] : waiting_) {
      timer->cancel();
    }
  }

  Conversation conversation_;
  bool isOpen_ = false;

 private:
  /// Waits until the message that `what` names has come, the connection has closed, or the time is over.
  asio::awaitable<void> wait(std::int64_t what, Clock::time_point deadline) {
    asio::steady_timer timer(executor_, deadline);
    const auto place = waiting_.emplace(what, &timer);
    const std::shared_ptr<void> leave(nullptr, [this, place](void*) { waiting_.erase(place); });
    error_code woken;
    co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, woken));
  }

  /// The answer is not needed any more: the server may stop.
  void abandon(std::int64_t id) {
    conversation_.forget(id);
    post(protocol::encodeNotification("$/cancel", "{\"id\":" + std::to_string(id) + "}"));
  }

  asio::awaitable<void> read([[maybe_unused]] std::shared_ptr<State> self) {
    std::string reason;
    while (isOpen_) {
      while (conversation_.takeMessage()) {
      }
      wake();
      if (auto broken = conversation_.broken()) {
        closeSocket(*broken);
        break;
      }
      error_code error;
      const std::size_t count =
          co_await socket_.async_read_some(asio::buffer(bytes_), asio::redirect_error(asio::use_awaitable, error));
      if (error) {
        closeSocket(error == asio::error::eof ? "the server closed it" : error.message());
        break;
      }
      conversation_.feed({bytes_.data(), count});
    }
  }

  /// Wakes the coroutines whose answers came, and those that wait for notifications or requests.
  void wake() {
    for (const auto& [what, timer] : waiting_) {
      if (what <= 0 || conversation_.hasAnswer(what)) {
        timer->cancel();
      }
    }
  }

  asio::awaitable<void> write([[maybe_unused]] std::shared_ptr<State> self) {
    while (!outbox_.empty() && isOpen_) {
      const std::string bytes = std::move(outbox_.front());
      outbox_.pop_front();
      error_code error;
      co_await asio::async_write(socket_, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, error));
      if (error) {
        closeSocket(error.message());
      }
    }
    isWriting_ = false;
  }

  asio::any_io_executor executor_;
  tcp::socket socket_;
  tcp::resolver resolver_;
  std::array<char, 262'144> bytes_{};
  std::deque<std::string> outbox_;
  std::multimap<std::int64_t, asio::steady_timer*> waiting_;  // timers of the waiting coroutines
  std::string reason_ = "it was closed";
  bool isWriting_ = false;
};

CoroutineClient::CoroutineClient(std::shared_ptr<State> state) : state_(std::move(state)) {}

CoroutineClient::~CoroutineClient() {
  state_->closeSocket("it was closed");
}

asio::awaitable<CoroutineClient::Connected> CoroutineClient::connect(std::string address, ClientOptions options) {
  auto state = std::make_shared<State>(co_await asio::this_coro::executor, std::move(options));
  if (auto error = co_await state->dial(std::move(address))) {
    co_return tl::unexpected(std::move(*error));
  }
  auto outcome =
      co_await state->request("hello", state->conversation_.helloJson(), state->conversation_.options().connectTimeout);
  if (!outcome) {
    state->closeSocket("it was closed");
    co_return tl::unexpected(std::move(outcome.error()));
  }
  state->conversation_.agree(std::move(*outcome));
  co_return std::unique_ptr<CoroutineClient>(new CoroutineClient(std::move(state)));
}

asio::awaitable<CoroutineClient::Connected> CoroutineClient::connect(std::string address) {
  return connect(std::move(address), ClientOptions());
}

const std::string& CoroutineClient::helloResult() const {
  return state_->conversation_.helloResult();
}

// the coroutines of the state keep it alive, also when the client goes away meanwhile

asio::awaitable<Outcome> CoroutineClient::request(std::string method, std::string paramsJson) {
  const auto state = state_;
  co_return co_await state->request(std::move(method), std::move(paramsJson),
                                    state->conversation_.options().requestTimeout);
}

void CoroutineClient::notify(std::string_view method, std::string_view paramsJson) {
  state_->post(protocol::encodeNotification(method, std::string(paramsJson)));
}

asio::awaitable<std::optional<Notification>> CoroutineClient::nextNotification() {
  const auto state = state_;
  co_return co_await state->next<Notification>(kNotification, &Conversation::takeNotification);
}

asio::awaitable<std::optional<IncomingRequest>> CoroutineClient::nextRequest() {
  const auto state = state_;
  co_return co_await state->next<IncomingRequest>(kRequest, &Conversation::takeRequest);
}

void CoroutineClient::respond(const protocol::MessageId& id, const protocol::Body& result) {
  state_->post(protocol::encodeResult(id, result));
}

void CoroutineClient::respondError(const protocol::MessageId& id, const Error& error) {
  state_->post(protocol::encodeError(id, error));
}

bool CoroutineClient::isOpen() const {
  return state_->isOpen_;
}

void CoroutineClient::close() {
  state_->closeSocket("it was closed");
}

}  // namespace espalier::client
