#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cpp/client.h"
#include "clients/espalier/commands/commands.h"
#include "clients/espalier/conformance/program_output.h"
#include "clients/espalier/messages.h"
#include "engine/core/elementary.h"
#include "protocol/json_text.h"
#include "server/remote/models/gallery.h"
#include "server/remote/processes/line_channel.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using conformance::quoted;

constexpr std::chrono::seconds kPatience{30};

/// A sentence about what does not hold, or nothing.
using Problem = std::optional<std::string>;

struct GalleryHash {
  const char* model;
  int steps;
  const char* hash;
};

constexpr GalleryHash kHashes[] = {
#define ESPALIER_SELF_TEST_HASH(model, steps, hash) {model, steps, hash},
#include "clients/espalier/installation/self_test.def"
};

/// The common parts of the tests: this program, and a folder for their files.
class Installation {
 public:
  Installation() {
    std::error_code error;
    program_ = fs::read_symlink("/proc/self/exe", error).string();
    std::string pattern = (fs::temp_directory_path(error) / "espalier-self-test-XXXXXX").string();
    folder_ = ::mkdtemp(pattern.data()) != nullptr ? pattern : std::string();
  }
  ~Installation() {
    std::error_code ignored;
    if (!folder_.empty()) {
      fs::remove_all(folder_, ignored);
    }
  }
  Installation(const Installation&) = delete;
  Installation& operator=(const Installation&) = delete;

  [[nodiscard]] const std::string& program() const { return program_; }
  [[nodiscard]] bool hasFolder() const { return !folder_.empty(); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(fs::path(folder_) / name) << text;
  }

  /// Standard output of this program with arguments in the form of the shell; the error says how it ended.
  [[nodiscard]] tl::expected<std::string, std::string> run(const std::string& arguments) const {
    auto done = conformance::runProgram(quoted(program_) + " " + arguments, folder_, {.time = 4 * kPatience});
    if (!done) {
      return tl::unexpected("espalier " + arguments + " " + done.error());
    }
    if (done->status != 0) {
      return tl::unexpected("espalier " + arguments + " ended with " + std::to_string(done->status) + ": " +
                            done->errors);
    }
    return done->output;
  }

 private:
  std::string program_;
  std::string folder_;
};

std::string withoutLineEnd(std::string text) {
  while (!text.empty() && text.back() == '\n') {
    text.pop_back();
  }
  return text;
}

Problem conformanceProblem(const Installation& installation) {
  const auto done = conformance::runProgram(
      quoted(installation.program()) + " conformance --kind deterministic --quiet", "/", {.time = 4 * kPatience});
  if (!done) {
    return "the suite " + done.error();
  }
  return done->status == 0 ? Problem() : withoutLineEnd(done->output + done->errors);
}

Problem bitsProblem(const Installation& installation) {
  const std::string gallery = server::galleryOfProgram();
  if (gallery.empty()) {
    return "there is no gallery beside the program (share/espalier/gallery): install it whole";
  }
  for (const GalleryHash& entry : kHashes) {
    const auto hash = installation.run("derive " + quoted((fs::path(gallery) / entry.model).string()) +
                                       " --seed 1 --hash --quiet --steps " + std::to_string(entry.steps));
    if (!hash) {
      return hash.error();
    }
    if (withoutLineEnd(*hash) != entry.hash) {
      return std::string(entry.model) + " has the state " + withoutLineEnd(*hash) + " after " +
             std::to_string(entry.steps) + " steps, not " + entry.hash +
             ": plants of this installation are other plants";
    }
  }
  return std::nullopt;
}

