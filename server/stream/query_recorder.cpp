#include "server/stream/query_recorder.h"

#include "engine/turtle/field.h"

namespace espalier::server {
namespace {

class RecordedProcess final : public turtle::EnvironmentProcess {
 public:
  RecordedProcess(std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<QueryRecorder> recorder)
      : process_(std::move(process)), recorder_(std::move(recorder)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_->describe(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    return process_->open(context);
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    auto error = process_->step(queries, replies);
    if (!error) {
      recorder_->keep(queries, replies);
    }
    return error;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    return process_->tick(step);
  }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }
  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return process_->restore(state);
  }

 private:
  std::unique_ptr<turtle::EnvironmentProcess> process_;
  std::shared_ptr<QueryRecorder> recorder_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> QueryRecorder::record(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                                  std::shared_ptr<QueryRecorder> recorder) {
  if (process == nullptr) {
    return nullptr;
  }
  return std::make_unique<RecordedProcess>(std::move(process), std::move(recorder));
}

void QueryRecorder::want(bool isWanted) {
  isWanted_ = isWanted;
  if (!isWanted) {
    last_.reset();
  }
}

void QueryRecorder::keep(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) {
  if (isWanted_) {
    last_ = std::make_shared<const QueryRecord>(QueryRecord{queries, replies});
  }
}

}  // namespace espalier::server
