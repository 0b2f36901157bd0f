#include "environment/multiple.h"

#include <array>
#include <string>
#include <utility>

#include "engine/turtle/field.h"
#include "environment/base/number_text.h"
#include "environment/environment_entries.h"
#include "environment/process_group.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kMultipleSummary =
    "Several environments at once: parameter 1 of a query is the number of its environment.";
constexpr std::array kMultipleKeys{
    ConfigurationKey{
        .name = "fields",
        .kind = KeyKind::Entries,
        .description = "the environments in the order of their numbers, each an object with a 'type' and its keys"},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "leave a query with an unknown number unanswered instead of failing"},
};

class Multiple final : public turtle::EnvironmentProcess {
 public:
  Multiple(ProcessGroup group, bool isCompatible)
      : group_(std::move(group)), isCompatible_(isCompatible), assigned_(group_.size()) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description = group_.describe();
    description.name = "multiple";
    description.summary = std::string(kMultipleSummary);
    description.needs.parameters = true;
    description.inputs.insert(description.inputs.begin(), {"field", "1", ""});
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    return group_.open(context);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    for (auto& chosen : assigned_) {
      chosen.clear();
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      const double number = parameters.empty() ? 0.0 : parameters[0];
      if (number >= 1.0 && number < static_cast<double>(group_.size()) + 1.0) {
        assigned_[static_cast<std::size_t>(number) - 1].push_back(query);
      } else if (!isCompatible_) {
        return unknownNumber(number, queries.module[query]);
      }
    }
    return group_.step(queries, assigned_, 1, replies);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override { return group_.tick(step); }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return group_.fields(); }
  [[nodiscard]] std::string save() const override { return group_.save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return group_.restore(state);
  }

 private:
  [[nodiscard]] turtle::EnvironmentError unknownNumber(double number, std::uint64_t module) const {
    std::string members;
    for (std::size_t i = 0; i < group_.size(); ++i) {
      members += (i == 0 ? "" : ", ") + std::to_string(i + 1) + " " + group_.process(i).describe().name;
    }
    return {"Environment 'multiple' has no environment with the number " + numberText(number) + ", which module " +
                std::to_string(module) + " asks. Available: " + (members.empty() ? "none" : members) +
                ". Parameter 1 of the query must be one of these numbers.",
            false};
  }

  ProcessGroup group_;
  bool isCompatible_;
  std::vector<std::vector<std::size_t>> assigned_;  // queries of this step by environment
};

/// One environment of the configuration, without its place in the messages.
ProcessOrErrors makeMember(const std::string& jsonText) {
  auto parsed = parseEnvironmentEntries(jsonText);
  if (!parsed) {
    return tl::unexpected(std::move(parsed.error()));
  }
  const EnvironmentEntry& entry = parsed->front();
  if (findProcess(entry.type) == &kMultipleProcess) {
    core::Diagnostic error;
    error.message = "an environment of 'multiple' cannot be 'multiple' itself";
    error.hint = "list its environments here";
    return tl::unexpected(std::vector{std::move(error)});
  }
  return makeProcess(entry.type, entry.configuration);
}

ProcessOrErrors makeFromConfiguration(const Configuration& configuration) {
  std::vector<std::unique_ptr<turtle::EnvironmentProcess>> members;
  std::vector<core::Diagnostic> errors;
  const std::vector<std::string>& entries = configuration.entries("fields");
  for (std::size_t index = 0; index < entries.size(); ++index) {
    auto made = makeMember(entries[index]);
    if (made) {
      members.push_back(std::move(*made));
      continue;
    }
    for (core::Diagnostic& error : made.error()) {
      error.message = "environment process 'multiple': fields[" + std::to_string(index) + "]: " + error.message;
      errors.push_back(std::move(error));
    }
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return makeMultiple(std::move(members), configuration.flag("compatible"));
}

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makeMultiple(
    std::vector<std::unique_ptr<turtle::EnvironmentProcess>> members, bool isCompatible) {
  ProcessGroup group;
  for (std::size_t i = 0; i < members.size(); ++i) {
    group.add(std::to_string(i + 1), std::move(members[i]));
  }
  return std::make_unique<Multiple>(std::move(group), isCompatible);
}

constinit const ProcessEntry kMultipleProcess{.name = "multiple",
                                              .summary = kMultipleSummary,
                                              .source = "the published program multiple",
                                              .keys = kMultipleKeys,
                                              .make = makeFromConfiguration};

}  // namespace espalier::environment
