#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/raw_peer.h"
#include "tests/server/server_fixture.h"
#include "tests/support/sanitized.h"

namespace espalier::server::accounts_in_use_test {
namespace {

/// Long enough to decode the big models of these tests, and too short to compile them.
constexpr std::uint32_t kSecondsToDecode = kIsSanitized ? 5 : 1;

/// Doubles its string in each step; a step n leaves 2^n modules of ten bytes.
constexpr std::string_view kDoubling =
    "Lsystem: 1\nderivation length: 40\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n";
constexpr std::string_view kSmall = "Lsystem: 1\nderivation length: 9\nAxiom: A(1)\nA(x) --> A(x+1)\nendlsystem\n";

std::string statusOf(client::Client& client) {
  return resultOf(client.request("server.status", "{}"));
}

std::uint64_t numberOf(const std::string& json, std::string_view name) {
  return std::stoull(member(json, name));
}

std::string hashOf(client::Client& client, const std::string& simulation) {
  return member(resultOf(client.request("simulation.get", named(simulation, R"("what":"state-hash")"))), "stateHash");
}

ServerOptions withMemory(std::uint64_t bytes) {
  ServerOptions options;
  options.limits.memoryBytes = bytes;
  return options;
}

TEST(AccountsInUse, ASimulationThatNeedsMoreThanThereIsStaysWhereItIs) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  const std::string other = create(*client, kSmall);
  const std::string greedy = create(*client, kDoubling);
  const protocol::Error error = errorOf(client->request("simulation.run", named(greedy)));
  EXPECT_EQ(static_cast<int>(error.code), 1004) << error.message;
  EXPECT_EQ(member(error.data, "limit"), "memoryBytes");
  EXPECT_EQ(member(error.data, "bound"), "60000000");
  const std::string step =
      member(resultOf(client->request("simulation.get", named(greedy, R"("what":"statistics")"))), "step");
  EXPECT_NE(error.message.find("The simulation stays at step " + step + "."), std::string::npos) << error.message;
  EXPECT_GE(std::stoi(step), 17);
  EXPECT_LE(std::stoi(step), 21);
  // others go on, and everything is counted
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(other))), "step"), "1");
  const std::string memory = member(statusOf(*client), "memory");
  EXPECT_GE(numberOf(memory, "stringBytes"), std::uint64_t{20} << std::stoi(step));
  EXPECT_LE(numberOf(memory, "usedBytes"), 60'000'000U);
  EXPECT_EQ(numberOf(memory, "boundBytes"), 60'000'000U);
  // the memory of a deleted simulation is free again
  resultOf(client->request("simulation.delete", named(greedy)));
  const std::string next = create(*client, kDoubling);
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(next, R"("steps":16)"))), "step"), "16");
}

TEST(AccountsInUse, ManySimulationsHaveOneBoundTogether) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  // 1.3 MB of strings each, twice
  int made = 0;
  std::optional<protocol::Error> refusal;
  for (; made < 100 && !refusal; ++made) {
    const client::Outcome outcome =
        client->request("simulation.step", named(create(*client, kDoubling), R"("steps":17)"));
    refusal = outcome ? std::nullopt : std::optional(outcome.error());
  }
  ASSERT_TRUE(refusal.has_value());
  EXPECT_EQ(member(refusal->data, "limit"), "memoryBytes") << refusal->message;
  EXPECT_GT(made, 10);
  EXPECT_LT(made, 30);
  EXPECT_LE(numberOf(member(statusOf(*client), "memory"), "usedBytes"), 60'000'000U);
}

