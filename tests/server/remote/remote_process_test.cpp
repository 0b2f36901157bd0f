#include "server/remote/remote_process.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <mutex>

#include "environment/registry.h"
#include "protocol/codec.h"
#include "server/remote/remote_environment.h"
#include "tests/server/raw_peer.h"

namespace espalier::server::remote_process_test {
namespace {

constexpr std::string_view kOffered = R"([{"type":"offered","name":"mylight"}])";

/// Replies with the y coordinate, as the built-in height does, and knows nothing but steps.
void answerHeight(client::Client& self, const client::IncomingRequest& request) {
  if (request.method != "environment.step") {
    (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "only steps here", {}});
    return;
  }
  const auto params = protocol::decodeEnvironmentStepParams(request.params).value();
  protocol::ReplyColumns replies;
  std::vector<double> heights;
  std::vector<std::uint64_t> offset{0};
  for (std::size_t i = 0; i < params.queries.count; ++i) {
    heights.push_back(params.queries.position[3 * i + 1]);
    offset.push_back(i + 1);
  }
  replies.count = heights.size();
  replies.values = heights;
  replies.offset = offset;
  (void)self.respond(request.id, protocol::encode(replies));
}

TEST(RemoteProcess, AnOfferedEnvironmentThatKnowsOnlyStepsGivesTheSameString) {
  const RunningServer server;
  const OfferingEnvironment environment(server, "mylight", answerHeight);
  const auto client = connectTo(server);
  const std::string inside = create(*client, kGrowth, R"([{"type":"height"}])");
  const std::string outside = create(*client, kGrowth, kOffered);
  for (int step = 0; step < 6; ++step) {
    resultOf(client->request("simulation.step", named(inside)));
    resultOf(client->request("simulation.step", named(outside)));
    EXPECT_EQ(stringOf(*client, outside), stringOf(*client, inside)) << "after step " << step;
  }
}

TEST(RemoteProcess, OneOfferServesSeveralSimulations) {
  const RunningServer server;
  const OfferingEnvironment environment(server, "mylight", answerHeight);
  const auto client = connectTo(server);
  for (int i = 0; i < 3; ++i) {
    const std::string simulation = create(*client, kGrowth, kOffered);
    resultOf(client->request("simulation.run", named(simulation)));
    EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)F(1)?E(3)");
  }
}

TEST(RemoteProcess, TheOfferIsAnsweredBeforeAnythingIsAsked) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  EXPECT_EQ(
      member(peer.ask(R"({"jsonrpc":"2.0","id":5,"method":"environment.offer","params":{"name":"mylight"}})"), "id"),
      "5");
}

TEST(RemoteProcess, AnEnvironmentThatNobodyOffersIsARetryableError) {
  const RunningServer server;
  const auto client = connectTo(server);
  const auto error = errorOf(client->request("simulation.create", createParams(kGrowth, kOffered)));
  EXPECT_EQ(static_cast<int>(error.code), 1006);
  EXPECT_EQ(member(error.data, "retryable"), "true");
  EXPECT_NE(error.message.find("environment 'mylight' is not connected; offered now: none"), std::string::npos)
      << error.message;
}

TEST(RemoteProcess, AnEnvironmentThatDiesInAStepLeavesTheSimulationAndResumesWhenItIsBack) {
  const RunningServer server;
  const auto client = connectTo(server);
  std::string simulation;
  {
    RawPeer mortal(server);
    (void)mortal.ask(kHello);
    (void)mortal.ask(R"({"jsonrpc":"2.0","id":5,"method":"environment.offer","params":{"name":"mylight"}})");
    std::thread creating([&] { simulation = create(*client, kGrowth, kOffered); });
    // describe and open are unknown to it
    for (int i = 0; i < 2; ++i) {
      mortal.send("{\"jsonrpc\":\"2.0\",\"id\":" + protocol::JsonWriter().text(member(mortal.line(), "id")).take() +
                  ",\"error\":{\"code\":-32601,\"message\":\"unknown\"}}\n");
    }
    creating.join();
    const auto id = client->send("simulation.step", named(simulation)).value();
    EXPECT_EQ(member(mortal.line(), "method"), "environment.step");
    // it dies with the question unanswered
    std::thread dying([peer = std::make_unique<RawPeer>(std::move(mortal))]() mutable { peer.reset(); });
    dying.join();
    const auto error = errorOf(client->waitFor(id, std::chrono::seconds(30)));
    EXPECT_EQ(static_cast<int>(error.code), 1006);
    EXPECT_EQ(member(error.data, "retryable"), "true");
    EXPECT_EQ(member(error.data, "environment"), "offered:mylight");
    EXPECT_NE(error.message.find("environment 'mylight'"), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("step 0"), std::string::npos) << error.message;
    EXPECT_NE(error.message.find("Connect it again and offer it as 'mylight'"), std::string::npos) << error.message;
  }
  EXPECT_EQ(stringOf(*client, simulation), "F(1)A?E(0)");
  EXPECT_EQ(static_cast<int>(errorOf(client->request("simulation.step", named(simulation))).code), 1006);
  const OfferingEnvironment back(server, "mylight", answerHeight);
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "step"), "1");
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)A?E(1)");
}

