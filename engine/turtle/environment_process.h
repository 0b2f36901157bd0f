#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/core/simulation_error.h"
#include "engine/core/vec3.h"
#include "engine/turtle/world.h"

namespace espalier::turtle {

struct Field;
struct Geometry;

/// Which parts of a query a process reads; the rest need not be filled or sent.
struct EnvironmentNeeds {
  bool position = false;
  bool heading = false;
  bool left = false;
  bool up = false;
  bool width = false;
  bool scale = false;
  bool parameters = false;
  bool following = false;
  bool geometry = false;  // the shape of all plants (geometry.h)

  constexpr bool operator==(const EnvironmentNeeds&) const = default;
};

/// A named value with its unit ("1": dimensionless), as in BMI.
struct EnvironmentVariable {
  std::string name;
  std::string unit;
  std::string type;  // empty: a number
};

struct EnvironmentDescription {
  std::string name;
  std::string summary;  // one sentence
  EnvironmentNeeds needs;
  std::vector<EnvironmentVariable> inputs;   // parameters sent, in order
  std::vector<EnvironmentVariable> outputs;  // parameters set, in order
  bool isStateful = false;                   // has state that a snapshot must hold
};

/// The facts about a simulation that a process receives in open().
struct EnvironmentContext {
  std::string simulation;  // identifier, for messages
  std::uint32_t plantCount = 1;
  std::vector<std::string> symbols;  // names by SymbolId, for QueryBatch::symbol and following
  std::uint64_t seed = 0;
  World world;
};

/// All communication modules of all plants in one step, as a structure of arrays in (plant, module) order. The index of
/// a query is its id. Arrays that the process does not need may be empty.
struct QueryBatch {
  std::uint64_t step = 0;                 // completed steps when the queries were made
  std::uint32_t iteration = 0;            // 0 unless the coupling is iterated
  double timeDays = 0.0;                  // beginOfStep() of the step
  std::vector<std::uint32_t> plant;       // (n)
  std::vector<std::uint64_t> module;      // index of E(x) in its plant's string (n)
  std::vector<core::SymbolId> symbol;     // of the communication module: E, or a declared name (n)
  std::vector<std::uint8_t> isTransient;  // made by a homomorphism: takes part, its reply is discarded (n)
  std::vector<core::Vec3> position, heading, left, up;  // (n) each
  std::vector<double> width;                            // (n)
  std::vector<double> scale;                            // (n)
  std::vector<std::uint64_t> parameterOffset;           // (n + 1), always filled
  std::vector<double> parameters;                       // concatenated
  std::vector<core::SymbolId> following;                // the next module of the string; kNoSymbol: none (n)
  std::vector<char> followingPair;                      // '~' or '@' when `following` is written behind it, else 0 (n)
  std::vector<std::uint64_t> followingOffset;           // (n + 1)
  std::vector<double> followingParameters;
  std::shared_ptr<const Geometry> geometry;  // all plants as they are when they ask; null unless it is needed

  [[nodiscard]] std::size_t size() const { return plant.size(); }
  [[nodiscard]] std::span<const double> parametersOf(std::size_t query) const {
    return {parameters.data() + parameterOffset[query], parameterOffset[query + 1] - parameterOffset[query]};
  }
  [[nodiscard]] std::span<const double> followingParametersOf(std::size_t query) const {
    return {followingParameters.data() + followingOffset[query], followingOffset[query + 1] - followingOffset[query]};
  }
  void clear();
};

/// The answers, laid out as QueryBatch::parameters: value k of query q is at parameterOffset[q] + k.
struct ReplyBatch {
  std::vector<double> values;
  std::vector<std::uint8_t> isSet;  // 0: the module keeps its value
  std::uint64_t answeredCount = 0;  // queries with at least one value set
  std::uint64_t surplusCount = 0;   // values beyond a module's parameters, dropped
  std::vector<std::string> notes;   // sentences for the user; the same one is said once in a simulation

  /// Sizes the batch for the queries with nothing set.
  void prepare(const QueryBatch& queries);
  /// Sets value k of a query; a k beyond its parameters is counted as surplus and dropped.
  void set(const QueryBatch& queries, std::size_t query, std::size_t k, double value) {
    if (queries.parameterOffset[query] + k >= queries.parameterOffset[query + 1]) {
      ++surplusCount;
      return;
    }
    values[queries.parameterOffset[query] + k] = value;
    isSet[queries.parameterOffset[query] + k] = 1;
  }
};

/// Why an environment could not answer.
struct EnvironmentError {
  std::string message;       // whole sentences: the environment, the failure, the remedy
  bool isRetryable = false;  // the same step may succeed later
};

/// A thing that answers queries and has state. Implementations need not be thread-safe: one worker calls at a time.
/// step() sees all queries of all plants against the state left by the step before, then advances the state once.
class EnvironmentProcess {
 public:
  virtual ~EnvironmentProcess() = default;

  [[nodiscard]] virtual EnvironmentDescription describe() const = 0;

  /// Called once before the first step and after every rewind: the process goes to its initial state.
  [[nodiscard]] virtual std::optional<EnvironmentError> open(const EnvironmentContext& context) = 0;

  /// Answers a batch. `replies` is prepared. On an error nothing of `replies` is used and the process's state is as
  /// before. A process that needs geometry is also called in steps without queries, instead of tick().
  [[nodiscard]] virtual std::optional<EnvironmentError> step(const QueryBatch& queries, ReplyBatch& replies) = 0;

  /// Called when a step of simulation time passes without queries (soil diffuses). Default: nothing.
  [[nodiscard]] virtual std::optional<EnvironmentError> tick(std::uint64_t step);

  /// Complete state as bytes; empty for a stateless process.
  [[nodiscard]] virtual std::string save() const;
  [[nodiscard]] virtual std::optional<EnvironmentError> restore(std::string_view state);

  /// Quantities in space as they are after the last step (field.h), for files and pictures. Default: none.
  [[nodiscard]] virtual std::vector<Field> fields() const;
};

}  // namespace espalier::turtle
