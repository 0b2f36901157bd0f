#include "environment/environment_set.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "engine/core/check.h"
#include "environment/letter_case.h"
#include "environment/query_batches.h"
#include "environment/state_bytes.h"

namespace espalier::environment {

namespace {

using turtle::EnvironmentError;

struct Member {
  std::string name;
  std::unique_ptr<turtle::EnvironmentProcess> process;
  bool isStateful = false;
  std::vector<std::size_t> queries{};  // indices into the whole batch of this step
  turtle::QueryBatch batch{};          // those queries
  turtle::ReplyBatch replies{};        // and their answers
};

class EnvironmentSet final : public turtle::EnvironmentProcess {
 public:
  explicit EnvironmentSet(std::vector<Member> members) : members_(std::move(members)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    if (members_.size() == 1) {
      return members_.front().process->describe();
    }
    turtle::EnvironmentDescription all;
    for (const Member& member : members_) {
      addDescription(member, all);
    }
    return all;
  }

  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    symbols_ = context.symbols;
    memberOfSymbol_.assign(symbols_.size(), kNoMember);
    for (std::size_t symbol = 0; symbol < symbols_.size(); ++symbol) {
      memberOfSymbol_[symbol] = memberNamed(symbols_[symbol]);
    }
    for (Member& member : members_) {
      if (auto error = member.process->open(context)) {
        return error;
      }
      member.isStateful = member.process->describe().isStateful;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    if (auto error = assign(queries)) {
      return error;
    }
    // one process answers everything: nothing to split
    if (members_.size() == 1) {
      return members_.front().process->step(queries, replies);
    }
    if (auto error = advanceAll([&](Member& member) { return stepMember(queries, member); })) {
      return error;
    }
    for (Member& member : members_) {
      if (!member.queries.empty()) {
        mergeReplies(queries, member.queries, 0, member.batch, member.replies, replies);
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t step) override {
    return advanceAll([&](Member& member) { return member.process->tick(step); });
  }

  [[nodiscard]] std::string save() const override {
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

  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
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
    // all or none: on a failure the ones before go back
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

 private:
  static constexpr std::size_t kNoMember = static_cast<std::size_t>(-1);

  static void addDescription(const Member& member, turtle::EnvironmentDescription& all) {
    const turtle::EnvironmentDescription one = member.process->describe();
    all.name += (all.name.empty() ? "" : ", ") + member.name;
    all.summary += (all.summary.empty() ? "" : " ") + member.name + ": " + one.summary;
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
      all.inputs.push_back({member.name + "." + variable.name, variable.unit, variable.type});
    }
    for (const auto& variable : one.outputs) {
      all.outputs.push_back({member.name + "." + variable.name, variable.unit, variable.type});
    }
    all.isStateful |= one.isStateful;
  }

  [[nodiscard]] std::size_t memberNamed(std::string_view symbol) const {
    if (symbol == "E") {
      return 0;
    }
    const auto found = std::find_if(members_.begin(), members_.end(),
                                    [&](const Member& member) { return equalIgnoringCase(member.name, symbol); });
    return found == members_.end() ? kNoMember : static_cast<std::size_t>(found - members_.begin());
  }

  /// Finds the process of every query. Without a table of symbols all queries are plain ones.
  std::optional<EnvironmentError> assign(const turtle::QueryBatch& queries) {
    for (Member& member : members_) {
      member.queries.clear();
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      std::size_t target = 0;
      if (!memberOfSymbol_.empty()) {
        const core::SymbolId symbol = queries.symbol[query];
        target = symbol < memberOfSymbol_.size() ? memberOfSymbol_[symbol] : kNoMember;
        if (target == kNoMember) {
          return unknownName(symbol < symbols_.size() ? symbols_[symbol] : "symbol " + std::to_string(symbol));
        }
      }
      members_[target].queries.push_back(query);
    }
    return std::nullopt;
  }

  [[nodiscard]] EnvironmentError unknownName(const std::string& name) const {
    std::string message =
        "No environment process is named '" + name + "', but the model asks ?" + name + "(...). Available: ";
    for (const Member& member : members_) {
      message += (&member == &members_.front() ? "" : ", ") + member.name;
    }
    return {message + ". Give a process this name, or ask ?E(...), which goes to the first one.", false};
  }

  [[nodiscard]] EnvironmentError otherEnvironment() const {
    std::string names;
    for (const Member& member : members_) {
      names += (names.empty() ? "" : ", ") + member.name;
    }
    return {"The saved state of the environment does not belong to these processes (" + names +
                "). Use the same environments in the same order as when it was saved.",
            false};
  }

  static std::optional<EnvironmentError> stepMember(const turtle::QueryBatch& queries, Member& member) {
    if (member.queries.empty()) {
      return member.process->tick(queries.step);
    }
    selectQueries(queries, member.queries, 0, member.batch);
    member.replies.prepare(member.batch);
    return member.process->step(member.batch, member.replies);
  }

  static void restoreOwn(Member& member, const std::string& state) {
    const auto error = member.process->restore(state);
    ESPALIER_CHECK_VALUES(!error, "a process refused its own state: " + (error ? error->message : std::string()));
  }

  /// Advances all members or none: stateless ones first, then the stateful ones, each but the last saved before.
  template <typename Advance>
  std::optional<EnvironmentError> advanceAll(const Advance& advance) {
    std::vector<Member*> order;
    for (Member& member : members_) {
      order.push_back(&member);
    }
    const auto firstStateful =
        std::stable_partition(order.begin(), order.end(), [](const Member* member) { return !member->isStateful; });
    std::vector<std::string> before;
    for (auto member = order.begin(); member != order.end(); ++member) {
      if (member >= firstStateful && member + 1 != order.end()) {
        before.push_back((*member)->process->save());
      }
      if (auto error = advance(**member)) {
        for (auto done = firstStateful; done < member; ++done) {
          restoreOwn(**done, before[static_cast<std::size_t>(done - firstStateful)]);
        }
        return error;
      }
    }
    return std::nullopt;
  }

  std::vector<Member> members_;
  std::vector<std::string> symbols_;         // names by SymbolId
  std::vector<std::size_t> memberOfSymbol_;  // by SymbolId; kNoMember: no process has this name
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makeEnvironmentSet(
    std::vector<std::pair<std::string, std::unique_ptr<turtle::EnvironmentProcess>>> processes) {
  ESPALIER_CHECK(!processes.empty());
  if (processes.size() == 1 && processes.front().first.empty()) {
    return std::move(processes.front().second);
  }
  std::vector<Member> members;
  for (auto& [name, process] : processes) {
    ESPALIER_CHECK(process != nullptr);
    const bool isStateful = process->describe().isStateful;
    members.push_back({std::move(name), std::move(process), isStateful});
  }
  return std::make_unique<EnvironmentSet>(std::move(members));
}

}  // namespace espalier::environment
