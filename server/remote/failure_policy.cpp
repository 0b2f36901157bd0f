#include "server/remote/failure_policy.h"

#include <charconv>

#include "engine/turtle/field.h"

namespace espalier::server {
namespace {

turtle::EnvironmentNeeds unionOf(turtle::EnvironmentNeeds a, const turtle::EnvironmentNeeds& b) {
  a.position = a.position || b.position;
  a.heading = a.heading || b.heading;
  a.left = a.left || b.left;
  a.up = a.up || b.up;
  a.width = a.width || b.width;
  a.scale = a.scale || b.scale;
  a.parameters = a.parameters || b.parameters;
  a.following = a.following || b.following;
  a.geometry = a.geometry || b.geometry;
  return a;
}

class PolicyProcess final : public turtle::EnvironmentProcess {
 public:
  PolicyProcess(std::unique_ptr<turtle::EnvironmentProcess> process,
                std::unique_ptr<turtle::EnvironmentProcess> fallback, FailureSink sink)
      : process_(std::move(process)), fallback_(std::move(fallback)), sink_(std::move(sink)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description = process_->describe();
    if (fallback_ != nullptr) {
      const turtle::EnvironmentDescription other = fallback_->describe();
      description.needs = unionOf(description.needs, other.needs);
      description.isStateful = description.isStateful || other.isStateful;
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    if (fallback_ != nullptr) {
      if (auto error = fallback_->open(context)) {
        return error;
      }
    }
    if (const auto error = process_->open(context)) {
      tell(0, *error);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    const auto error = process_->step(queries, replies);
    if (!error) {
      return std::nullopt;
    }
    tell(queries.step, *error);
    replies.prepare(queries);
    return fallback_ != nullptr ? fallback_->step(queries, replies) : std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    const auto error = process_->tick(step);
    if (!error) {
      return std::nullopt;
    }
    tell(step, *error);
    return fallback_ != nullptr ? fallback_->tick(step) : std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }
  // the length of the environment's state, a colon, its state, the fallback's
  [[nodiscard]] std::string save() const override {
    const std::string own = process_->save();
    return std::to_string(own.size()) + ":" + own + (fallback_ != nullptr ? fallback_->save() : std::string());
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    std::size_t size = 0;
    const auto read = std::from_chars(state.data(), state.data() + state.size(), size);
    const auto begin = static_cast<std::size_t>(read.ptr - state.data()) + 1;
    if (read.ec != std::errc() || begin > state.size() || size > state.size() - begin) {
      return turtle::EnvironmentError{"The state of the environment cannot be read. Use a snapshot of this simulation.",
                                      false};
    }
    if (fallback_ != nullptr) {
      if (auto error = fallback_->restore(state.substr(begin + size))) {
        return error;
      }
    }
    if (const auto error = process_->restore(state.substr(begin, size))) {
      tell(0, *error);
    }
    return std::nullopt;
  }

 private:
  void tell(std::uint64_t step, const turtle::EnvironmentError& error) const {
    if (sink_) {
      sink_(step, error.message + (fallback_ != nullptr
                                       ? " The built-in '" + fallback_->describe().name + "' answers in its place."
                                       : " The modules keep what they sent."));
    }
  }

  std::unique_ptr<turtle::EnvironmentProcess> process_;
  std::unique_ptr<turtle::EnvironmentProcess> fallback_;  // null: keep
  FailureSink sink_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> withFailurePolicy(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                              std::unique_ptr<turtle::EnvironmentProcess> fallback,
                                                              FailureSink sink) {
  return std::make_unique<PolicyProcess>(std::move(process), std::move(fallback), std::move(sink));
}

}  // namespace espalier::server