/// A port whose queue of connections is full: whoever dials it waits.
class FullPort {
 public:
  FullPort() : listening_(::socket(AF_INET, SOCK_STREAM, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof(address_);
    EXPECT_EQ(::bind(listening_.number(), reinterpret_cast<sockaddr*>(&address_), length), 0);
    EXPECT_EQ(::listen(listening_.number(), 0), 0);
    EXPECT_EQ(::getsockname(listening_.number(), reinterpret_cast<sockaddr*>(&address_), &length), 0);
    for (int i = 0; i < 3; ++i) {
      waiting_.emplace_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
      (void)::connect(waiting_.back().number(), reinterpret_cast<const sockaddr*>(&address_), sizeof(address_));
    }
  }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(ntohs(address_.sin_port)); }

 private:
  Descriptor listening_;
  std::vector<Descriptor> waiting_;
  sockaddr_in address_{};
};

TEST(RemoteProcess, OneThatCannotBeReachedIsGivenUpInTime) {
  const FullPort port;
  ServerOptions options;
  options.limits.environmentConnectMilliseconds = 50;
  options.remote.addresses = {port.address()};
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto error = errorOf(client->request(
      "simulation.create", createParams(kGrowth, R"([{"type":"tcp","address":")" + port.address() + R"("}])")));
  EXPECT_EQ(static_cast<int>(error.code), 1006);
  EXPECT_EQ(error.message, "environment tcp://" + port.address() + " is not there: cannot connect to " +
                               port.address() + ": Connection timed out (while connecting). Start it again at " +
                               port.address() + ", then try again.");
}

TEST(RemoteProcess, ASilentEnvironmentTimesOutAndOthersAreNotStarved) {
  ServerOptions options;
  options.workers = 1;
  options.limits.environmentStepMilliseconds = 200;
  const RunningServer server(options);
  std::atomic<bool> isAsked{false};
  const OfferingEnvironment silent(
      server, "mylight", [&](client::Client& self, const client::IncomingRequest& request) {
        if (request.method == "environment.step") {
          isAsked = true;
          isAsked.notify_all();
        } else {
          (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
        }
      });
  const auto client = connectTo(server);
  const std::string waiting = create(*client, kGrowth, kOffered);
  const std::string quick = create(*client, kGrowth, R"([{"type":"height"}])");
  const auto id = client->send("simulation.step", named(waiting)).value();
  isAsked.wait(false);
  // the only worker waits, and another computes in its place
  const auto other = connectTo(server);
  EXPECT_EQ(member(resultOf(other->request("simulation.run", named(quick))), "step"), "6");
  const auto error = errorOf(client->waitFor(id, std::chrono::seconds(30)));
  EXPECT_NE(error.message.find("did not answer within 200 ms"), std::string::npos) << error.message;
}

TEST(RemoteProcess, WrongRepliesAreErrorsWithTheirPathAndNothingOfThemIsUsed) {
  const RunningServer server;
  std::string reply;
  std::mutex mutex;
  const OfferingEnvironment wrong(server, "mylight", [&](client::Client& self, const client::IncomingRequest& request) {
    if (request.method == "environment.step") {
      const std::lock_guard lock(mutex);
      (void)self.respond(request.id, reply);
    } else {
      (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
    }
  });
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kGrowth, kOffered);
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"({"replies":[{"id":0,"parameters":[9]},{"id":7,"parameters":[1]}]})",
       "result.replies[1].id: there is no query 7"},
      {R"({"replies":[{"id":0,"parameters":[9]},{"id":0,"parameters":[1]}]})",
       "result.replies[1].id: query 0 is answered twice"},
      {R"({"replies":[{"id":0,"parameters":["high"]}]})", "result.replies[0].parameters[0]: expected a number"},
      {R"({"answers":[]})", "result.replies: expected an array, found nothing"},
  };
  for (const auto& [text, message] : cases) {
    {
      const std::lock_guard lock(mutex);
      reply = text;
    }
    const auto error = errorOf(client->request("simulation.step", named(simulation)));
    EXPECT_EQ(static_cast<int>(error.code), 1006);
    EXPECT_NE(error.message.find(message), std::string::npos) << error.message;
    EXPECT_EQ(stringOf(*client, simulation), "F(1)A?E(0)");
  }
}