TEST(AccountsInUse, IdleSavedSimulationsMakeRoomOnDisk) {
  const TemporaryFolder folder;
  ServerOptions options = withMemory(40'000'000);
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  // 30 times 2.6 MB do not fit
  std::vector<std::string> names;
  std::vector<std::string> hashes;
  for (int i = 0; i < 30; ++i) {
    names.push_back(create(*client, kDoubling, i % 2 == 0 ? R"([{"type":"honda","radius":0.5}])" : "",
                           R"("seed":)" + std::to_string(i)));
    EXPECT_EQ(member(resultOf(client->request("simulation.step", named(names.back(), R"("steps":17)"))), "step"), "17");
    hashes.push_back(hashOf(*client, names.back()));
  }
  EXPECT_GT(numberOf(statusOf(*client), "passive"), 10U);
  EXPECT_LE(numberOf(member(statusOf(*client), "memory"), "usedBytes"), 40'000'000U);
  EXPECT_EQ(numberOf(statusOf(*client), "simulations"), 30U);
  // each is there as if it had stayed, and those that were used last rest last
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(hashOf(*client, names[i]), hashes[i]) << i;
  }
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(names[0]))), "step"), "18");
  // deleting needs no memory
  for (const std::string& name : names) {
    resultOf(client->request("simulation.delete", named(name)));
  }
  // a worker destroys the last ones after the answer
  while (numberOf(member(statusOf(*client), "memory"), "stringBytes") > 0) {
    std::this_thread::yield();
  }
}

TEST(AccountsInUse, ASimulationWithAViewerStaysInMemory) {
  const TemporaryFolder folder;
  ServerOptions options = withMemory(40'000'000);
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto viewer = connectTo(server);
  const std::string watched = create(*client, kDoubling);
  resultOf(viewer->request("stream.open", named(watched, R"("what":"statistics")")));
  ASSERT_TRUE(viewer->nextNotification(std::chrono::seconds(30)).has_value());
  for (int i = 0; i < 30; ++i) {
    resultOf(client->request("simulation.step", named(create(*client, kDoubling), R"("steps":17)")));
  }
  EXPECT_GT(numberOf(statusOf(*client), "passive"), 10U);
  resultOf(client->request("simulation.step", named(watched)));
  const auto frame = viewer->nextNotification(std::chrono::seconds(30));
  ASSERT_TRUE(frame.has_value());
  EXPECT_EQ(member(frame->paramsJson, "step"), "1");
}

TEST(AccountsInUse, AfterARestartAsManyAreInMemoryAsThereIsRoomFor) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  std::string name;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    for (int i = 0; i < 8; ++i) {
      name = create(*client, kDoubling);
      resultOf(client->request("simulation.step", named(name, R"("steps":17)")));
    }
  }
  options.limits.memoryBytes = 12'000'000;
  const RunningServer server(options);
  const auto client = connectTo(server);
  EXPECT_GT(numberOf(statusOf(*client), "passive"), 3U);
  EXPECT_EQ(numberOf(statusOf(*client), "damaged"), 0U);
  EXPECT_EQ(stringOf(*client, name).substr(0, 8), "A(1)A(1)");
}

TEST(AccountsInUse, SimulationsAndStreamsOfAnAccountAreCounted) {
  ServerOptions options;
  options.limits.accountSimulations = 2;
  options.limits.accountStreams = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto other = connectTo(server);
  const std::string first = create(*client, kSmall);
  (void)create(*other, kSmall);
  // two connections of one owner share what it may have
  EXPECT_EQ(errorOf(other->request("simulation.create", createParams(kSmall))).data,
            R"({"bound":2,"limit":"accountSimulations","value":3})");
  EXPECT_EQ(errorOf(other->request("simulation.fork", named(first))).data,
            R"({"bound":2,"limit":"accountSimulations","value":3})");
  const std::string stream =
      member(resultOf(client->request("stream.open", named(first, R"("what":"string")"))), "stream");
  EXPECT_EQ(errorOf(other->request("stream.open", named(first, R"("what":"string")"))).data,
            R"({"bound":1,"limit":"accountStreams","value":2})");
  const std::string account = member(statusOf(*client), "account");
  EXPECT_EQ(member(account, "name"), "local");
  EXPECT_EQ(member(account, "simulations"), "2");
  EXPECT_EQ(member(account, "streams"), "1");
  resultOf(client->request("stream.close", "{\"stream\":\"" + stream + "\"}"));
  resultOf(client->request("simulation.delete", named(first)));
  EXPECT_EQ(member(member(statusOf(*client), "account"), "streams"), "0");
  (void)create(*other, kSmall);
}

