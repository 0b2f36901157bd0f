#include "server/remote/hosting/environment_host.h"

#include <chrono>
#include <csignal>
#include <future>
#include <memory>
#include <vector>

#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/registry.h"
#include "server/remote/hosting/environment_dialogue.h"
#include "server/remote/remote_environment.h"
#include "server/running/turn_meter.h"
#include "tests/server/raw_peer.h"
#include "tests/support/places.h"

namespace espalier::server::environment_host_test {
namespace {

using turtle::EnvironmentProcess;

std::unique_ptr<EnvironmentProcess> builtIn(const std::string& name, const std::string& configuration = "") {
  auto made = environment::makeProcess(name, configuration);
  EXPECT_TRUE(made.has_value()) << name;
  return std::move(made.value());
}

std::unique_ptr<EnvironmentProcess> remote(const std::string& address, bool isTextOnly = false) {
  auto connected = connectRemoteEnvironment(address, {.isTextOnly = isTextOnly, .configurationJson = {}});
  if (!connected) {
    ADD_FAILURE() << connected.error();
    return nullptr;
  }
  return std::move(connected.value());
}

/// Tips that turn by irrational angles and ask on the way, so that every number has all its digits.
constexpr std::string_view kBush =
    "Lsystem: 1\nderivation length: 6\nAxiom: A(1,1)\n"
    "A(l,v) --> F(l)[+(31.7)/(77.3)?E(v)B(l*0.83,v)][-(23.9)/(11.1)?E(v*0.9)B(l*0.79,v)]\n"
    "?E(v) < B(l,w) : v > 0.05 --> A(l,w*0.97)\n?E(v) < B(l,w) : v <= 0.05 --> *\nendlsystem\n";

/// The strings after each step.
std::vector<std::string> grow(std::unique_ptr<EnvironmentProcess> process, std::string_view model = kBush) {
  core::MemoryFileProvider files({{"model.l", std::string(model)}});
  language::CompileInput input;
  input.modelFile = "model.l";
  const auto compiled = language::compile(input, files);
  EXPECT_NE(compiled.program, nullptr);
  simulation::Simulation simulation(compiled.program, {turtle::PlantPlacement{}}, std::move(process), {});
  EXPECT_FALSE(simulation.rewind().has_value());
  std::vector<std::string> strings;
  while (!simulation.isFinished()) {
    const auto error = simulation.step();
    if (error) {
      ADD_FAILURE() << error->message;
      break;
    }
    strings.push_back(simulation.stringText());
  }
  return strings;
}

/// A built-in process served on a free port until the end of the scope.
class Hosted {
 public:
  explicit Hosted(const std::string& name) : Hosted([name] { return builtIn(name); }) {}
  explicit Hosted(ProcessFactory factory, const HostAddress& where = {}) {
    std::promise<std::uint16_t> listening;
    auto port = listening.get_future();
    thread_ = std::thread([factory = std::move(factory), where, &listening] {
      const auto problem = hostEnvironment(where, factory, [&listening](std::uint16_t p) { listening.set_value(p); });
      EXPECT_EQ(problem, std::nullopt);
    });
    address_ = "tcp://127.0.0.1:" + std::to_string(port.get());
  }
  ~Hosted() {
    ::kill(::getpid(), SIGTERM);
    thread_.join();
  }
  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  std::string address_;
  std::thread thread_;
};

TEST(EnvironmentHost, TcpAndStdioGiveBitwiseTheSameStringsAsInProcess) {
  for (const std::string name : {"honda", "shadow", "height"}) {
    SCOPED_TRACE(name);
    const auto inside = grow(builtIn(name));
    EXPECT_EQ(inside.size(), 6U);
    const Hosted hosted(name);
    EXPECT_EQ(grow(remote(hosted.address())), inside);
    EXPECT_EQ(grow(remote("stdio:exec '" + buildFolder() + "/bin/espalier' environment " + name + " --stdio")), inside);
  }
}

TEST(EnvironmentHost, MessagesThatComeInPartHaveABoundTogether) {
  HostAddress where;
  where.heldBytes = 1'000'000;
  const Hosted hosted([] { return builtIn("height"); }, where);
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  RawPeer hostile(address);
  hostile.send(std::string(1'500'000, 'x'));
  EXPECT_NE(hostile.line().find("the limit 'decodingBytes' is 1000000"), std::string::npos);
  EXPECT_TRUE(hostile.isClosed());
  EXPECT_EQ(RawPeer(address).ask(R"({"jsonrpc":"2.0","id":1,"method":"ping"})"),
            R"({"jsonrpc":"2.0","id":1,"result":{}})");
}

/// Answers with what it sees of the geometry, in numbers with all their digits: the area and mean height of the organ
/// behind the module, over the length of all segments.
class Canopy final : public EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "canopy";
    description.needs.parameters = true;
    description.needs.geometry = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (queries.geometry == nullptr) {
      return turtle::EnvironmentError{"no geometry came", false};
    }
    const turtle::Geometry& geometry = *queries.geometry;
    double length = 0.0;
    for (std::size_t i = 0; i < geometry.segments.size(); ++i) {
      length += core::length(geometry.end[i] - geometry.start[i]) * geometry.startWidth[i];
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      for (std::size_t organ = 0; organ < geometry.organs.size(); ++organ) {
        if (geometry.organs.plant[organ] != queries.plant[query] ||
            geometry.organs.module[organ] != queries.module[query] + 1) {
          continue;
        }
        double area = 0.0;
        for (std::uint64_t t = geometry.triangleOffset[organ]; t < geometry.triangleOffset[organ + 1]; ++t) {
          const auto& [a, b, c] = geometry.triangles[t];
          const core::Vec3& origin = geometry.vertices[a];
          area += core::length(core::cross(geometry.vertices[b] - origin, geometry.vertices[c] - origin)) + origin.y;
        }
        replies.set(queries, query, 0, area / (1.0 + length) + geometry.organs.colour[organ]);
      }
    }
    return std::nullopt;
  }
};