TEST(RemoteProcess, AnAnswerThatIsNotJsonFailsTheStepAtOnce) {
  const RunningServer server;
  RawPeer peer(server);
  (void)peer.ask(kHello);
  (void)peer.ask(R"({"jsonrpc":"2.0","id":5,"method":"environment.offer","params":{"name":"mylight"}})");
  const auto client = connectTo(server);
  std::string simulation;
  std::thread creating([&] { simulation = create(*client, kGrowth, kOffered); });
  for (int i = 0; i < 2; ++i) {
    peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"" + member(peer.line(), "id") +
              "\",\"error\":{\"code\":-32601,\"message\":\"unknown\"}}\n");
  }
  creating.join();
  const auto id = client->send("simulation.step", named(simulation)).value();
  peer.send("{\"jsonrpc\":\"2.0\",\"id\":\"" + member(peer.line(), "id") +
            "\",\"result\":{\"replies\":[{\"id\":0,\"parameters\":[NaN]}]}}\n");
  const auto error = errorOf(client->waitFor(id, std::chrono::seconds(30)));
  EXPECT_NE(error.message.find("NaN and Infinity are not JSON numbers"), std::string::npos) << error.message;
}

TEST(RemoteProcess, NullAndMissingParametersKeepWhatWasSent) {
  const RunningServer server;
  const OfferingEnvironment partial(
      server, "mylight", [](client::Client& self, const client::IncomingRequest& request) {
        if (request.method == "environment.step") {
          (void)self.respond(request.id, R"({"replies":[{"id":1,"parameters":[null,0.3]},{"id":0,"parameters":[1]}]})");
        } else {
          (void)self.respondError(request.id, {protocol::ErrorCode::UnknownMethod, "no", {}});
        }
      });
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 3\nAxiom: ?E(5,6)?E(7,8)?E(9)\nZ --> Z\nendlsystem\n", kOffered);
  resultOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(stringOf(*client, simulation), "?E(1,6)?E(7,0.3)?E(9)");
}

TEST(RemoteProcess, ASimulationWhoseEnvironmentIsAwayLoadsAndCanBeReadAndStepsAgainLater) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string simulation;
  {
    const RunningServer server(options);
    const OfferingEnvironment environment(server, "mylight", answerHeight);
    const auto client = connectTo(server);
    simulation = create(*client, kGrowth, kOffered);
    resultOf(client->request("simulation.step", named(simulation)));
  }
  const RunningServer server(options);
  const auto client = connectTo(server);
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)A?E(1)");
  const auto error = errorOf(client->request("simulation.step", named(simulation)));
  EXPECT_EQ(static_cast<int>(error.code), 1006);
  EXPECT_EQ(member(error.data, "retryable"), "true");
  const OfferingEnvironment environment(server, "mylight", answerHeight);
  resultOf(client->request("simulation.run", named(simulation)));
  EXPECT_EQ(stringOf(*client, simulation), "F(1)F(1)F(1)?E(3)");
}