TEST(AccountsInUse, EachTokenHasAnAccountOfItsOwnAndNobodySeesAnother) {
  ServerOptions options = withMemory(300'000'000);
  options.httpHost = "127.0.0.1";
  options.limits.accountMemoryBytes = 30'000'000;
  options.limits.accountSimulations = 2;
  for (const char* name : {"ann", "ben"}) {
    options.tokens.push_back(tokenOf(name, name, {protocol::Role::Controller}));
  }
  const RunningServer server(options);
  client::ClientOptions as;
  as.token = "ann";
  const auto ann = connectTo(server, as);
  as.token = "ben";
  const auto ben = connectTo(server, as);
  const std::string greedy = create(*ann, kDoubling);
  (void)create(*ann, kSmall);
  const protocol::Error error = errorOf(ann->request("simulation.run", named(greedy)));
  EXPECT_EQ(member(error.data, "limit"), "accountMemoryBytes") << error.message;
  EXPECT_EQ(member(error.data, "bound"), "30000000");
  EXPECT_EQ(member(errorOf(ann->request("simulation.create", createParams(kSmall))).data, "limit"),
            "accountSimulations");
  // the limit of one account does not bind the other
  const std::string other = create(*ben, kDoubling);
  EXPECT_EQ(member(resultOf(ben->request("simulation.step", named(other, R"("steps":17)"))), "step"), "17");
  const std::string account = member(statusOf(*ben), "account");
  EXPECT_EQ(member(account, "name"), "ben");
  EXPECT_EQ(member(account, "simulations"), "1");
  EXPECT_EQ(member(account, "boundBytes"), "30000000");
  EXPECT_EQ(statusOf(*ben).find("\"ann\""), std::string::npos);
  // connections count for their tokens, too
  RawPeer browser(server.httpAddress());
  browser.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  std::string accounts;
  for (std::string line = browser.line(); line != "(closed)" && line != "(timeout)"; line = browser.line()) {
    accounts += line.starts_with("espalier_account_simulations{") ? line + "\n" : "";
  }
  EXPECT_EQ(accounts,
            "espalier_account_simulations{account=\"ann\"} 2\nespalier_account_simulations{account=\"ben\"} 1\n");
  // a simulation counts for its maker, also when another account steps it
  const std::uint64_t bytes = numberOf(account, "stringBytes");
  resultOf(ann->request("simulation.step", named(other)));
  EXPECT_GT(numberOf(member(statusOf(*ben), "account"), "stringBytes"), bytes);
}

TEST(AccountsInUse, AnAccountThatHasComputedEnoughComputesNoMore) {
  ServerOptions options;
  options.limits.accountCpuSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(
      *client,
      "Lsystem: 1\nderivation length: 100000\nAxiom: A\nA : { i = 0; while (i < 100000) { i = i + 1; } } 1 --> A\n"
      "endlsystem\n");
  const protocol::Error error = errorOf(client->request("simulation.run", named(simulation)));
  EXPECT_EQ(member(error.data, "limit"), "accountCpuSeconds") << error.message;
  EXPECT_EQ(member(error.data, "bound"), "1");
  EXPECT_EQ(errorOf(client->request("simulation.step", named(simulation))).data, error.data);
  EXPECT_EQ(static_cast<int>(errorOf(client->request("simulation.create", createParams(kSmall))).code), 1004);
  // looking at what is there costs next to nothing, and what is there is not lost
  EXPECT_EQ(stringOf(*client, simulation), "A");
  resultOf(client->request("simulation.save", named(simulation)));
  for (const auto& [method, more] : std::vector<std::pair<std::string, std::string>>{
           {"simulation.get", R"("what":"turtle")"},
           {"simulation.reset", ""},
           {"simulation.fork", ""},
           {"simulation.set", R"("parameters":{"i":1})"},
           {"simulation.edit", R"("action":"prune","plant":0,"module":0)"}}) {
    EXPECT_EQ(member(errorOf(client->request(method, named(simulation, more))).data, "limit"), "accountCpuSeconds")
        << method;
  }
  EXPECT_GE(std::stod(member(member(statusOf(*client), "account"), "cpuSeconds")), 1.0);
}

