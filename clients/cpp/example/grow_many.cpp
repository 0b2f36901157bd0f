// Grows several plants at once over one connection, as coroutines: grow_many HOST:PORT
#include <boost/asio.hpp>
#include <iostream>

#include "clients/cpp/coroutine_client.h"
#include "protocol/json_text.h"

namespace asio = boost::asio;
using espalier::client::CoroutineClient;
using espalier::protocol::Error;
using espalier::protocol::memberOf;

namespace {

// the result, or an exception with the message of the error
asio::awaitable<std::string> ask(CoroutineClient& client, std::string method, std::string params) {
  auto outcome = co_await client.request(std::move(method), std::move(params));
  if (!outcome) {
    throw std::runtime_error(outcome.error().message);
  }
  co_return *std::move(outcome);
}

// A tip grows to the height that its plant may have.
asio::awaitable<void> grow(CoroutineClient& client, int height) {
  const std::string text = std::to_string(height);
  const std::string created =
      co_await ask(client, "simulation.create",
                   R"({"model":{"source":"Lsystem: 1\nderivation length: 9\nAxiom: A?E(0)\nA?E(h) : h < )" + text +
                       R"( --> FA?E(0)\nendlsystem\n"},"environment":[{"type":"height"}],"seed":1})");
  const std::string name = "\"simulation\":\"" + memberOf(created, "simulation").value_or("") + '"';
  co_await ask(client, "simulation.run", "{" + name + "}");
  const std::string got = co_await ask(client, "simulation.get", "{" + name + R"(,"what":"string"})");
  std::cout << height << '\t' << memberOf(got, "string").value_or("?") << '\n';
  co_await ask(client, "simulation.delete", "{" + name + "}");
}

asio::awaitable<void> growAll(std::string address) {
  auto connected = co_await CoroutineClient::connect(std::move(address));
  if (!connected) {
    throw std::runtime_error(connected.error().message);
  }
  const auto client = *std::move(connected);
  const auto executor = co_await asio::this_coro::executor;
  // all are under way before the first is waited for
  asio::steady_timer done(executor, asio::steady_timer::time_point::max());
  int left = 4;
  std::exception_ptr failure;
  for (int height = 1; height <= 4; ++height) {
    asio::co_spawn(executor, grow(*client, height), [&](const std::exception_ptr& thrown) {
      failure = thrown ? thrown : failure;
      left -= 1;
      if (left == 0) {
        done.cancel();
      }
    });
  }
  boost::system::error_code woken;
  co_await done.async_wait(asio::redirect_error(asio::use_awaitable, woken));
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace

int main(int argumentCount, char** arguments) {
  if (argumentCount != 2) {
    std::cerr << "usage: grow_many HOST:PORT\n";
    return 2;
  }
  asio::io_context context;
  std::exception_ptr failure;
  asio::co_spawn(context, growAll(arguments[1]), [&](const std::exception_ptr& thrown) { failure = thrown; });
  context.run();
  try {
    if (failure) {
      std::rethrow_exception(failure);
    }
  } catch (const std::exception& error) {
    std::cerr << "grow_many: " << error.what() << '\n';
    return 1;
  }
}