/// A peer that is there and takes little.
class NarrowLink final : public EnvironmentLink {
 public:
  explicit NarrowLink(PeerTerms terms) : terms_(terms) {}
  [[nodiscard]] std::string label() const override { return "environment 'narrow'"; }
  [[nodiscard]] std::string remedy() const override { return "Start it again."; }
  [[nodiscard]] std::optional<LinkFailure> connect() override { return std::nullopt; }
  [[nodiscard]] std::uint64_t generation() const override { return 1; }
  [[nodiscard]] PeerTerms terms() const override { return terms_; }
  [[nodiscard]] LinkOutcome call(std::string_view, const protocol::Body&, std::chrono::milliseconds) override {
    ++callCount;
    return tl::unexpected(LinkFailure{
        LinkFailure::Kind::Refused, "answered with an error", {protocol::ErrorCode::UnknownMethod, {}, {}}});
  }
  void interrupt() override {}
  int callCount = 0;

 private:
  PeerTerms terms_;
};

TEST(RemoteProcess, OfALongErrorOfAPeerOnlyTheBeginningGoesOn) {
  std::string text(1999, 'x');
  for (int i = 0; i < 1'000'000; ++i) {
    text += "\u00fc";
  }
  const LinkFailure failure = refusedWith({protocol::ErrorCode::UnknownMethod, text, {}});
  EXPECT_EQ(failure.kind, LinkFailure::Kind::Refused);
  EXPECT_EQ(failure.message, "answered with an error: " + text.substr(0, 1999) + "... (2001999 bytes)");
  EXPECT_EQ(failure.error.message.size(), 1999U);
  EXPECT_EQ(refusedWith({protocol::ErrorCode::UnknownMethod, "no light", {}}).message,
            "answered with an error: no light");
}

TEST(RemoteProcess, AStepLongerThanItsPeerTakesIsNotSentAndSaysWhatHelps) {
  turtle::QueryBatch queries;
  queries.step = 4;
  queries.parameterOffset = {0};
  queries.followingOffset = {0};
  for (std::uint64_t i = 0; i < 100; ++i) {
    queries.plant.push_back(0);
    queries.module.push_back(i);
    queries.symbol.push_back(0);
    queries.parameters.push_back(1.0);
    queries.parameterOffset.push_back(i + 1);
    queries.followingOffset.push_back(0);
  }
  const auto messageFor = [&](const PeerTerms& terms) {
    const auto link = std::make_shared<NarrowLink>(terms);
    RemoteProcess process(link, {});
    EXPECT_FALSE(
        process.open({.simulation = "s", .plantCount = 1, .symbols = {"E"}, .seed = 0, .world = {}}).has_value());
    const int before = link->callCount;
    turtle::ReplyBatch replies;
    replies.prepare(queries);
    const auto error = process.step(queries, replies);
    EXPECT_TRUE(error.has_value() && !error->isRetryable);
    EXPECT_EQ(link->callCount, before);
    return error ? error->message : std::string();
  };
  EXPECT_EQ(
      messageFor({.takesBlocks = false, .lineBytes = 1'000, .blockBytes = 0}),
      "environment 'narrow' takes at most 1000 bytes in one message (lineBytes), but step 4, 100 queries take 6242 "
      "bytes as text. Let it need less (needs in environment.describe), let it take binary blocks (the capability "
      "bin), raise its lineBytes, or let the model ask less in one step.");
  EXPECT_EQ(
      messageFor({.takesBlocks = true, .lineBytes = 1'000, .blockBytes = 1'000}),
      "environment 'narrow' takes at most 1000 bytes in one message (blockBytes), but step 4, 100 queries take 2000 "
      "bytes in blocks. Let it need less (needs in environment.describe), raise its blockBytes, or let the model ask "
      "less in one step.");
}

TEST(RemoteProcess, ConnectingSaysWhatIsWrong) {
  const auto unknown = connectRemoteEnvironment("udp://x", {});
  EXPECT_EQ(unknown.error(),
            "'udp://x' does not name an environment in another process. Write tcp://HOST:PORT, unix:PATH or "
            "stdio:COMMAND.");
  for (const std::string bad : {"tcp://nowhere", "tcp://127.0.0.1:", "tcp://127.0.0.1:0"}) {
    EXPECT_EQ(connectRemoteEnvironment(bad, {}).error(),
              "'" + bad + "' is not an address: write tcp://HOST:PORT, for example tcp://127.0.0.1:4000.");
  }
  const auto dead = connectRemoteEnvironment("stdio:exit 3", {});
  EXPECT_NE(dead.error().find("ended with status 3"), std::string::npos) << dead.error();
}

}  // namespace
}  // namespace espalier::server::remote_process_test