TEST(EnvironmentHost, GeometryCrossesWholeAndAsDifferencesWithTheSameBits) {
  const ProcessFactory factory = [] { return std::make_unique<Canopy>(); };
  const Hosted hosted(factory);
  // leaves that grow, turn with what they get, and fall
  const std::string model =
      "Lsystem: 1\nderivation length: 7\nAxiom: A(1)\n"
      "A(l) --> !(l*0.1);(3)F(l)[+(31.7)?E(0)L(l,0)]/(77.3)A(l*0.93)\n"
      "?E(x) < L(s,n) : n < 3 --> L(s*1.1+x*0.01,n+1)\nL(s,n) : n >= 3 --> *\n"
      "homomorphism\nL(s,n) --> ,(s*10){.f(s)-(70+n)f(s)-(60)f(s)}\nendlsystem\n";
  const std::vector<std::string> inside = grow(std::make_unique<Canopy>(), model);
  ASSERT_EQ(inside.size(), 7U);
  EXPECT_NE(inside[6].find("?E(3"), std::string::npos) << inside[6];
  EXPECT_EQ(grow(remote(hosted.address()), model), inside);
  EXPECT_EQ(grow(remote(hosted.address(), true), model), inside);
}

TEST(EnvironmentDialogue, AGeometryThatDoesNotFitIsRefused) {
  const ProcessFactory factory = [] { return std::make_unique<Canopy>(); };
  EnvironmentDialogue dialogue(factory, {});
  const auto ask = [&dialogue](const std::string& geometry) {
    return dialogue.answer(protocol::decodeMessage(
        R"({"jsonrpc":"2.0","id":1,"method":"environment.step","params":{"simulation":"s","step":0,"queries":[],)"
        R"("geometry":{"widths":"world","symbols":[],"segmentPlant":[],"segmentModule":[],"segmentSymbol":[],)"
        R"("segmentColour":[],"segmentOrder":[],"segmentStart":[],"segmentEnd":[],"segmentStartWidth":[],)"
        R"("segmentEndWidth":[],"organPlant":[],"organModule":[],"organSymbol":[],"organColour":[],"organOrder":[],)"
        R"("organKind":[],"organVertices":[],"organTriangles":[],"vertices":[],"triangles":[],)" +
        geometry + "}}}"));
  };
  EXPECT_NE(ask(R"("form":"difference","segmentRuns":[],"organRuns":[])")
                ->find("params.geometry: it is a difference, but no geometry came before it; send the whole geometry"),
            std::string::npos);
  EXPECT_NE(ask(R"("form":"whole")")->find(R"("replies":[])"), std::string::npos);
  EXPECT_NE(ask(R"("form":"difference","segmentRuns":[[0,1,0]],"organRuns":[])")
                ->find("params.geometry: the runs of segments take more rows than the 0 before and the 0 new ones"),
            std::string::npos);
}

constexpr std::string_view kDescribe = R"({"jsonrpc":"2.0","id":1,"method":"environment.describe"})";