TEST(AccountsInUse, TheMessageNamesTheAccountThatHasComputedEnough) {
  ServerOptions options;
  options.limits.accountCpuSeconds = 1;
  for (const char* name : {"ann", "ben"}) {
    options.tokens.push_back(tokenOf(name, name, {protocol::Role::Controller}));
  }
  const RunningServer server(options);
  client::ClientOptions as;
  as.token = "ann";
  const auto ann = connectTo(server, as);
  as.token = "ben";
  const auto ben = connectTo(server, as);
  const std::string busy = create(
      *ann,
      "Lsystem: 1\nderivation length: 100000\nAxiom: A\nA : { i = 0; while (i < 100000) { i = i + 1; } } 1 --> A\n"
      "endlsystem\n");
  const std::string other = create(*ben, kSmall);
  // requests of ben to a simulation of ann count for ann
  const protocol::Error error = errorOf(ben->request("simulation.run", named(busy)));
  EXPECT_NE(error.message.find("The account 'ann' computes no more"), std::string::npos) << error.message;
  EXPECT_EQ(member(resultOf(ben->request("simulation.step", named(other))), "step"), "1");
  // ann does not compute at the expense of ben
  const protocol::Error own = errorOf(ann->request("simulation.step", named(other)));
  EXPECT_NE(own.message.find("The account 'ann' computes no more"), std::string::npos) << own.message;
}

/// A statement needs many times the memory of its text.
std::string bigModel(int statements) {
  std::string text = "Lsystem: 1\nderivation length: 1\nAxiom: F(1)\nF(x) : {\n";
  for (int i = 0; i < statements; ++i) {
    text += "x=x+1;\n";
  }
  return text + "} 1 --> F(x)\nendlsystem\n";
}

