#include "clients/cpp/client.h"

#include <gtest/gtest.h>

#include "tests/clients/scripted_server.h"

namespace espalier::client::client_test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

std::unique_ptr<Client> connected(const ScriptedServer& server) {
  auto result = Client::connect(server.address(), {});
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return nullptr;
  }
  return std::move(result.value());
}

TEST(Client, SaysHelloAndKeepsTheAnswer) {
  const ScriptedServer server({kWelcome});
  EXPECT_EQ(connected(server)->helloResult(), R"({"protocol":1})");
}

TEST(Client, KeepsNotificationsAndRequestsThatComeBeforeTheAnswer) {
  const ScriptedServer server(
      {kWelcome,
       "{\"jsonrpc\":\"2.0\",\"method\":\"stream.data\",\"params\":{\"step\":1}}\n"
       "{\"jsonrpc\":\"2.0\",\"id\":\"s1\",\"method\":\"environment.step\",\"params\":{\"step\":4}}\n"
       "{\"jsonrpc\":\"2.0\",\"id\":2,\"result\":{\"a\":1}}\n",
       ""});
  const auto client = connected(server);
  EXPECT_EQ(client->request("m", "{}").value(), R"({"a":1})");
  const auto notification = client->nextNotification(std::chrono::seconds(0));
  ASSERT_TRUE(notification.has_value());
  EXPECT_EQ(notification->method, "stream.data");
  EXPECT_EQ(notification->paramsJson, R"({"step":1})");
  const auto request = client->nextRequest(std::chrono::seconds(0));
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->method, "environment.step");
  EXPECT_EQ(client->respond(request->id, "{}"), std::nullopt);
}

TEST(Client, AnswersMayComeInAnyOrder) {
  const ScriptedServer server({kWelcome, "",
                               "{\"jsonrpc\":\"2.0\",\"id\":3,\"result\":\"second\"}\n"
                               "{\"jsonrpc\":\"2.0\",\"id\":2,\"result\":\"first\"}\n"});
  const auto client = connected(server);
  const auto first = client->send("m", "{}").value();
  const auto second = client->send("m", "{}").value();
  EXPECT_EQ(client->waitFor(first, std::chrono::seconds(30)).value(), "\"first\"");
  EXPECT_EQ(client->waitFor(second, std::chrono::seconds(30)).value(), "\"second\"");
}

TEST(Client, ErrorsOfTheServerAreValues) {
  const ScriptedServer server(
      {kWelcome, "{\"jsonrpc\":\"2.0\",\"id\":2,\"error\":{\"code\":1011,\"message\":\"none\",\"data\":{\"a\":1}}}\n"});
  const auto error = connected(server)->request("m", "{}").error();
  EXPECT_EQ(error.code, protocol::ErrorCode::NotFound);
  EXPECT_EQ(error.message, "none");
  EXPECT_EQ(error.data, R"({"a":1})");
}

TEST(Client, ALostConnectionAndALateAnswerAreErrorsThatSayWhatToDo) {
  {
    const ScriptedServer server({kWelcome});
    const auto error = connected(server)->request("m", "{}").error();
    EXPECT_EQ(error.message.substr(0, 37), "The connection to the server is lost:");
    EXPECT_NE(error.message.find("Connect again."), std::string::npos);
  }
  const ScriptedServer server({kWelcome, "", ""});
  const auto client = connected(server);
  const auto id = client->send("m", "{}").value();
  const auto late = client->waitFor(id, std::chrono::milliseconds(1)).error();
  EXPECT_EQ(late.code, protocol::ErrorCode::Timeout);
  EXPECT_EQ(late.message, "No answer to request 2 within 1 ms.");
  EXPECT_TRUE(client->isOpen());
}

TEST(Client, ARefusalWithoutIdIsWhyTheConnectionClosed) {
  const ScriptedServer server(
      {"{\"jsonrpc\":\"2.0\",\"id\":null,\"error\":{\"code\":1004,\"message\":\"too many\"}}\n"});
  const auto result = Client::connect(server.address(), {});
  EXPECT_EQ(result.error().message, "too many");
}

TEST(Client, WrongAddressesAreErrorsThatSayWhatToDo) {
  EXPECT_EQ(Client::connect("nowhere", {}).error().message,
            "'nowhere' is not an address; write HOST:PORT, for example 127.0.0.1:4321.");
  // a port that was free a moment ago
  asio::io_context context;
  tcp::acceptor acceptor(context, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  const std::string address = "127.0.0.1:" + std::to_string(acceptor.local_endpoint().port());
  acceptor.close();
  EXPECT_NE(Client::connect(address, {}).error().message.find("Start the server (espalier serve)"), std::string::npos);
}

}  // namespace
}  // namespace espalier::client::client_test