TEST(EnvironmentHost, AConnectionThatSaysNothingIsClosed) {
  const Hosted hosted([] { return builtIn("height"); }, {.firstMessage = std::chrono::milliseconds(50)});
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  RawPeer speaking(address);
  EXPECT_NE(speaking.ask(kDescribe).find(R"("name":"height")"), std::string::npos);
  RawPeer silent(address);
  RawPeer rubbish(address);
  rubbish.send("rubbish\n");
  EXPECT_TRUE(silent.isClosed());
  EXPECT_TRUE(rubbish.isClosed());
  // one that has spoken may be silent for long
  EXPECT_NE(speaking.ask(kDescribe).find(R"("name":"height")"), std::string::npos);
}

TEST(EnvironmentHost, SilentConnectionsGiveWay) {
  const Hosted hosted("height");
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  RawPeer speaking(address);
  EXPECT_NE(speaking.ask(kDescribe).find(R"("name":"height")"), std::string::npos);
  std::vector<std::unique_ptr<RawPeer>> silent;
  for (int i = 0; i < 130; ++i) {
    silent.push_back(std::make_unique<RawPeer>(address));
  }
  EXPECT_TRUE(silent.front()->isClosed());
  EXPECT_NE(silent.back()->ask(kDescribe).find(R"("name":"height")"), std::string::npos);
  EXPECT_NE(speaking.ask(kDescribe).find(R"("name":"height")"), std::string::npos);
}

std::string closeRequest(int simulation) {
  return R"({"jsonrpc":"2.0","id":1,"method":"environment.close","params":{"simulation":")" +
         std::to_string(simulation) + "\"}}";
}

std::string openRequest(int simulation) {
  return R"({"jsonrpc":"2.0","id":1,"method":"environment.open","params":{"simulation":")" +
         std::to_string(simulation) + "\"}}";
}

TEST(EnvironmentHost, ConnectionsThatHaveSpokenAndHaveNoSimulationGiveWay) {
  const Hosted hosted([] { return builtIn("height"); }, {.connections = 4});
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  RawPeer used(address);
  EXPECT_NE(used.ask(openRequest(1)).find("result"), std::string::npos);
  std::vector<std::unique_ptr<RawPeer>> idle;
  for (int i = 0; i < 8; ++i) {
    idle.push_back(std::make_unique<RawPeer>(address));
    EXPECT_NE(idle.back()->ask(kDescribe).find(R"("name":"height")"), std::string::npos);
  }
  EXPECT_TRUE(idle.front()->isClosed());
  EXPECT_NE(idle.back()->ask(kDescribe).find(R"("name":"height")"), std::string::npos);
  EXPECT_NE(used.ask(kDescribe).find(R"("name":"height")"), std::string::npos);
}

TEST(EnvironmentHost, AConnectionForWhichThereIsNoPlaceIsToldSo) {
  const Hosted hosted([] { return builtIn("height"); }, {.connections = 2});
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  RawPeer first(address);
  RawPeer second(address);
  EXPECT_NE(first.ask(openRequest(1)).find("result"), std::string::npos);
  EXPECT_NE(second.ask(openRequest(2)).find("result"), std::string::npos);
  RawPeer third(address);
  EXPECT_NE(third.line().find("the limit 'connections' is 2, and this is 3. All of them have simulations."),
            std::string::npos);
  EXPECT_TRUE(third.isClosed());
  // the user of a simulation reads it, too
  const auto refused = connectRemoteEnvironment(hosted.address(), {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().find("the limit 'connections' is 2"), std::string::npos) << refused.error();
  // a connection that closes its simulation makes room
  EXPECT_NE(first.ask(closeRequest(1)).find("result"), std::string::npos);
  std::string answer;
  for (int i = 0; i < 1000 && answer.find(R"("name":"height")") == std::string::npos; ++i) {
    answer = RawPeer(address).ask(kDescribe);
  }
  EXPECT_NE(answer.find(R"("name":"height")"), std::string::npos) << answer;
}

/// Has much memory.
class Hoard final : public EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return {}; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    hoard_.resize(4'000'000);
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch&, turtle::ReplyBatch&) override {
    return std::nullopt;
  }

 private:
  std::vector<char> hoard_;
};

