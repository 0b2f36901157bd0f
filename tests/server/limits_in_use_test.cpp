#include <gtest/gtest.h>

#include "tests/server/raw_peer.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::limits_in_use_test {
namespace {

std::string times(std::string_view text, std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) {
    result += text;
  }
  return result;
}

std::string modelOf(const std::string& lines) {
  return "Lsystem: 1\nderivation length: 1\n" + lines + "\nendlsystem\n";
}

/// model.check of files on a server with a limit set.
std::string checked(std::string_view limit, std::uint64_t bound,
                    const std::vector<std::pair<std::string, std::string>>& files) {
  ServerOptions options;
  EXPECT_EQ(setLimit(options.limits, limit, bound), std::nullopt);
  const RunningServer server(options);
  protocol::JsonWriter params;
  params.beginObject().key("main").text("model.l").key("files").beginObject();
  for (const auto& [name, text] : files) {
    params.key(name).text(text);
  }
  params.endObject().endObject();
  return resultOf(connectTo(server)->request("model.check", params.view()));
}

struct OfModels {
  std::string_view limit;
  std::uint64_t bound;
  std::vector<std::pair<std::string, std::string>> within, beyond;
};

TEST(LimitsInUse, ThoseOfAModelsTextHoldAtTheBoundAndNotBeyond) {
  const auto included = [](int depth) {
    std::vector<std::pair<std::string, std::string>> files{
        {"model.l", "#include \"0.h\"\n" + modelOf("Axiom: A\nA --> A")}};
    for (int i = 0; i < depth; ++i) {
      files.emplace_back(std::to_string(i) + ".h",
                         i + 1 < depth ? "#include \"" + std::to_string(i + 1) + ".h\"\n" : "/* end */\n");
    }
    return files;
  };
  const auto alone = [](const std::string& text) {
    return std::vector<std::pair<std::string, std::string>>{{"model.l", text}};
  };
  const auto macros = [&](int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) {
      text += "#define M" + std::to_string(i) + " " + (i == 0 ? "1" : "M" + std::to_string(i - 1)) + "\n";
    }
    return alone(text + modelOf("Axiom: A(M" + std::to_string(depth - 1) + ")\nB --> B"));
  };
  const auto longText = [&](std::size_t bytes) {
    const std::string model = modelOf("Axiom: A\nA --> A");
    return alone(model + std::string(bytes - model.size(), '\n'));
  };
  const auto nested = [&](std::size_t depth) {
    return alone(modelOf("Axiom: A(" + times("(", depth) + "1" + times(")", depth) + ")\nB --> B"));
  };
  const std::vector<OfModels> all{
      {"arity", 3, alone(modelOf("Axiom: A(1,2,3)\nB --> B")), alone(modelOf("Axiom: A(1,2,3,4)\nB --> B"))},
      {"sourceBytes", 1'000, longText(1'000), longText(1'001)},
      {"includeDepth", 3, included(3), included(4)},
      {"macroDepth", 5, macros(5), macros(6)},
      {"arrayElements", 12, alone("Lsystem: 1\ndefine: { array a[12]; }\nAxiom: A\nA --> A\nendlsystem\n"),
       alone("Lsystem: 1\ndefine: { array a[13]; }\nAxiom: A\nA --> A\nendlsystem\n")},
      {"expressionDepth", 20, nested(18), nested(40)},
  };
  for (const OfModels& one : all) {
    const std::string within = checked(one.limit, one.bound, one.within);
    EXPECT_EQ(member(within, "valid"), "true") << one.limit << within;
    const std::string beyond = checked(one.limit, one.bound, one.beyond);
    EXPECT_EQ(member(beyond, "valid"), "false") << one.limit;
    std::string word = "aximum" + std::string(one.limit);
    word[6] = static_cast<char>(word[6] - 'a' + 'A');
    EXPECT_TRUE(beyond.find(word) != std::string::npos ||
                beyond.find("limit " + std::string(one.limit)) != std::string::npos)
        << one.limit << beyond;
  }
}

/// The error of a first step, if there is one.
std::optional<protocol::Error> stepped(std::string_view limit, std::uint64_t bound, const std::string& source) {
  ServerOptions options;
  EXPECT_EQ(setLimit(options.limits, limit, bound), std::nullopt);
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, source);
  const client::Outcome outcome = client->request("simulation.step", named(simulation));
  return outcome ? std::nullopt : std::optional(outcome.error());
}

