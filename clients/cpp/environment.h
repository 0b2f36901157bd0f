#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/envelope.h"
#include "protocol/messages.h"

namespace espalier::client {

using Vector = std::array<double, 3>;

/// One communication module and the turtle's state there. Only the needs of the environment are filled. It refers to
/// the queries of the step.
struct Query {
  std::uint32_t plant = 0;
  std::string_view symbol;
  std::span<const double> parameters;  // of the module
  Vector position{};                   // lengths in the world's unit
  Vector heading{};
  Vector left{};
  Vector up{};
  double width = 0.0;
  double scale = 1.0;
  std::string_view following;  // symbol of the next module; empty: none
  std::span<const double> followingParameters;
};

/// All queries of one step, in the order of plants and modules.
class Queries {
 public:
  explicit Queries(const protocol::EnvironmentStepParams& params) : params_(params) {}
  [[nodiscard]] std::size_t size() const { return params_.queries.count; }
  [[nodiscard]] Query operator[](std::size_t index) const;
  /// Completed steps when the queries were made, and the age of the plants.
  [[nodiscard]] std::uint64_t step() const { return params_.step; }
  [[nodiscard]] double days() const { return params_.timeDays; }
  /// The same as columns, for many queries.
  [[nodiscard]] const protocol::QueryColumns& columns() const { return params_.queries; }

 private:
  const protocol::EnvironmentStepParams& params_;
};

/// The answers of one step. A query without a reply keeps its parameters.
class Replies {
 public:
  explicit Replies(std::size_t queryCount) : values_(queryCount) {}
  /// Sets the first parameters of the module of a query, in order. Numbers must be finite.
  void set(std::size_t query, std::vector<double> values) { values_[query] = std::move(values); }
  /// A sentence for the user of the simulation, who reads the same one once: at most 50 in a step, of 1,000 bytes each.
  void note(std::string sentence) { notes_.push_back(std::move(sentence)); }
  [[nodiscard]] const std::vector<std::vector<double>>& values() const { return values_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::vector<std::vector<double>> values_;  // by query; empty: no reply
  std::vector<std::string> notes_;
};

/// Base class of environments in C++. Every simulation has an object of its own. An exception fails the step: its text
/// goes to the user of the simulation, which stays at its last completed step.
///
///     struct Ceiling : espalier::client::Environment {
///       void respond(const Queries& queries, Replies& replies) override {
///         for (std::size_t i = 0; i < queries.size(); ++i) {
///           replies.set(i, {queries[i].position[1] < 6 ? 1.0 : 0.0});
///         }
///       }
///     };
///     int main(int count, char** arguments) {
///       EnvironmentDescription ceiling;
///       ceiling.name = "ceiling";
///       ceiling.needs.position = true;
///       return espalier::client::serveEnvironment<Ceiling>(ceiling, count, arguments);
///     }
class Environment {
 public:
  virtual ~Environment() = default;
  /// Called once before the first step: configuration, seed, world, bounds.
  virtual void opened(const protocol::OpenParams& opening) { static_cast<void>(opening); }
  /// Answers all queries of one step. Also called for a step without queries.
  virtual void respond(const Queries& queries, Replies& replies) = 0;
  /// The state as bytes, and back, of an environment that is stateful.
  [[nodiscard]] virtual std::string save() const { return {}; }
  virtual void restore(const std::string& state) { static_cast<void>(state); }
};

/// The description of an environment for servers: name, summary, needs (the parts of a query that it reads), inputs,
/// outputs, isStateful.
using EnvironmentDescription = protocol::DescribeResult;

using EnvironmentFactory = std::function<std::unique_ptr<Environment>()>;

/// Answers the requests of servers to an environment. It knows no connection.
class EnvironmentHost {
 public:
  EnvironmentHost(EnvironmentDescription description, EnvironmentFactory factory)
      : description_(std::move(description)), factory_(std::move(factory)) {}
  /// The result of a request: environment.describe, open, step, save, restore, close; hello and ping.
  [[nodiscard]] protocol::Expected<std::string> answer(const std::string& method, const protocol::Payload& params);

 private:
  struct Opened {
    std::unique_ptr<Environment> environment;
    std::optional<std::pair<std::uint64_t, std::uint32_t>> last;  // step and iteration that `reply` answers
    std::string reply{};
  };
  [[nodiscard]] protocol::Expected<std::string> carryOut(const std::string& method, const protocol::Payload& params);
  [[nodiscard]] protocol::Expected<std::string> step(const protocol::Payload& params);
  [[nodiscard]] protocol::Expected<Opened*> find(const std::string& simulation);

  EnvironmentDescription description_;
  EnvironmentFactory factory_;
  std::map<std::string, Opened> opened_;  // by simulation
};

/// The program of an environment; the result is its exit status. Without arguments it answers on standard input and
/// output, for `--environment 'stdio:./ceiling'`. `--offer HOST:PORT [--token-file FILE]` connects to a server and
/// offers the environment: `{"type": "offered", "name": "ceiling"}`.
[[nodiscard]] int serveEnvironment(EnvironmentDescription description, EnvironmentFactory factory, int count,
                                   const char* const* arguments);

template <typename T>
[[nodiscard]] int serveEnvironment(EnvironmentDescription description, int count, const char* const* arguments) {
  return serveEnvironment(
      std::move(description), [] { return std::make_unique<T>(); }, count, arguments);
}

}  // namespace espalier::client