TEST(EnvironmentHost, SimulationsHaveABoundOfTheirMemoryTogether) {
  ASSERT_TRUE(isHeapMetered());
  const Hosted hosted([] { return std::make_unique<Hoard>(); }, {.memoryBytes = 50'000'000});
  const std::string address = hosted.address().substr(std::string_view("tcp://").size());
  {
    RawPeer hostile(address);
    int opened = 0;
    std::string answer = hostile.ask(openRequest(opened));
    while (answer.find("result") != std::string::npos && opened < 100) {
      answer = hostile.ask(openRequest(++opened));
    }
    EXPECT_GE(opened, 11);
    EXPECT_LE(opened, 13);
    EXPECT_NE(answer.find(R"("id":1,"error":{"code":1004,"message":"the limit 'memoryBytes' is 50000000)"),
              std::string::npos)
        << answer;
    // one that is closed makes room
    EXPECT_NE(hostile.ask(closeRequest(0)).find("result"), std::string::npos);
    EXPECT_NE(hostile.ask(openRequest(0)).find("result"), std::string::npos);
    // another connection that has little goes on
    EXPECT_NE(RawPeer(address).ask(openRequest(0)).find("result"), std::string::npos);
    // a message for which there is no room
    hostile.send(R"({"jsonrpc":"2.0","id":1,"method":"environment.step","params":{"queries":[)");
    for (int i = 0; i < 4000; ++i) {
      hostile.send("[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],[],");
    }
    hostile.send("[]]}}\n");
    answer = hostile.line();
    EXPECT_NE(answer.find("the limit 'memoryBytes'"), std::string::npos) << answer;
    EXPECT_TRUE(hostile.isClosed());
  }
  // what was held is there again
  RawPeer next(address);
  for (int i = 0; i < 8; ++i) {
    EXPECT_NE(next.ask(openRequest(i)).find("result"), std::string::npos);
  }
}

TEST(EnvironmentHost, AnAddressThatOtherMachinesReachIsRefusedUnlessAllowed) {
  const auto problem = hostEnvironment(
      {.host = "0.0.0.0"}, [] { return builtIn("height"); }, [](std::uint16_t) { ADD_FAILURE() << "listens"; });
  EXPECT_EQ(problem.value_or(""),
            "'0.0.0.0' can be reached from other machines, and an environment does not ask for a token: add --insecure "
            "if that "
            "is acceptable, or listen on 127.0.0.1.");
}

TEST(EnvironmentHost, APortInUseIsAnErrorThatSaysWhatToDo) {
  const RunningServer server;
  const std::string address = server.address();
  const auto port = static_cast<std::uint16_t>(std::stoi(address.substr(address.find(':') + 1)));
  const auto problem = hostEnvironment(
      {.port = port}, [] { return builtIn("height"); }, [](std::uint16_t) {});
  ASSERT_TRUE(problem.has_value());
  EXPECT_NE(problem->find("Choose another port, or 0 for a free one."), std::string::npos) << *problem;
}

// ---- the dialogue without a network ----

std::string ask(EnvironmentDialogue& dialogue, const std::string& method, const std::string& params) {
  return dialogue
      .answer(
          protocol::decodeMessage(R"({"jsonrpc":"2.0","id":1,"method":")" + method + R"(","params":)" + params + "}"))
      .value_or("(nothing)");
}

TEST(EnvironmentDialogue, AMinimalControllerNeedsNeitherHelloNorOpen) {
  const ProcessFactory factory = [] { return builtIn("height"); };
  EnvironmentDialogue dialogue(factory, {});
  EXPECT_EQ(
      member(
          ask(dialogue, "environment.step",
              R"({"simulation":"a","step":0,"queries":[{"id":0,"symbol":"E","parameters":[5],"position":[1,2.5,3]}]})"),
          "result"),
      R"({"replies":[{"id":0,"parameters":[2.5]}]})");
}