/// The number behind the last comma or parenthesis of the answered string of step 0 or 1, which must be near a value.
Problem answerProblem(const Installation& installation, const std::string& model, const std::string& environment,
                      std::size_t line, double expected) {
  installation.write("model.l", model);
  installation.write("environment.json", environment);
  const auto text = installation.run("derive model.l --environment environment.json --every --answered --quiet");
  if (!text) {
    return text.error();
  }
  std::string row = *text;
  for (std::size_t skipped = 0; skipped < line && row.find('\n') != std::string::npos; ++skipped) {
    row.erase(0, row.find('\n') + 1);
  }
  row.resize(std::min(row.find('\n'), row.size()));
  const std::size_t begin = row.find_last_of(",(");
  const double value = begin == std::string::npos ? std::nan("") : std::strtod(row.c_str() + begin + 1, nullptr);
  if (!(std::abs(value - expected) <= 1e-9 * std::abs(expected))) {
    return "expected " + std::to_string(expected) + " at the end of '" + row + "' with " + environment;
  }
  return std::nullopt;
}

Problem lightProblem(const Installation& installation) {
  // a sensor under the open sky sees all of its 200 W/m²; under leaf area 1 it sees exp(-1) of the light from above
  if (auto problem = answerProblem(installation, "Lsystem: 1\nderivation length: 1\nAxiom: ?E(0,0,0)\nendlsystem\n",
                                   R"({"type": "light"})", 0, 200.0)) {
    return problem;
  }
  return answerProblem(
      installation, "Lsystem: 1\nderivation length: 1\nAxiom: ?E(0)\nendlsystem\n",
      R"({"type": "light-voxels", "method": "turbid", "gridSize": [1, 4, 1], "voxelSize": 0.25, "periodic": true,
 "position": [-0.125, 0, -0.125], "leafAngles": "horizontal", "directions": [[0, 1, 0, 1]], "leafAreaDensity": [1, 1, 1, 1]})",
      0, core::exp(-1.0));
}

Problem soilProblem(const Installation& installation) {
  // water above a water table stays in equilibrium: 0.475 above it the pressure head is -0.475, also after a day
  return answerProblem(
      installation, "Lsystem: 1\nderivation length: 2\nAxiom: @M(0,-0.525,0)?E(0,0)\nE(a,h) --> E(0,h)\nendlsystem\n",
      R"({"type": "soil-water", "initially": "waterTable", "waterTableDepth": 1, "bottom": "closed"})", 1, -0.475);
}

/// A server of this program on free ports of this machine, which ends with the object.
class OwnServer {
 public:
  [[nodiscard]] static tl::expected<OwnServer, std::string> start(const Installation& installation) {
    auto started = server::ChildProcess::start({installation.program(), "serve", "--listen", "127.0.0.1:0", "--http",
                                                "127.0.0.1:0", "--log-level", "off", "--until-input-ends"});
    if (!started) {
      return tl::unexpected(started.error());
    }
    OwnServer own;
    own.child_ = std::make_unique<server::ChildProcess>(std::move((*started)->process));
    own.lines_ =
        std::make_unique<server::LineChannel>(std::move((*started)->input), std::move((*started)->output), 4096);
    for (auto [before, address] : {std::pair{"listening on ", &own.address_}, std::pair{"http on ", &own.http_}}) {
      std::string line;
      if (own.lines_->readLine(line, Clock::now() + kPatience) != server::LineChannel::Status::Done ||
          !line.starts_with(before)) {
        return tl::unexpected("the server does not say '" + std::string(before) + "HOST:PORT'; its last line: '" +
                              line + "'");
      }
      *address = line.substr(std::string(before).size());
    }
    return own;
  }

  [[nodiscard]] const std::string& address() const { return address_; }

  /// The answer to a request for a page, with its header.
  [[nodiscard]] tl::expected<std::string, std::string> page(const std::string& path) const {
    auto socket = server::dialTcp(http_, Clock::now() + kPatience);
    if (!socket) {
      return tl::unexpected(socket.error());
    }
    server::LineChannel channel(std::move(*socket), {}, 4096);
    (void)channel.write("GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n",
                        Clock::now() + kPatience);
    std::string answer;
    std::string part;
    while (channel.receive(part, Clock::now() + kPatience) == server::LineChannel::Status::Done) {
      answer += part;
    }
    return answer;
  }

 private:
  OwnServer() = default;

