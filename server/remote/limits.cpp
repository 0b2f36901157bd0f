#include "server/remote/limits.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <type_traits>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::server {
namespace {

template <auto member>
constexpr LimitEntry ofServer(std::string_view name, std::uint64_t minimum, std::string_view meaning) {
  using Value = std::remove_reference_t<decltype(ServerLimits{}.*member)>;
  return {name,
          minimum,
          static_cast<std::uint64_t>(static_cast<Value>(-1)),
          meaning,
          [](const ServerLimits& limits) { return static_cast<std::uint64_t>(limits.*member); },
          [](ServerLimits& limits, std::uint64_t value) { limits.*member = static_cast<Value>(value); }};
}

template <auto member>
constexpr LimitEntry ofSimulation(std::string_view name, std::string_view meaning) {
  using Value = std::remove_reference_t<decltype(core::Limits{}.*member)>;
  return {name,
          1,
          static_cast<std::uint64_t>(static_cast<Value>(-1)),
          meaning,
          [](const ServerLimits& limits) { return static_cast<std::uint64_t>(limits.simulation.*member); },
          [](ServerLimits& limits, std::uint64_t value) { limits.simulation.*member = static_cast<Value>(value); },
          true};
}

// a hello must fit into a line, and its answer into the outbox
constexpr std::uint64_t kSmallestLine = 1'000;
constexpr std::uint64_t kSmallestOutbox = 10'000;
constexpr std::uint64_t kSmallestDecoding = 1'000'000;

using Server = ServerLimits;
using Simulation = core::Limits;

constexpr std::array kEntries{
    ofServer<&Server::lineBytes>("lineBytes", kSmallestLine, "bytes of one line from a peer"),
    ofServer<&Server::helloBytes>("helloBytes", kSmallestLine, "bytes of one line from a peer before hello"),
    ofServer<&Server::decodingBytes>("decodingBytes", kSmallestDecoding,
                                     "bytes of all messages that have come and are not decoded yet"),
    ofServer<&Server::blockBytes>("blockBytes", kSmallestLine, "raw bytes behind one line from a peer"),
    ofServer<&Server::outboxBytes>("outboxBytes", kSmallestOutbox, "bytes that wait for a peer to read them"),
    ofServer<&Server::streamBytes>("streamBytes", 0, "bytes that a simulation keeps to tell its viewers differences"),
    ofServer<&Server::sessions>("sessions", 1, "peers at a time that have said hello"),
    ofServer<&Server::waitingConnections>("waitingConnections", 1, "connections of one side that have not said hello"),
    ofServer<&Server::connectionsPerAddress>("connectionsPerAddress", 0,
                                             "connections of one address of another machine; 0: no bound"),
    ofServer<&Server::simulations>("simulations", 1, "simulations of the server"),
    ofServer<&Server::simulationsPerSession>("simulationsPerSession", 1, "simulations that one connection made"),
    ofServer<&Server::streamsPerSession>("streamsPerSession", 1, "streams of one connection"),
    ofServer<&Server::offersPerSession>("offersPerSession", 1, "environments that one connection offers"),
    ofServer<&Server::requestsPerSession>("requestsPerSession", 1, "requests of one connection in progress"),
    ofServer<&Server::handshakeMilliseconds>("handshakeMilliseconds", 1, "time until a peer has said hello"),
    ofServer<&Server::environmentConnectMilliseconds>("environmentConnectMilliseconds", 1,
                                                      "time until an external environment that is dialled is there"),
    ofServer<&Server::environmentStepMilliseconds>("environmentStepMilliseconds", 1,
                                                   "time of an external environment for one step"),
    ofServer<&Server::heartbeatMilliseconds>("heartbeatMilliseconds", 0,
                                             "silence until a peer is asked whether it is there; 0: never"),
    ofServer<&Server::callSeconds>("callSeconds", 0, "computing time of a call without a completed step; 0: no bound"),
    ofServer<&Server::memoryBytes>(
        "memoryBytes", 0,
        "bytes of strings, environments, frames, decoding, compiling and SQLite of all accounts; 0: "
        "four fifths of the memory that the process may have"),
    ofServer<&Server::accountMemoryBytes>("accountMemoryBytes", 0, "the same of one account; 0: no own bound"),
    ofServer<&Server::accountSimulations>("accountSimulations", 0, "simulations of one account; 0: no own bound"),
    ofServer<&Server::accountStreams>("accountStreams", 0, "streams of one account; 0: no own bound"),
    ofServer<&Server::accountTraceBytes>("accountTraceBytes", 0, "bytes of the traces of one account; 0: no own bound"),
    ofServer<&Server::accountCpuSeconds>("accountCpuSeconds", 0,
                                         "processor time of one account since the server was started; 0: no bound"),
    ofServer<&Server::storeBytes>("storeBytes", 0, "bytes of the data folder's database; 0: no bound"),
    ofServer<&Server::traceBytes>("traceBytes", 0, "bytes of the traces in the data folder; 0: no bound"),
    ofServer<&Server::savedModelBytes>("savedModelBytes", 0,
                                       "bytes of the models in the folder of --models; 0: no bound"),
    ofSimulation<&Simulation::maximumModules>("modules", "modules of the strings of a simulation"),
    ofSimulation<&Simulation::maximumStringBytes>("stringBytes", "bytes of the strings of a simulation"),
    ofSimulation<&Simulation::maximumQueries>("queries", "communication modules of one step"),
    ofSimulation<&Simulation::maximumArity>("arity", "parameters of one module"),
    ofSimulation<&Simulation::maximumLoopIterations>("loopIterations", "turns of loops in one execution of a block"),
    ofSimulation<&Simulation::maximumRecursion>("recursion", "depth of decomposition or homomorphism"),
    ofSimulation<&Simulation::maximumHomomorphismModules>("homomorphismModules",
                                                          "modules that the homomorphism makes of one module"),
    ofSimulation<&Simulation::maximumTurtleStack>("turtleStack", "brackets open at a time"),
    ofSimulation<&Simulation::maximumOpenFiles>("openFiles", "files that a model has open at a time"),
    ofSimulation<&Simulation::maximumFileBytes>("fileBytes", "bytes that a model writes to a file in one step"),
    ofSimulation<&Simulation::maximumSourceBytes>("sourceBytes", "bytes of a model's text after preprocessing"),
    ofSimulation<&Simulation::maximumIncludeDepth>("includeDepth", "files included in one another"),
    ofSimulation<&Simulation::maximumMacroDepth>("macroDepth", "macros replaced in one another"),
    ofSimulation<&Simulation::maximumArrayElements>("arrayElements", "elements of all arrays of a model"),
    ofSimulation<&Simulation::maximumExpressionDepth>("expressionDepth", "nesting of an expression or block"),
};

}  // namespace