TEST(LimitsInUse, ThoseOfAStepHoldAtTheBoundAndNotBeyond) {
  const auto turning = [](int count) {
    return modelOf("Axiom: A\nA : { i = 0; while (i < " + std::to_string(count) + ") { i = i + 1; } } 1 --> B");
  };
  const auto decomposed = [](int depth) {
    return modelOf("Axiom: B\nB --> A(" + std::to_string(depth) +
                   ")\ndecomposition\nmaximum depth: 1000\nA(n) : n > 1 --> A(n-1)\nA(n) : n == 1 --> C");
  };
  EXPECT_EQ(stepped("loopIterations", 10, turning(10)), std::nullopt);
  EXPECT_EQ(stepped("recursion", 6, decomposed(6)), std::nullopt);
  for (const auto& [limit, bound, source] :
       {std::tuple("loopIterations", 10, turning(11)), std::tuple("recursion", 6, decomposed(7))}) {
    const auto error = stepped(limit, static_cast<std::uint64_t>(bound), source);
    ASSERT_TRUE(error.has_value()) << limit;
    EXPECT_EQ(static_cast<int>(error->code), 1004) << error->message;
    EXPECT_EQ(member(error->data, "limit"), limit);
    EXPECT_EQ(member(error->data, "bound"), std::to_string(bound));
  }
}

TEST(LimitsInUse, ASessionMakesAsManySimulationsAsItMayAndAnotherItsOwn) {
  ServerOptions options;
  options.limits.simulationsPerSession = 2;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string first = create(*client, kGrowth);
  const std::string second = member(resultOf(client->request("simulation.fork", named(first))), "simulation");
  for (const auto& [method, params] :
       {std::pair("simulation.create", createParams(kGrowth)), std::pair("simulation.fork", named(first))}) {
    const protocol::Error error = errorOf(client->request(method, params));
    EXPECT_EQ(static_cast<int>(error.code), 1004);
    EXPECT_EQ(error.data, R"({"bound":2,"limit":"simulationsPerSession","value":3})");
    EXPECT_EQ(error.message,
              "the limit 'simulationsPerSession' is 2, and this is 3. Delete one that this connection made first.");
  }
  (void)create(*connectTo(server), kGrowth);
  // another connection may delete it, too
  resultOf(connectTo(server)->request("simulation.delete", named(second)));
  (void)create(*client, kGrowth);
}

TEST(LimitsInUse, APeerOffersAsManyEnvironmentsAsItMay) {
  ServerOptions options;
  options.limits.offersPerSession = 2;
  const RunningServer server(options);
  const auto client = connectTo(server);
  resultOf(client->request("environment.offer", R"({"name":"a"})"));
  resultOf(client->request("environment.offer", R"({"name":"b"})"));
  EXPECT_EQ(errorOf(client->request("environment.offer", R"({"name":"c"})")).data,
            R"({"bound":2,"limit":"offersPerSession","value":3})");
  resultOf(connectTo(server)->request("environment.offer", R"({"name":"c"})"));
}

TEST(LimitsInUse, PlantsOfOneSimulationShareItsModulesAndBytes) {
  const auto stepped = [](std::string_view limit, std::uint64_t bound) {
    ServerOptions options;
    EXPECT_EQ(setLimit(options.limits, limit, bound), std::nullopt);
    const RunningServer server(options);
    const auto client = connectTo(server);
    const std::string simulation =
        create(*client, "Lsystem: 1\nderivation length: 9\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n", {},
               R"("plants":[{"position":[0,0,0]},{"position":[1,0,0]},{"position":[2,0,0]}])");
    const client::Outcome outcome = client->request("simulation.step", named(simulation, R"("steps":2)"));
    if (outcome) {
      return std::string();
    }
    const protocol::Error& error = outcome.error();
    EXPECT_EQ(member(error.data, "limit"), limit);
    EXPECT_EQ(member(error.data, "bound"), std::to_string(bound));
    EXPECT_EQ(member(error.data, "step"), "1");
    EXPECT_EQ(stringOf(*client, simulation), "A(1)A(1)");
    return error.message;
  };
  // three strings of four modules, with ten bytes each
  EXPECT_EQ(stepped("modules", 12), "");
  EXPECT_EQ(stepped("stringBytes", 120), "");
  EXPECT_EQ(
      stepped("modules", 11),
      "step 2: the strings of all plants have more than 11 modules together (limit modules). Grow fewer plants, or "
      "raise the limit. The simulation stays at step 1.");
  EXPECT_EQ(
      stepped("stringBytes", 119),
      "step 2: the strings of all plants have more than 119 bytes together (limit stringBytes). Grow fewer plants, "
      "or raise the limit. The simulation stays at step 1.");
}

