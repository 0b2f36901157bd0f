#include "environment/process_group.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "engine/core/check.h"
#include "engine/turtle/field.h"
#include "engine/turtle/guarded_call.h"
#include "engine/turtle/query_batches.h"
#include "environment/base/state_bytes.h"

namespace espalier::environment {

namespace {

using turtle::EnvironmentError;

void addDescription(const std::string& name, const turtle::EnvironmentProcess& process,
                    turtle::EnvironmentDescription& all) {
  const turtle::EnvironmentDescription one = process.describe();
  all.name += (all.name.empty() ? "" : ", ") + name;
  all.summary += (all.summary.empty() ? "" : " ") + name + ": " + one.summary;
  all.needs.position |= one.needs.position;
  all.needs.heading |= one.needs.heading;
  all.needs.left |= one.needs.left;
  all.needs.up |= one.needs.up;
  all.needs.width |= one.needs.width;
  all.needs.scale |= one.needs.scale;
  all.needs.parameters |= one.needs.parameters;
  all.needs.following |= one.needs.following;
  all.needs.geometry |= one.needs.geometry;
  for (const auto& variable : one.inputs) {
    all.inputs.push_back({name + "." + variable.name, variable.unit, variable.type});
  }
  for (const auto& variable : one.outputs) {
    all.outputs.push_back({name + "." + variable.name, variable.unit, variable.type});
  }
  all.isStateful |= one.isStateful;
}

}  // namespace

void ProcessGroup::add(std::string name, std::unique_ptr<turtle::EnvironmentProcess> process) {
  ESPALIER_CHECK(process != nullptr);
  const turtle::EnvironmentDescription description = process->describe();
  members_.push_back({std::move(name), std::move(process), description.isStateful, description.needs.geometry});
}

std::string ProcessGroup::names() const {
  std::string names;
  for (const Member& member : members_) {
    names += (names.empty() ? "" : ", ") + member.name;
  }
  return names;
}

turtle::EnvironmentDescription ProcessGroup::describe() const {
  turtle::EnvironmentDescription all;
  for (const Member& member : members_) {
    addDescription(member.name, *member.process, all);
  }
  return all;
}

std::optional<EnvironmentError> ProcessGroup::open(const turtle::EnvironmentContext& context) {
  for (Member& member : members_) {
    if (auto error = member.process->open(context)) {
      return error;
    }
    const turtle::EnvironmentDescription description = member.process->describe();
    member.isStateful = description.isStateful;
    member.needsGeometry = description.needs.geometry;
  }
  return std::nullopt;
}

std::optional<EnvironmentError> ProcessGroup::step(const turtle::QueryBatch& queries,
                                                   const std::vector<std::vector<std::size_t>>& assigned,
                                                   std::size_t firstParameter, turtle::ReplyBatch& replies) {
  auto error = advanceAll([&](std::size_t index) -> std::optional<EnvironmentError> {
    Member& member = members_[index];
    if (assigned[index].empty() && !member.needsGeometry) {
      return member.process->tick(queries.step);
    }
    selectQueries(queries, assigned[index], firstParameter, member.batch);
    member.replies.prepare(member.batch);
    return member.process->step(member.batch, member.replies);
  });
  if (error) {
    return error;
  }
  for (std::size_t index = 0; index < members_.size(); ++index) {
    if (!assigned[index].empty()) {
      mergeReplies(queries, assigned[index], firstParameter, members_[index].batch, members_[index].replies, replies);
    }
  }
  return std::nullopt;
}

std::optional<EnvironmentError> ProcessGroup::tick(std::uint64_t step) {
  return advanceAll([&](std::size_t index) { return members_[index].process->tick(step); });
}

std::string ProcessGroup::save() const {
  StateWriter writer;
  bool isEmpty = true;
  writer.integer(members_.size());
  for (const Member& member : members_) {
    const std::string state = member.process->save();
    isEmpty = isEmpty && state.empty();
    writer.text(member.name);
    writer.text(state);
  }
  return isEmpty ? std::string() : writer.take();
}

std::optional<EnvironmentError> ProcessGroup::restore(std::string_view state) {
  std::vector<std::string_view> states(members_.size());
  if (!state.empty()) {
    StateReader reader(state);
    if (reader.integer() != members_.size()) {
      return otherEnvironment();
    }
    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (reader.text() != members_[i].name) {
        return otherEnvironment();
      }
      states[i] = reader.text();
    }
    if (!reader.isComplete()) {
      return otherEnvironment();
    }
  }
  // all or none: after a failure the members before it go back
  std::vector<std::string> before(members_.size());
  for (std::size_t i = 0; i < members_.size(); ++i) {
    before[i] = members_[i].process->save();
    if (auto error = members_[i].process->restore(states[i])) {
      for (std::size_t k = 0; k < i; ++k) {
        restoreOwn(members_[k], before[k]);
      }
      return error;
    }
  }
  return std::nullopt;
}

EnvironmentError ProcessGroup::otherEnvironment() const {
  return {"The saved state of the environment does not belong to these processes (" + names() +
              "). Use the same environments in the same order as when it was saved.",
          false};
}

void ProcessGroup::restoreOwn(Member& member, const std::string& state) {
  const auto error = member.process->restore(state);
  ESPALIER_CHECK_VALUES(!error, "a process refused its own state: " + (error ? error->message : std::string()));
}

/// Advances all members or none: stateless ones first, then the stateful ones, each but the last saved before.
std::optional<EnvironmentError> ProcessGroup::advanceAll(
    const std::function<std::optional<EnvironmentError>(std::size_t)>& advance) {
  std::vector<std::size_t> order;
  for (const bool isStateful : {false, true}) {
    for (std::size_t index = 0; index < members_.size(); ++index) {
      if (members_[index].isStateful == isStateful) {
        order.push_back(index);
      }
    }
  }
  std::vector<std::pair<std::size_t, std::string>> before;
  for (const std::size_t index : order) {
    auto error = std::optional<EnvironmentError>();
    const auto guarded = [&] { return turtle::guardedCall(members_[index].name, [&] { return advance(index); }); };
    if (members_[index].isStateful && index != order.back()) {
      before.emplace_back(index, members_[index].process->save());
      error = guarded();
      if (error) {
        before.pop_back();  // a process that fails keeps its state
      }
    } else {
      error = guarded();
    }
    if (error) {
      for (const auto& [done, state] : before) {
        restoreOwn(members_[done], state);
      }
      return error;
    }
  }
  return std::nullopt;
}

std::vector<turtle::Field> ProcessGroup::fields() const {
  std::vector<turtle::Field> all;
  for (const Member& member : members_) {
    for (turtle::Field& field : member.process->fields()) {
      field.name = member.name + "." + field.name;
      all.push_back(std::move(field));
    }
  }
  return all;
}

}  // namespace espalier::environment