std::span<const LimitEntry> limitEntries() {
  return kEntries;
}

const LimitEntry* findLimit(std::string_view name) {
  const auto found =
      std::find_if(kEntries.begin(), kEntries.end(), [name](const LimitEntry& entry) { return entry.name == name; });
  return found == kEntries.end() ? nullptr : &*found;
}

const LimitEntry* limitNamedIn(std::string_view message) {
  constexpr std::string_view kWord = "limit ";
  for (std::size_t at = message.find(kWord); at != std::string_view::npos; at = message.find(kWord, at)) {
    at += kWord.size();
    const std::string_view rest = message.substr(at);
    const auto end = std::find_if(rest.begin(), rest.end(), [](unsigned char c) { return std::isalpha(c) == 0; });
    if (const LimitEntry* entry = findLimit(rest.substr(0, static_cast<std::size_t>(end - rest.begin())))) {
      return entry;
    }
  }
  return nullptr;
}

std::optional<std::string> setLimit(ServerLimits& limits, std::string_view name, std::uint64_t value) {
  const LimitEntry* const entry = findLimit(name);
  if (entry == nullptr) {
    std::vector<std::string_view> names;
    for (const LimitEntry& known : kEntries) {
      names.push_back(known.name);
    }
    return "there is no limit '" + std::string(name) + "'. " + core::suggestName(name, names);
  }
  if (value < entry->minimum || value > entry->maximum) {
    return "the limit " + std::string(name) + " (" + std::string(entry->meaning) + ") must be from " +
           std::to_string(entry->minimum) + " to " + std::to_string(entry->maximum) + ", not " + std::to_string(value) +
           ".";
  }
  entry->set(limits, value);
  return std::nullopt;
}

std::optional<std::string> setLimit(ServerLimits& limits, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string_view digits = equals == std::string_view::npos ? std::string_view() : assignment.substr(equals + 1);
  std::uint64_t value = 0;
  const auto [end, problem] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (problem != std::errc() || end != digits.data() + digits.size()) {
    return "'" + std::string(assignment) +
           "' is not a limit; write NAME=NUMBER with a whole number, for example modules=1000000.";
  }
  return setLimit(limits, assignment.substr(0, equals), value);
}

}  // namespace espalier::server
