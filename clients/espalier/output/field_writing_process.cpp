#include "clients/espalier/output/field_writing_process.h"

#include <string>
#include <utility>
#include <vector>

namespace espalier::command {
namespace {

class FieldWritingProcess final : public turtle::EnvironmentProcess {
 public:
  FieldWritingProcess(std::unique_ptr<turtle::EnvironmentProcess> process, FieldOutputs& outputs, bool isEvery)
      : process_(std::move(process)), outputs_(outputs), isEvery_(isEvery) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_->describe(); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    outputs_.begin(std::nullopt);
    outputs_.setLengthUnit(context.world.lengthUnit);
    auto error = process_->open(context);
    return error ? error : write(0);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    auto error = process_->step(queries, replies);
    return error ? error : write(queries.step + 1);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    auto error = process_->tick(step);
    return error ? error : write(step + 1);
  }

  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return process_->restore(state);
  }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }

 private:
  [[nodiscard]] std::optional<turtle::EnvironmentError> write(std::uint64_t step) {
    if (outputs_.writeStep(process_->fields(), step, isEvery_)) {
      return std::nullopt;
    }
    return turtle::EnvironmentError{"Environment '" + process_->describe().name +
                                        "' could not write its fields of step " + std::to_string(step) +
                                        ": its own messages say why. Start it with another --field.",
                                    false};
  }

  std::unique_ptr<turtle::EnvironmentProcess> process_;
  FieldOutputs& outputs_;
  bool isEvery_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> writingFields(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                          FieldOutputs& outputs, bool isEveryStepWritten) {
  return std::make_unique<FieldWritingProcess>(std::move(process), outputs, isEveryStepWritten);
}

}  // namespace espalier::command
