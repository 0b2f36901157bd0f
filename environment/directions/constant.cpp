// The process `constant` (docs/environments.md): the same reply to every query.
//
// No state. O(parameters).

#include <algorithm>
#include <array>
#include <utility>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kConstantSummary = "Returns the same configured values to every query.";
constexpr std::array kDefaultValues{1.0};
constexpr std::array kConstantKeys{
    ConfigurationKey{.name = "values",
                     .kind = KeyKind::Numbers,
                     .description = "the reply: value k goes to parameter k of every query",
                     .defaultNumbers = kDefaultValues}};

class Constant final : public turtle::EnvironmentProcess {
 public:
  explicit Constant(std::vector<double> values) : values_(std::move(values)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description{
        .name = "constant", .summary = std::string(kConstantSummary), .needs = {}, .inputs = {}, .outputs = {}};
    for (std::size_t k = 0; k < values_.size(); ++k) {
      description.outputs.push_back({"value" + std::to_string(k + 1), "1", ""});
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      // a query with fewer parameters takes the first ones; that is not a surplus worth a warning
      const std::size_t count =
          std::min(values_.size(), queries.parameterOffset[query + 1] - queries.parameterOffset[query]);
      for (std::size_t k = 0; k < count; ++k) {
        replies.set(queries, query, k, values_[k]);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  std::vector<double> values_;
};

}  // namespace

extern constinit const ProcessEntry kConstantProcess{
    .name = "constant",
    .summary = kConstantSummary,
    .source = "Espalier's own",
    .keys = kConstantKeys,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Constant>(configuration.numbers("values"));
    }};

}  // namespace espalier::environment