  std::unique_ptr<server::ChildProcess> child_;
  std::unique_ptr<server::LineChannel> lines_;
  std::string address_;
  std::string http_;
};

Problem serverProblem(const Installation& installation) {
  const auto own = OwnServer::start(installation);
  if (!own) {
    return own.error();
  }
  client::ClientOptions options;
  options.name = "espalier self-test";
  const auto client = client::Client::connect(own->address(), options);
  if (!client) {
    return client.error().message;
  }
  const auto created = (*client)->request(
      "simulation.create",
      R"({"model":{"source":"Lsystem: 1\nderivation length: 5\nAxiom: A?E(0)\nA?E(h) : h < 2 --> F(1)A?E(0)\nendlsystem\n"},)"
      R"("environment":[{"type":"height"}],"seed":1})");
  if (!created) {
    return created.error().message;
  }
  const std::string params = R"({"simulation":")" + protocol::memberOf(*created, "simulation").value_or("") + "\"";
  const auto stepped = (*client)->request("simulation.step", params + R"(,"steps":5})");
  const auto text = (*client)->request("simulation.get", params + R"(,"what":"string"})");
  if (!stepped || !text) {
    return (!stepped ? stepped.error() : text.error()).message;
  }
  if (text->find("F(1)F(1)A?E(2)") == std::string::npos) {
    return "a plant that grows to the height 2 has the string " + *text;
  }
  return std::nullopt;
}

Problem pageProblem(const Installation& installation) {
  const auto own = OwnServer::start(installation);
  if (!own) {
    return own.error();
  }
  for (const auto& [path, content] :
       {std::pair{"/", "<html"}, std::pair{"/studio.js", "WebSocket"}, std::pair{"/health", "\"status\":\"ok\""}}) {
    const auto answer = own->page(path);
    if (!answer) {
      return answer.error();
    }
    if (!answer->starts_with("HTTP/1.1 200") || answer->find(content) == std::string::npos) {
      return std::string(path) + " does not show what it should (" + content +
             "). A program that was built without Node.js has no script for its page";
    }
  }
  return std::nullopt;
}

struct SelfTest {
  const char* name;
  const char* claim;
  Problem (*problem)(const Installation&);
};

constexpr std::array<SelfTest, 6> kTests{{
    {"conformance", "models derive as in the reference program", conformanceProblem},
    {"bits", "ten plants have the same bits as everywhere", bitsProblem},
    {"light", "sky and shade give their exact light", lightProblem},
    {"soil", "water in the ground stays in equilibrium", soilProblem},
    {"server", "a server grows a plant for a client", serverProblem},
    {"page", "a browser gets the server's page", pageProblem},
}};

int selfTest() {
  const Installation installation;
  if (!installation.hasFolder()) {
    printError(
        "no folder for files can be made in the folder of temporary files: set TMPDIR to one that can be written");
    return kFailure;
  }
  const auto began = Clock::now();
  std::size_t failedCount = 0;
  for (const SelfTest& test : kTests) {
    const auto problem = test.problem(installation);
    if (problem) {
      ++failedCount;
      std::printf("failed %s: %s\n", test.name, problem->c_str());
    } else {
      std::printf("passed %s: %s\n", test.name, test.claim);
    }
    std::fflush(stdout);
  }
  std::printf("%zu passed, %zu failed in %.1f s\n", kTests.size() - failedCount, failedCount,
              std::chrono::duration<double>(Clock::now() - began).count());
  if (failedCount > 0) {
    printNote("for a report add the output of: espalier --version --verbose");
  }
  return failedCount == 0 ? kSuccess : kFailure;
}

}  // namespace

void addSelfTest(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("self-test", "Test this installation in half a minute");
  command->footer(
      "Derives models of the conformance suite, compares ten plants bit by bit, and tries light, soil, a server and "
      "its page.\n"
      "Exit status 0 when everything is right. For a report of a fault add the output of `espalier --version "
      "--verbose`.");
  command->callback([&status] { status = selfTest(); });
}

}  // namespace espalier::command
