#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// Processes that share the queries of a step and advance together or not at all.
class ProcessGroup {
 public:
  /// Adds a process under a name that is used in descriptions and saved with its state.
  void add(std::string name, std::unique_ptr<turtle::EnvironmentProcess> process);

  [[nodiscard]] std::size_t size() const { return members_.size(); }
  [[nodiscard]] const std::string& name(std::size_t member) const { return members_[member].name; }
  [[nodiscard]] turtle::EnvironmentProcess& process(std::size_t member) const { return *members_[member].process; }
  /// "soil, light".
  [[nodiscard]] std::string names() const;

  /// The union of the members' needs and variables; variables are named "soil.sum".
  [[nodiscard]] turtle::EnvironmentDescription describe() const;
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context);

  /// Gives each member its assigned queries in one batch, without their parameters before `firstParameter`, and merges
  /// the replies. A member without queries gets a tick unless it needs geometry. If one member fails, all go back to
  /// their state before the step. `assigned` holds indices into `queries` by member (size()). O(queries + parameters)
  /// and a copy of the state of all stateful members but one.
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             const std::vector<std::vector<std::size_t>>& assigned,
                                                             std::size_t firstParameter, turtle::ReplyBatch& replies);
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step);

  /// The states of all members; empty when all are empty.
  [[nodiscard]] std::string save() const;
  /// Restores all members or none.
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state);
  /// The fields of all members, named "soil.waterContent".
  [[nodiscard]] std::vector<turtle::Field> fields() const;

 private:
  struct Member {
    std::string name;
    std::unique_ptr<turtle::EnvironmentProcess> process;
    bool isStateful = false;
    bool needsGeometry = false;
    turtle::QueryBatch batch{};    // its queries of this step
    turtle::ReplyBatch replies{};  // and their answers
  };

  [[nodiscard]] turtle::EnvironmentError otherEnvironment() const;
  static void restoreOwn(Member& member, const std::string& state);
  std::optional<turtle::EnvironmentError> advanceAll(
      const std::function<std::optional<turtle::EnvironmentError>(std::size_t)>& advance);

  std::vector<Member> members_;
};

}  // namespace espalier::environment
