#include "environment/environment_set.h"

#include <cstdint>
#include <optional>

#include "engine/core/check.h"
#include "engine/turtle/field.h"
#include "environment/base/letter_case.h"
#include "environment/process_group.h"

namespace espalier::environment {

namespace {

using turtle::EnvironmentError;

class EnvironmentSet final : public turtle::EnvironmentProcess {
 public:
  explicit EnvironmentSet(ProcessGroup group) : group_(std::move(group)), assigned_(group_.size()) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return group_.size() == 1 ? group_.process(0).describe() : group_.describe();
  }

  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    symbols_ = context.symbols;
    memberOfSymbol_.assign(symbols_.size(), kNoMember);
    for (std::size_t symbol = 0; symbol < symbols_.size(); ++symbol) {
      memberOfSymbol_[symbol] = memberNamed(symbols_[symbol]);
    }
    return group_.open(context);
  }

  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    if (auto error = assign(queries)) {
      return error;
    }
    // a single process answers all queries
    return group_.size() == 1 ? group_.process(0).step(queries, replies) : group_.step(queries, assigned_, 0, replies);
  }

  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t step) override { return group_.tick(step); }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return group_.fields(); }
  [[nodiscard]] std::string save() const override { return group_.save(); }
  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
    return group_.restore(state);
  }

 private:
  static constexpr std::size_t kNoMember = static_cast<std::size_t>(-1);

  [[nodiscard]] std::size_t memberNamed(std::string_view symbol) const {
    if (symbol == "E") {
      return 0;
    }
    for (std::size_t member = 0; member < group_.size(); ++member) {
      if (equalIgnoringCase(group_.name(member), symbol)) {
        return member;
      }
    }
    return kNoMember;
  }

  /// Finds the process of every query. Without a table of symbols all queries are plain ones.
  std::optional<EnvironmentError> assign(const turtle::QueryBatch& queries) {
    for (auto& chosen : assigned_) {
      chosen.clear();
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
      assigned_[target].push_back(query);
    }
    return std::nullopt;
  }

  [[nodiscard]] EnvironmentError unknownName(const std::string& name) const {
    return {"No environment process is named '" + name + "', but the model asks ?" + name + "(...). Available: " +
                group_.names() + ". Give a process this name, or ask ?E(...), which goes to the first one.",
            false};
  }

  ProcessGroup group_;
  std::vector<std::vector<std::size_t>> assigned_;  // queries of this step by member
  std::vector<std::string> symbols_;                // names by SymbolId
  std::vector<std::size_t> memberOfSymbol_;         // by SymbolId; kNoMember: unknown name
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makeEnvironmentSet(
    std::vector<std::pair<std::string, std::unique_ptr<turtle::EnvironmentProcess>>> processes) {
  ESPALIER_CHECK(!processes.empty());
  if (processes.size() == 1 && processes.front().first.empty()) {
    return std::move(processes.front().second);
  }
  ProcessGroup group;
  for (auto& [name, process] : processes) {
    group.add(std::move(name), std::move(process));
  }
  return std::make_unique<EnvironmentSet>(std::move(group));
}

}  // namespace espalier::environment
