#include "environment/tick_rule.h"

#include <utility>

#include "engine/turtle/field.h"

namespace espalier::environment {

namespace {

using turtle::EnvironmentError;

class TickingWithQueries final : public turtle::EnvironmentProcess {
 public:
  explicit TickingWithQueries(std::unique_ptr<turtle::EnvironmentProcess> process) : process_(std::move(process)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_->describe(); }
  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    return process_->open(context);
  }
  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    return queries.size() == 0 ? std::nullopt : process_->step(queries, replies);
  }
  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t /*step*/) override { return std::nullopt; }
  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
    return process_->restore(state);
  }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }

 private:
  std::unique_ptr<turtle::EnvironmentProcess> process_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> tickingWithQueries(std::unique_ptr<turtle::EnvironmentProcess> process) {
  return std::make_unique<TickingWithQueries>(std::move(process));
}

}  // namespace espalier::environment
