#include "clients/espalier/sweep/swept_environment.h"

#include <exception>
#include <nlohmann/json.hpp>

#include "engine/turtle/field.h"
#include "environment/environment_entries.h"
#include "environment/environment_set.h"
#include "environment/registry.h"
#include "server/remote/terrain/terrain_embedding.h"

namespace espalier::command {
namespace {

using nlohmann::json;

/// Passes every call to a process that outlives it.
class LentEnvironment final : public turtle::EnvironmentProcess {
 public:
  explicit LentEnvironment(turtle::EnvironmentProcess& process) : process_(process) {}
  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_.describe(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    return process_.open(context);
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    return process_.step(queries, replies);
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    return process_.tick(step);
  }
  [[nodiscard]] std::string save() const override { return process_.save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return process_.restore(state);
  }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_.fields(); }

 private:
  turtle::EnvironmentProcess& process_;
};

std::string sentencesOf(const std::vector<core::Diagnostic>& errors) {
  std::string text;
  for (const core::Diagnostic& error : errors) {
    text += (text.empty() ? "" : ". ") + error.message + (error.hint.empty() ? "" : ". " + error.hint);
  }
  return text;
}

Result<std::unique_ptr<turtle::EnvironmentProcess>> makeConfigured(const std::string& configuration) {
  const auto entries = environment::parseEnvironmentEntries(configuration);
  if (!entries) {
    return problem(sentencesOf(entries.error()));
  }
  std::vector<std::pair<std::string, std::unique_ptr<turtle::EnvironmentProcess>>> processes;
  for (const environment::EnvironmentEntry& entry : *entries) {
    auto made = environment::makeProcess(entry.type, entry.configuration);
    if (!made) {
      return problem(sentencesOf(made.error()));
    }
    processes.emplace_back(entries->size() == 1 ? std::string() : entry.name, std::move(*made));
  }
  if (processes.empty()) {
    return std::unique_ptr<turtle::EnvironmentProcess>();
  }
  return environment::makeEnvironmentSet(std::move(processes));
}

// the configuration with other values; whole numbers stay whole numbers
std::string changed(const std::string& configuration, std::span<const std::pair<std::string, double>> settings) {
  if (settings.empty()) {
    return configuration;
  }
  json root = json::parse(configuration);
  for (const auto& [pointer, value] : settings) {
    json& place = root[json::json_pointer(pointer)];
    constexpr double kMostWhole = 9.0e15;
    if (value == static_cast<double>(static_cast<std::int64_t>(value)) && value < kMostWhole && value > -kMostWhole) {
      place = static_cast<std::int64_t>(value);
    } else {
      place = value;
    }
  }
  return root.dump();
}

}  // namespace

Result<std::string> readConfiguration(const std::string& text, const std::string& file, core::FileProvider& files) {
  auto entries = environment::parseEnvironmentEntries(text);
  if (!entries) {
    return problem(file + ": " + sentencesOf(entries.error()));
  }
  json list = json::array();
  for (environment::EnvironmentEntry& entry : *entries) {
    if (environment::findProcess(entry.type) == nullptr &&
        (entry.type == "tcp" || entry.type == "stdio" || entry.type == "plugin")) {
      return std::string();
    }
    auto mistake = server::embedAllFiles(entry, file, files);
    if (mistake) {
      return problem(file + ": " + mistake->message + (mistake->hint.empty() ? "" : ": " + mistake->hint));
    }
    json item = json::parse(entry.configuration);
    item["type"] = entry.type;
    if (entry.name != entry.type) {
      item["name"] = entry.name;
    }
    list.push_back(std::move(item));
  }
  return json::parse(text).is_array() ? list.dump() : list.front().dump();
}

std::optional<std::string> SweptEnvironment::check(const std::vector<SweepParameter>& parameters) {
  std::vector<std::pair<std::string, double>> none;
  for (const SweepParameter& parameter : parameters) {
    if (parameter.kind != SweepParameter::Kind::Environment) {
      continue;
    }
    const std::string place = "parameters." + parameter.name + ": ";
    if (configuration_.empty()) {
      return place +
             (maker_
                  ? "the environment of the model is a file or a program without JSON, whose numbers no plan can change"
                  : "the model has no environment") +
             ": give 'environment' in the plan, as {\"type\":\"honda\",\"radius\":0.9}";
    }
    try {
      const json::json_pointer pointer(parameter.target);
      const json root = json::parse(configuration_);
      const json& entries = root;
      if (!entries.contains(pointer.parent_pointer()) ||
          (entries.contains(pointer) && !entries.at(pointer).is_number())) {
        return place + "there is no number at '" + parameter.target + "' of the environment " + configuration_;
      }
    } catch (const std::exception&) {
      return place + "'" + parameter.target +
             "' is no JSON pointer: give one as /0/radius, or /radius of a single environment";
    }
  }
  const auto made = prepare(none);
  return made ? std::nullopt : std::optional(made.error());
}

Result<bool> SweptEnvironment::prepare(std::span<const std::pair<std::string, double>> settings) {
  if (configuration_.empty()) {
    if (!maker_ || process_) {
      return false;
    }
    process_ = maker_();
    return process_ ? Result<bool>(true) : problem("the environment cannot be made");
  }
  if (made_ && settings.empty()) {
    return false;
  }
  std::string wanted;
  try {
    wanted = changed(configuration_, settings);
  } catch (const std::exception&) {
    return problem("the environment has no place for a parameter of the plan: correct its JSON pointer");
  }
  if (made_ == wanted) {
    return false;
  }
  auto made = makeConfigured(wanted);
  if (!made) {
    return problem(made.error());
  }
  process_ = std::move(*made);
  made_ = std::move(wanted);
  return true;
}

std::unique_ptr<turtle::EnvironmentProcess> SweptEnvironment::lend() {
  return process_ ? std::make_unique<LentEnvironment>(*process_) : nullptr;
}

}  // namespace espalier::command