TEST(EnvironmentDialogue, AConnectionHasSoManySimulationsAndNoMore) {
  const ProcessFactory factory = [] { return builtIn("constant", R"({"values":[1]})"); };
  EnvironmentDialogue dialogue(factory, {});
  const auto about = [&dialogue](const std::string& method, std::size_t simulation) {
    return ask(dialogue, method, R"({"simulation":"sim-)" + std::to_string(simulation) + R"("})");
  };
  for (std::size_t i = 0; i < EnvironmentDialogue::kMostSimulations; ++i) {
    ASSERT_NE(about("environment.open", i).find("result"), std::string::npos) << i;
  }
  EXPECT_NE(about("environment.open", 10'000).find(R"("code":1004)"), std::string::npos);
  // those that are there may be opened again, and a closed one makes room
  EXPECT_NE(about("environment.open", 7).find("result"), std::string::npos);
  EXPECT_NE(about("environment.close", 8).find("result"), std::string::npos);
  EXPECT_NE(about("environment.open", 10'000).find("result"), std::string::npos);
}

TEST(EnvironmentDialogue, EveryProcessIsOpenedForAControllerThatDoesNotOpenIt) {
  for (const std::string& name : environment::processNames()) {
    SCOPED_TRACE(name);
    const auto made = environment::makeProcess(name, "");
    if (!made) {
      continue;  // it needs a configuration
    }
    const ProcessFactory factory = [&name] { return builtIn(name); };
    for (const std::string first : {"environment.step", "environment.save"}) {
      EnvironmentDialogue dialogue(factory, {});
      // the answer is a result, or says what the process needs
      const std::string step =
          R"("step":0,"queries":[{"id":0,"symbol":"E","parameters":[9,1],"position":[1,2.5,3],"heading":[0,1,0],)"
          R"("left":[-1,0,0],"up":[0,0,1]}])";
      const std::string answer = ask(dialogue, first, R"({"simulation":"a",)" + step + "}");
      EXPECT_EQ(answer.find("-32603"), std::string::npos) << answer;
      const std::string again = ask(dialogue, "environment.step", R"({"simulation":"a",)" + step + "}");
      EXPECT_EQ(again.find("-32603"), std::string::npos) << again;
    }
  }
}

TEST(EnvironmentDialogue, DescribesTheProcess) {
  const ProcessFactory factory = [] { return builtIn("height"); };
  EnvironmentDialogue dialogue(factory, {});
  const std::string description = member(ask(dialogue, "environment.describe", "{}"), "result");
  EXPECT_EQ(member(description, "name"), "height");
  EXPECT_EQ(member(description, "needs"), R"(["position"])");
}

TEST(EnvironmentDialogue, ErrorsNameThePathAndTheMethods) {
  const ProcessFactory factory = [] { return builtIn("height"); };
  EnvironmentDialogue dialogue(factory, {});
  EXPECT_EQ(member(member(ask(dialogue, "environment.step", R"({"simulation":"a","step":-1,"queries":[]})"), "error"),
                   "message"),
            "params.step: expected a whole number from 0 to 9007199254740992, found -1");
  EXPECT_EQ(member(member(ask(dialogue, "simulation.step", "{}"), "error"), "code"), "-32601");
  EXPECT_EQ(
      member(member(ask(dialogue, "environment.open", R"({"simulation":"a","configuration":{"radius":1}})"), "error"),
             "message")
          .substr(0, 20),
      "params.configuration");
  EXPECT_EQ(dialogue.answer(protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"environment.close","params":{}})")),
            std::nullopt);
}

/// Counts its steps in what it answers: a process whose state shows.
class Counter final : public EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "counter";
    description.isStateful = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    count_ = 0;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    ++count_;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      replies.set(queries, i, 0, count_);
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string save() const override { return std::to_string(count_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    count_ = std::stoi(std::string(state));
    return std::nullopt;
  }

 private:
  int count_ = 0;
};

std::string stepParams(int step) {
  return R"({"simulation":"a","step":)" + std::to_string(step) +
         R"(,"queries":[{"id":0,"symbol":"E","parameters":[0]}]})";
}

TEST(EnvironmentDialogue, AStepAskedAgainIsAnsweredTheSameWithoutAdvancing) {
  const ProcessFactory factory = [] { return std::make_unique<Counter>(); };
  EnvironmentDialogue dialogue(factory, {});
  const std::string first = ask(dialogue, "environment.step", stepParams(0));
  EXPECT_EQ(ask(dialogue, "environment.step", stepParams(0)), first);
  EXPECT_EQ(member(ask(dialogue, "environment.step", stepParams(1)), "result"),
            R"({"replies":[{"id":0,"parameters":[2]}]})");
  EXPECT_EQ(member(member(ask(dialogue, "environment.step", stepParams(0)), "error"), "code"), "1007");
}

TEST(EnvironmentDialogue, SaveAndRestoreCarryTheStateOfASimulation) {
  const ProcessFactory factory = [] { return std::make_unique<Counter>(); };
  EnvironmentDialogue dialogue(factory, {});
  (void)ask(dialogue, "environment.step", stepParams(0));
  const std::string state =
      member(member(ask(dialogue, "environment.save", R"({"simulation":"a"})"), "result"), "state");
  (void)ask(dialogue, "environment.step", stepParams(1));
  (void)ask(dialogue, "environment.restore", R"({"simulation":"a","state":")" + state + "\"}");
  EXPECT_EQ(member(ask(dialogue, "environment.step", stepParams(1)), "result"),
            R"({"replies":[{"id":0,"parameters":[2]}]})");
  // another simulation has a process of its own
  EXPECT_EQ(member(ask(dialogue, "environment.step",
                       R"({"simulation":"b","step":0,"queries":[{"id":0,"symbol":"E","parameters":[0]}]})"),
                   "result"),
            R"({"replies":[{"id":0,"parameters":[1]}]})");
}

}  // namespace
}  // namespace espalier::server::environment_host_test