TEST(AccountsInUse, CompilingTakesNoMoreMemoryThanThereIs) {
  const RunningServer server(withMemory(30'000'000));
  const auto client = connectTo(server);
  protocol::JsonWriter params;
  params.beginObject().key("source").text(bigModel(100'000)).endObject();
  for (const char* method : {"model.check", "model.load"}) {
    const protocol::Error error = errorOf(client->request(method, params.view()));
    EXPECT_EQ(member(error.data, "limit"), "memoryBytes") << error.message;
  }
  EXPECT_EQ(member(errorOf(client->request("simulation.create", createParams(bigModel(100'000)))).data, "limit"),
            "memoryBytes");
  EXPECT_EQ(numberOf(member(statusOf(*client), "memory"), "compilingBytes"), 0U);
  (void)create(*client, kSmall);
}

TEST(AccountsInUse, ALoadedModelCountsAsLongAsItIsThere) {
  const RunningServer server;
  const auto client = connectTo(server);
  protocol::JsonWriter params;
  params.beginObject().key("source").text(kSmall).endObject();
  resultOf(client->request("model.check", params.view()));
  EXPECT_EQ(numberOf(member(statusOf(*client), "account"), "compilingBytes"), 0U);
  resultOf(client->request("model.load", params.view()));
  const std::uint64_t bytes = numberOf(member(statusOf(*client), "account"), "compilingBytes");
  EXPECT_GT(bytes, 1'000U);
  EXPECT_LT(bytes, 1'000'000U);
}

TEST(AccountsInUse, CompilingEndsAfterCallSecondsAndWhenItIsCancelled) {
  ServerOptions options;
  options.limits.callSeconds = kSecondsToDecode;
  const RunningServer server(options);
  const auto client = connectTo(server);
  protocol::JsonWriter params;
  params.beginObject().key("source").text(bigModel(1'500'000)).endObject();
  const client::Outcome outcome = client->request("model.check", params.view());
  ASSERT_FALSE(outcome.has_value());
  EXPECT_EQ(member(outcome.error().data, "limit"), "callSeconds") << outcome.error().message;
  EXPECT_NE(outcome.error().message.find("Nothing was made."), std::string::npos);
}

TEST(AccountsInUse, ReadingALongPredecessorEndsAfterCallSeconds) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  // one predecessor of some million modules, which each reader of a language looks through: several seconds
  std::string text = "Lsystem: 1\nderivation length: 1\nAxiom: A\n";
  for (int i = 0; i < 8'000'000; ++i) {
    text += "\"\\";
  }
  protocol::JsonWriter params;
  params.beginObject().key("source").text(text).endObject();
  const client::Outcome outcome = client->request("model.check", params.view());
  ASSERT_FALSE(outcome.has_value());
  EXPECT_EQ(member(outcome.error().data, "limit"), "callSeconds") << outcome.error().message;
}

/// The result of a message of the Language Server Protocol, or its error.
client::Outcome tellEditor(client::Client& client, const std::string& method, const std::string& parameters) {
  protocol::JsonWriter params;
  params.beginObject().key("message").text(R"({"jsonrpc":"2.0","id":1,"method":")" + method + R"(","params":)" +
                                           parameters + "}");
  return client.request("editor.message", params.endObject().view());
}

std::string openedDocument(const std::string& text) {
  protocol::JsonWriter params;
  params.beginObject().key("textDocument").beginObject().key("uri").text("file:///a.l").key("text").text(text);
  return params.endObject().endObject().take();
}

// a notification has no id
client::Outcome openInEditor(client::Client& client, const std::string& text) {
  protocol::JsonWriter params;
  params.beginObject().key("message").text(R"({"jsonrpc":"2.0","method":"textDocument/didOpen","params":)" +
                                           openedDocument(text) + "}");
  return client.request("editor.message", params.endObject().view());
}

TEST(AccountsInUse, WhatAnEditorKeepsCountsAsLongAsItsConnection) {
  const RunningServer server(withMemory(100'000'000));
  const auto watcher = connectTo(server);
  auto client = connectTo(server);
  const auto compilingBytes = [&] { return numberOf(member(statusOf(*watcher), "memory"), "compilingBytes"); };
  resultOf(tellEditor(*client, "initialize", "{}"));
  resultOf(openInEditor(*client, bigModel(10'000)));
  const std::uint64_t kept = compilingBytes();
  EXPECT_GT(kept, 2'000'000U);
  // answers do not stay
  for (int i = 0; i < 5; ++i) {
    resultOf(tellEditor(*client, "textDocument/semanticTokens/full", R"({"textDocument":{"uri":"file:///a.l"}})"));
  }
  EXPECT_GT(compilingBytes(), 2'000'000U);
  EXPECT_LT(compilingBytes(), 2 * kept);
  // a document that it may not keep is refused
  const protocol::Error error = errorOf(openInEditor(*client, bigModel(250'000)));
  EXPECT_EQ(member(error.data, "limit"), "memoryBytes") << error.message;
  client.reset();
  // a worker destroys it
  while (compilingBytes() > 0) {
    std::this_thread::yield();
  }
}

TEST(AccountsInUse, AMessageOfAnEditorThatWaitsCanBeCancelledAndKeepsNoWorker) {
  ServerOptions options;
  options.limits.callSeconds = kSecondsToDecode;
  const RunningServer server(options);
  RawPeer peer(server);
  peer.ask(kHello);
  const auto message = [](int id, const std::string& text) {
    protocol::JsonWriter params;
    params.beginObject().key("message").text(text).endObject();
    return R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":"editor.message","params":)" +
           params.take() + "}\n";
  };
  peer.send(message(2, R"({"jsonrpc":"2.0","id":1,"method":"initialize","params":{}})"));
  peer.line();
  // the first computes until it may not any more; those behind it do not count that time as theirs
  peer.send(message(
      3, R"({"jsonrpc":"2.0","method":"textDocument/didOpen","params":)" + openedDocument(bigModel(1'500'000)) + "}"));
  peer.send(message(4, R"({"jsonrpc":"2.0","id":4,"method":"shutdown"})"));
  peer.send(message(5, R"({"jsonrpc":"2.0","id":5,"method":"shutdown"})"));
  peer.send("{\"jsonrpc\":\"2.0\",\"method\":\"$/cancel\",\"params\":{\"id\":4}}\n");
  std::string line = peer.line();
  EXPECT_NE(line.find(R"("id":3)"), std::string::npos) << line;
  EXPECT_NE(line.find(R"("limit":"callSeconds")"), std::string::npos) << line;
  line = peer.line();
  EXPECT_NE(line.find(R"("id":4,"error":{"code":1010)"), std::string::npos) << line;
  line = peer.line();
  EXPECT_NE(line.find(R"("id":5,"result")"), std::string::npos) << line;
}

/// simulation.edit that puts modules in.
std::string manyModules(const std::string& simulation, std::size_t count) {
  std::string params = R"({"simulation":")" + simulation + R"(","action":"insert","plant":0,"module":0,"modules":[)";
  for (std::size_t i = 0; i < count; ++i) {
    params += i == 0 ? R"({"symbol":"A","parameters":[1]})" : R"(,{"symbol":"A","parameters":[1]})";
  }
  return params + "]}";
}

TEST(AccountsInUse, AMessageOfManyValuesThatDoesNotFitIsRefusedAndTheServerLives) {
  const RunningServer server(withMemory(100'000'000));
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kSmall);
  // a tree that is given up has arrays of millions of elements: its destructor needs memory that is not there
  for (const std::string element : {"1,", "[],", "{},"}) {
    std::string elements;
    for (int i = 0; i < 8'000'000; ++i) {
      elements += element;
    }
    RawPeer peer(server);
    peer.ask(kHello);
    peer.send(R"({"jsonrpc":"2.0","id":2,"method":"simulation.edit","params":{"modules":[)" + elements + "1]}}\n");
    const std::string line = peer.line();
    EXPECT_NE(line.find(R"("limit":"memoryBytes")"), std::string::npos) << line.substr(0, 300);
  }
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "step"), "1");
}

TEST(AccountsInUse, DecodingABigMessageEndsAfterCallSeconds) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kSmall);
  RawPeer peer(server);
  peer.ask(kHello);
  // 56 MB
  peer.send(R"({"jsonrpc":"2.0","id":2,"method":"simulation.edit","params":)" + manyModules(simulation, 1'800'000) +
            "}\n");
  const std::string line = peer.line();
  EXPECT_NE(line.find(R"("limit":"callSeconds")"), std::string::npos) << line.substr(0, 300);
  EXPECT_NE(line.find("The message was not read"), std::string::npos) << line.substr(0, 300);
  EXPECT_TRUE(peer.isClosed());
  // smaller ones are read
  EXPECT_EQ(member(resultOf(client->request("simulation.edit", manyModules(simulation, 5'000))), "step"), "0");
}

TEST(AccountsInUse, DrawingEndsAfterCallSecondsForAnswersAndForViewers) {
  ServerOptions options;
  options.limits.callSeconds = 1;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(
      *client,
      "Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> A\nhomomorphism\nmaximum depth: 40\nA --> AA\nendlsystem\n");
  const protocol::Error error = errorOf(client->request("simulation.get", named(simulation, R"("what":"turtle")")));
  EXPECT_EQ(member(error.data, "limit"), "callSeconds") << error.message;
  EXPECT_NE(error.message.find("The simulation stays at step 0."), std::string::npos) << error.message;
  resultOf(client->request("stream.open", named(simulation, R"("what":"turtle")")));
  const auto end = client->nextNotification(std::chrono::seconds(30));
  ASSERT_TRUE(end.has_value());
  EXPECT_EQ(end->method, "stream.end");
  EXPECT_NE(member(end->paramsJson, "reason").find("the limit callSeconds (1) allows"), std::string::npos)
      << end->paramsJson;
  EXPECT_EQ(member(resultOf(client->request("simulation.step", named(simulation))), "step"), "1");
}

TEST(AccountsInUse, AnEnvironmentCountsAndMayNotTakeMoreThanThereIs) {
  const RunningServer server(withMemory(200'000'000));
  const auto client = connectTo(server);
  const auto soil = [](int cells) {
    const std::string n = std::to_string(cells);
    return R"([{"type":"soil","gridSize":[)" + n + "," + n + "," + n + "]}]";
  };
  (void)create(*client, kGrowth, soil(20));
  const std::uint64_t before = numberOf(member(statusOf(*client), "memory"), "environmentBytes");
  EXPECT_GT(before, 8'000U * 8U);
  const client::Outcome outcome = client->request("simulation.create", createParams(kGrowth, soil(400)));
  ASSERT_FALSE(outcome.has_value());
  EXPECT_EQ(member(outcome.error().data, "limit"), "memoryBytes") << outcome.error().message;
  EXPECT_EQ(numberOf(member(statusOf(*client), "memory"), "environmentBytes"), before);
  EXPECT_EQ(numberOf(statusOf(*client), "simulations"), 1U);
}

TEST(AccountsInUse, AFrameThatDoesNotFitEndsItsStreamAndNothingElse) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 40\nAxiom: F(1)\nF(x) --> F(x)F(x)\nendlsystem\n");
  resultOf(client->request("simulation.step", named(simulation, R"("steps":18)")));
  resultOf(client->request("stream.open", named(simulation, R"("what":"turtle")")));
  const auto end = client->nextNotification(std::chrono::seconds(30));
  ASSERT_TRUE(end.has_value());
  EXPECT_EQ(end->method, "stream.end");
  EXPECT_NE(member(end->paramsJson, "reason").find("(limit memoryBytes)"), std::string::npos) << end->paramsJson;
  EXPECT_EQ(hashOf(*client, simulation).size(), 16U);
}

/// Asks until the memory is used up; how many times that went well.
int countUntilFull(const std::function<client::Outcome()>& ask) {
  for (int made = 0; made < 100; ++made) {
    const client::Outcome outcome = ask();
    if (!outcome) {
      EXPECT_EQ(member(outcome.error().data, "limit"), "memoryBytes") << outcome.error().message;
      return made;
    }
  }
  ADD_FAILURE() << "the memory was never used up";
  return 100;
}

TEST(AccountsInUse, TheTextOfAModelCountsAsLongAsItsSimulation) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  const std::string source = std::string(kSmall) + "/*" + std::string(4'000'000, 'x') + "*/\n";
  std::vector<std::string> names;
  const int made = countUntilFull([&] {
    client::Outcome outcome = client->request("simulation.create", createParams(source));
    if (outcome) {
      names.push_back(member(*outcome, "simulation"));
    }
    return outcome;
  });
  EXPECT_GT(made, 2);
  EXPECT_LT(made, 15);
  // a message that did not even fit while it was read has ended its connection
  const auto later = connectTo(server);
  // forks share it, and need some memory while they are made
  for (int i = 0; i < 2; ++i) {
    resultOf(later->request("simulation.delete", named(names.back())));
    names.pop_back();
  }
  while (numberOf(member(statusOf(*later), "memory"), "usedBytes") > 45'000'000) {
    std::this_thread::yield();
  }
  resultOf(later->request("simulation.fork", named(names.front())));
  for (const std::string& name : names) {
    resultOf(later->request("simulation.delete", named(name)));
  }
  while (numberOf(member(statusOf(*later), "memory"), "compilingBytes") > 1'000'000) {
    std::this_thread::yield();
  }
}

TEST(AccountsInUse, SelectionsOfStreamsCount) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kSmall);
  protocol::JsonWriter symbols;
  symbols.beginObject().key("symbols").texts(std::vector<std::string>(1'000, std::string(4'000, 'x'))).endObject();
  const std::string params = named(simulation, R"("what":"turtle","select":)" + std::string(symbols.view()));
  std::vector<std::string> streams;
  const int made = countUntilFull([&] {
    client::Outcome outcome = client->request("stream.open", params);
    if (outcome) {
      streams.push_back(member(*outcome, "stream"));
    }
    return outcome;
  });
  EXPECT_GT(made, 2);
  EXPECT_LT(made, 15);
  for (const std::string& stream : streams) {
    resultOf(client->request("stream.close", R"({"stream":")" + stream + R"("})"));
  }
  while (numberOf(member(statusOf(*client), "memory"), "frameBytes") > 1'000'000) {
    std::this_thread::yield();
  }
}

TEST(AccountsInUse, RequestsThatWaitForTheirTurnCount) {
  const RunningServer server(withMemory(60'000'000));
  const auto client = connectTo(server);
  // a step of minutes
  const std::string busy =
      create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: " + std::string(2'000, 'B') +
                          "\nB : {i = 0; while (i < 50000000) {i = i + 1;}} * --> B\nendlsystem\n");
  RawPeer stepping(server);
  (void)stepping.ask(kHello);
  stepping.send(R"({"jsonrpc":"2.0","id":2,"method":"simulation.step","params":)" + named(busy) + "}\n");
  while (member(statusOf(*client), "running") != "1") {
    std::this_thread::yield();
  }
  {
    RawPeer waiting(server);
    (void)waiting.ask(kHello);
    const std::string params = named(busy, R"("snapshot":")" + std::string(8'000'000, 'A') + R"(")");
    for (int id = 2; id < 22; ++id) {
      waiting.send(R"({"jsonrpc":"2.0","id":)" + std::to_string(id) + R"(,"method":"simulation.restore","params":)" +
                   params + "}\n");
    }
    // only a refusal comes: those that are accepted wait
    const std::string line = waiting.line();
    EXPECT_EQ(member(member(protocol::memberOf(line, "error").value_or("{}"), "data"), "limit"), "memoryBytes") << line;
    EXPECT_LE(numberOf(member(statusOf(*client), "memory"), "usedBytes"), 60'000'000U);
    // the step that others wait for goes on
    EXPECT_EQ(member(statusOf(*client), "running"), "1");
  }
  while (numberOf(member(statusOf(*client), "memory"), "decodingBytes") > 1'000'000) {
    std::this_thread::yield();
  }
  resultOf(client->request("simulation.delete", named(busy)));
}

TEST(AccountsInUse, StatesThatAreRestoredAndEditedHaveTheBoundsOfSteps) {
  // a state of eight modules from a server that allows it
  const RunningServer generous;
  const auto maker = connectTo(generous);
  const std::string original = create(*maker, kDoubling);
  const auto snapshotAt = [&](int steps) {
    resultOf(maker->request("simulation.step", named(original, R"("until":)" + std::to_string(steps))));
    return member(resultOf(maker->request("simulation.save", named(original, R"("snapshot":true)"))), "snapshot");
  };
  const std::string four = snapshotAt(2);
  const std::string eight = snapshotAt(3);
  for (const auto& [limit, bound] : {std::pair("modules", 7), std::pair("stringBytes", 79)}) {
    ServerOptions options;
    EXPECT_EQ(setLimit(options.limits, limit, static_cast<std::uint64_t>(bound)), std::nullopt);
    const RunningServer server(options);
    const auto client = connectTo(server);
    const std::string simulation = create(*client, kDoubling);
    const auto restored = [&](const std::string& snapshot) {
      return client->request("simulation.restore", named(simulation, R"("snapshot":")" + snapshot + "\""));
    };
    resultOf(restored(four));
    const protocol::Error error = errorOf(restored(eight));
    EXPECT_EQ(static_cast<int>(error.code), 1004) << error.message;
    EXPECT_EQ(member(error.data, "limit"), limit);
    EXPECT_EQ(error.message, "The strings of the new state have more than " + std::to_string(bound) +
                                 (std::string_view(limit) == "modules" ? " modules" : " bytes") + " together (limit " +
                                 limit + "). Use a smaller state, or raise the limit. The simulation stays at step 2.");
    // seven modules fit, eight do not
    const auto inserted = [&](int count) {
      std::string modules;
      for (int i = 0; i < count; ++i) {
        modules += std::string(i == 0 ? "" : ",") + R"({"symbol":"A","parameters":[1]})";
      }
      return client->request("simulation.edit",
                             named(simulation, R"("action":"insert","module":0,"modules":[)" + modules + "]"));
    };
    EXPECT_EQ(static_cast<int>(errorOf(inserted(4)).code), 1004);
    EXPECT_EQ(stringOf(*client, simulation), "A(1)A(1)A(1)A(1)");
    resultOf(inserted(3));
  }
}

}  // namespace
}  // namespace espalier::server::accounts_in_use_test
