#include "clients/cpp/coroutine_client.h"

#include <gtest/gtest.h>

#include <boost/asio/experimental/awaitable_operators.hpp>

#include "tests/clients/scripted_server.h"

namespace espalier::client::coroutine_client_test {
namespace {

namespace asio = boost::asio;
using asio::awaitable;
using protocol::Error;
using protocol::ErrorCode;
using namespace std::chrono_literals;

/// Runs a coroutine with a client that is connected to a server of prepared answers.
template <typename Body>
void withClient(const ScriptedServer& server, Body body, ClientOptions options = {}) {
  asio::io_context context;
  asio::co_spawn(
      context,
      [&]() -> awaitable<void> {
        auto connected = co_await CoroutineClient::connect(server.address(), options);
        if (!connected) {
          ADD_FAILURE() << connected.error().message;
          co_return;
        }
        const auto client = std::move(connected).value();
        co_await body(*client);
      },
      [](const std::exception_ptr& thrown) {
        if (thrown) {
          std::rethrow_exception(thrown);
        }
      });
  context.run();
}

std::string textOf(const Outcome& outcome) {
  return outcome ? *outcome : "error: " + outcome.error().message;
}

std::string answer(int id, const std::string& result) {
  return R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"result":)" + result + "}\n";
}

TEST(CoroutineClient, SaysHelloAndAsks) {
  const ScriptedServer server({kWelcome, answer(2, R"({"step":3})")});
  withClient(server, [](CoroutineClient& client) -> awaitable<void> {
    EXPECT_EQ(client.helloResult(), R"({"protocol":1})");
    const Outcome outcome = co_await client.request("simulation.step", R"({"simulation":"s"})");
    EXPECT_EQ(textOf(outcome), R"({"step":3})");
  });
}

TEST(CoroutineClient, GivesEachOfSeveralRequestsItsAnswerInAnyOrder) {
  const ScriptedServer server({kWelcome, "", answer(3, R"("second")") + answer(2, R"("first")")});
  withClient(server, [](CoroutineClient& client) -> awaitable<void> {
    using namespace asio::experimental::awaitable_operators;
    const auto [first, second] = co_await (client.request("a", "{}") && client.request("b", "{}"));
    EXPECT_EQ(textOf(first), R"("first")");
    EXPECT_EQ(textOf(second), R"("second")");
  });
}

TEST(CoroutineClient, KeepsNotificationsAndRequestsThatComeBeforeTheAnswer) {
  const ScriptedServer server({kWelcome, R"({"jsonrpc":"2.0","method":"stream.data","params":{"step":1}})"
                                         "\n"
                                         R"({"jsonrpc":"2.0","id":"s1","method":"environment.describe","params":{}})"
                                         "\n" +
                                             answer(2, "{}")});
  withClient(server, [](CoroutineClient& client) -> awaitable<void> {
    const Outcome outcome = co_await client.request("environment.offer", R"({"name":"e"})");
    EXPECT_EQ(textOf(outcome), "{}");
    const auto notification = co_await client.nextNotification();
    EXPECT_EQ(notification ? notification->paramsJson : "none", R"({"step":1})");
    const auto request = co_await client.nextRequest();
    EXPECT_EQ(request ? request->method : "none", "environment.describe");
  });
}

TEST(CoroutineClient, ALostConnectionEndsWhateverWaits) {
  const ScriptedServer server({kWelcome, ""});
  withClient(server, [](CoroutineClient& client) -> awaitable<void> {
    using namespace asio::experimental::awaitable_operators;
    const auto [outcome, notification] = co_await (client.request("simulation.run", "{}") && client.nextNotification());
    EXPECT_EQ(textOf(outcome), "error: The connection to the server is lost: the server closed it. Connect again.");
    EXPECT_FALSE(notification);
    EXPECT_FALSE(client.isOpen());
    const Outcome later = co_await client.request("server.status", "{}");
    EXPECT_EQ(later.error().code, ErrorCode::Internal);
  });
}

TEST(CoroutineClient, AnAnswerThatDoesNotComeInTimeIsATimeout) {
  const ScriptedServer server({kWelcome, "", ""});
  ClientOptions options;
  options.requestTimeout = 1ms;
  withClient(
      server,
      [](CoroutineClient& client) -> awaitable<void> {
        const Outcome outcome = co_await client.request("simulation.run", "{}");
        EXPECT_EQ(textOf(outcome), "error: No answer to simulation.run within 1 ms.");
        EXPECT_EQ(outcome.error().code, ErrorCode::Timeout);
      },
      options);
}

TEST(CoroutineClient, ACancelledCoroutineCancelsItsRequest) {
  // the server answers hello, nothing to the request, and then what shows that it got the notification
  const ScriptedServer server({kWelcome, "",
                               R"({"jsonrpc":"2.0","method":"got","params":{}})"
                               "\n"});
  withClient(server, [](CoroutineClient& client) -> awaitable<void> {
    using namespace asio::experimental::awaitable_operators;
    asio::steady_timer soon(co_await asio::this_coro::executor, 1ms);
    const auto first = co_await (client.request("simulation.run", "{}") || soon.async_wait(asio::use_awaitable));
    EXPECT_EQ(first.index(), 1u);  // the timer was first
    const auto notification = co_await client.nextNotification();
    EXPECT_EQ(notification ? notification->method : "none", "got");
  });
}

TEST(CoroutineClient, AContextMayGoAwayWhileACoroutineWaits) {
  const ScriptedServer server({kWelcome, ""});
  asio::io_context context;
  bool isWaiting = false;
  asio::co_spawn(
      context,
      [&]() -> awaitable<void> {
        auto connected = co_await CoroutineClient::connect(server.address());
        const auto client = std::move(connected).value();
        isWaiting = true;
        (void)co_await client->nextNotification();
      },
      asio::detached);
  while (!isWaiting) {
    context.run_one();
  }
}

awaitable<void> connectInVain(std::string address, std::string& said) {
  const auto connected = co_await CoroutineClient::connect(std::move(address));
  said = connected.error().message;
}

std::string failureAt(const std::string& address) {
  asio::io_context context;
  std::string said;
  asio::co_spawn(context, connectInVain(address, said), asio::detached);
  context.run();
  return said;
}

TEST(CoroutineClient, SaysWhatIsWrongWithAnAddress) {
  EXPECT_EQ(failureAt("nowhere"), "'nowhere' is not an address; write HOST:PORT, for example 127.0.0.1:4321.");
  EXPECT_EQ(failureAt("127.0.0.1:1"),
            "Cannot connect to 127.0.0.1:1: Connection refused. Start the server (espalier serve) or correct the "
            "address.");
}

}  // namespace
}  // namespace espalier::client::coroutine_client_test
