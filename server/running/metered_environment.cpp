#include "server/running/metered_environment.h"

#include <utility>

#include "engine/turtle/field.h"
#include "server/running/turn_meter.h"

namespace espalier::server {
namespace {

class MeteredEnvironment final : public turtle::EnvironmentProcess {
 public:
  MeteredEnvironment(std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<EnvironmentBytes> bytes)
      : process_(std::move(process)), bytes_(std::move(bytes)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_->describe(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    return counted([&] { return process_->open(context); });
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    return counted([&] { return process_->step(queries, replies); });
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    return counted([&] { return process_->tick(step); });
  }
  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return counted([&] { return process_->restore(state); });
  }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }

 private:
  template <typename Call>
  [[nodiscard]] std::optional<turtle::EnvironmentError> counted(Call&& call) {
    PartMeter part;
    const Counted last{part, *bytes_};
    const core::WorkMeter::Scope scope(&part);
    return call();
  }

  /// Adds what a call has left, also when it throws.
  struct Counted {
    const PartMeter& part;
    EnvironmentBytes& bytes;
    ~Counted() { bytes += part.net(); }
  };

  std::unique_ptr<turtle::EnvironmentProcess> process_;
  std::shared_ptr<EnvironmentBytes> bytes_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> countMemory(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                        std::shared_ptr<EnvironmentBytes> bytes) {
  if (process == nullptr) {
    return nullptr;
  }
  return std::make_unique<MeteredEnvironment>(std::move(process), std::move(bytes));
}

}  // namespace espalier::server
