#include "environment/multiple.h"

#include <array>
#include <string>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/turtle/field.h"
#include "environment/environment_entries.h"
#include "environment/process_group.h"
#include "environment/registry.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kSummary = "Several fields at once: parameter 1 of a query is the number of its field.";
constexpr std::array kKeys{
    ConfigurationKey{
        .name = "fields",
        .kind = KeyKind::Entries,
        .description = "the fields in the order of their numbers, each an object with a 'type' and its keys"},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "leave a query for a field that does not exist unanswered instead of failing"},
};

class Multiple final : public turtle::EnvironmentProcess {
 public:
  Multiple(ProcessGroup group, bool isCompatible)
      : group_(std::move(group)), isCompatible_(isCompatible), assigned_(group_.size()) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description = group_.describe();
    description.name = "multiple";
    description.summary = std::string(kSummary);
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
        return unknownField(number, queries.module[query]);
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
  [[nodiscard]] turtle::EnvironmentError unknownField(double number, std::uint64_t module) const {
    std::string fields;
    for (std::size_t i = 0; i < group_.size(); ++i) {
      fields += (i == 0 ? "" : ", ") + std::to_string(i + 1) + " " + group_.process(i).describe().name;
    }
    std::string text;
    core::appendNumber(text, number, core::NumberStyle::Shortest);
    return {"Environment 'multiple' has no field " + text + ", which module " + std::to_string(module) +
                " asks. Fields: " + (fields.empty() ? "none" : fields) +
                ". Parameter 1 of the query must be one of these numbers.",
            false};
  }

  ProcessGroup group_;
  bool isCompatible_;
  std::vector<std::vector<std::size_t>> assigned_;  // queries of this step by field
};

core::Diagnostic fieldError(std::size_t index, core::Diagnostic error) {
  error.message = "environment process 'multiple': fields[" + std::to_string(index) + "]: " + error.message;
  return error;
}

/// One field of the configuration.
ProcessOrErrors makeField(std::size_t index, const std::string& json) {
  auto parsed = parseEnvironmentEntries(json);
  auto* errors = std::get_if<std::vector<core::Diagnostic>>(&parsed);
  ProcessOrErrors made;
  if (errors == nullptr) {
    const EnvironmentEntry& entry = std::get<std::vector<EnvironmentEntry>>(parsed).front();
    if (findProcess(entry.type) == &kMultipleProcess) {
      core::Diagnostic error;
      error.message = "a field cannot be 'multiple' itself";
      error.hint = "list its fields here";
      return std::vector<core::Diagnostic>{fieldError(index, std::move(error))};
    }
    made = makeProcess(entry.type, entry.configuration);
    errors = std::get_if<std::vector<core::Diagnostic>>(&made);
  }
  if (errors != nullptr) {
    for (core::Diagnostic& error : *errors) {
      error = fieldError(index, std::move(error));
    }
    return std::move(*errors);
  }
  return made;
}

ProcessOrErrors makeFromConfiguration(const Configuration& configuration) {
  std::vector<std::unique_ptr<turtle::EnvironmentProcess>> fields;
  std::vector<core::Diagnostic> errors;
  const std::vector<std::string>& entries = configuration.entries("fields");
  for (std::size_t index = 0; index < entries.size(); ++index) {
    auto made = makeField(index, entries[index]);
    if (auto* wrong = std::get_if<std::vector<core::Diagnostic>>(&made)) {
      errors.insert(errors.end(), wrong->begin(), wrong->end());
    } else {
      fields.push_back(std::get<std::unique_ptr<turtle::EnvironmentProcess>>(std::move(made)));
    }
  }
  if (!errors.empty()) {
    return errors;
  }
  return makeMultiple(std::move(fields), configuration.flag("compatible"));
}

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makeMultiple(
    std::vector<std::unique_ptr<turtle::EnvironmentProcess>> fields, bool isCompatible) {
  ProcessGroup group;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    group.add(std::to_string(i + 1), std::move(fields[i]));
  }
  return std::make_unique<Multiple>(std::move(group), isCompatible);
}

constinit const ProcessEntry kMultipleProcess{.name = "multiple",
                                              .summary = kSummary,
                                              .source = "the published program multiple",
                                              .aliases = {},
                                              .keys = kKeys,
                                              .fieldKeywords = {},
                                              .make = makeFromConfiguration};

}  // namespace espalier::environment