TEST(LimitsInUse, AnAnswerIsAsLongAsTheOutboxAndNotLonger) {
  constexpr std::uint64_t kBound = 20'000;
  ServerOptions options;
  options.limits.outboxBytes = kBound;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::size_t head = std::string_view(R"({"step":0,"string":""})").size();
  const auto asked = [&](std::size_t bytes) {
    const std::string simulation = create(*client, modelOf("Axiom: " + times("F", bytes - head) + "\nB --> B"));
    return client->request("simulation.get", named(simulation, R"("what":"string")"));
  };
  EXPECT_EQ(resultOf(asked(kBound)).size(), kBound);
  const protocol::Error error = errorOf(asked(kBound + 1));
  EXPECT_EQ(static_cast<int>(error.code), 1004);
  EXPECT_EQ(error.data, R"({"bound":20000,"limit":"outboxBytes","value":20001})");
  EXPECT_EQ(error.message,
            "the limit 'outboxBytes' is 20000, and this is 20001. Ask for less at a time, or start the server with a higher "
            "--limit outboxBytes=N.");
}

TEST(LimitsInUse, AFrameIsAsLongAsTheOutboxAndNotLonger) {
  constexpr std::uint64_t kBound = 20'000;
  ServerOptions options;
  options.limits.outboxBytes = kBound;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const auto shown = [&](std::size_t modules) {
    const std::string simulation = create(*client, modelOf("Axiom: " + times("F", modules) + "\nB --> B"));
    resultOf(client->request("stream.open", named(simulation, R"("what":"string")")));
    const auto frame = client->nextNotification(std::chrono::seconds(30));
    EXPECT_TRUE(frame.has_value());
    return frame.value_or(client::Notification{});
  };
  const std::size_t head = std::string_view(R"("string":"")").size();
  EXPECT_EQ(shown(kBound - head).method, "stream.data");
  const auto end = shown(kBound - head + 1);
  EXPECT_EQ(end.method, "stream.end");
  EXPECT_EQ(member(end.paramsJson, "reason"),
            "a frame has 20001 bytes, and at most 20000 may be on their way (outboxBytes). Select fewer symbols, take "
            "blocks in single precision, or start the server with a higher --limit outboxBytes=N.");
}

/// Whether all steps of a growing plant could be saved in so many bytes.
bool isSavedIn(std::uint64_t storeBytes) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  options.limits.storeBytes = storeBytes;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const client::Outcome created = client->request(
      "simulation.create",
      createParams("Lsystem: 1\nderivation length: 13\nAxiom: A(1)\nA(x) --> A(ran(1))A(ran(1))\nendlsystem\n", {},
                   R"("seed":1)"));
  if (!created) {
    EXPECT_EQ(static_cast<int>(created.error().code), 1014) << created.error().message;
    return false;
  }
  const client::Outcome outcome = client->request("simulation.run", named(member(created.value(), "simulation")));
  if (!outcome) {
    EXPECT_EQ(static_cast<int>(outcome.error().code), 1014) << outcome.error().message;
    return false;
  }
  return true;
}

TEST(LimitsInUse, TheDataFolderTakesAsManyPagesAsItMayAndNotOneMore) {
  constexpr std::uint64_t kPage = 4'096;
  std::uint64_t tooFew = 20;
  std::uint64_t enough = 400;
  ASSERT_FALSE(isSavedIn(tooFew * kPage));
  ASSERT_TRUE(isSavedIn(enough * kPage));
  while (enough - tooFew > 1) {
    const std::uint64_t middle = (tooFew + enough) / 2;
    (isSavedIn(middle * kPage) ? enough : tooFew) = middle;
  }
  EXPECT_TRUE(isSavedIn(enough * kPage));
  EXPECT_FALSE(isSavedIn(enough * kPage - 1));
}

}  // namespace
}  // namespace espalier::server::limits_in_use_test
