#include "engine/simulation/view_drawing.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/state/string_text.h"
#include "engine/simulation/model_set.h"
#include "engine/simulation/plants/derivation_factory.h"
#include "engine/simulation/plants/plant_drawing.h"
#include "engine/simulation/plants/plant_messages.h"
#include "engine/simulation/plants/plant_variables.h"

namespace espalier::simulation {
class ViewDrawing::Implementation {
 public:
  void show(std::shared_ptr<const PlantsView> view);
  void close() {
    view_ = nullptr;
    states_.clear();
  }
  [[nodiscard]] std::optional<core::SimulationError> draw(turtle::InterpretationOutput output);
  [[nodiscard]] tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> recordChain();
  void forgetChain() {
    chain_ = nullptr;
    changes_.clear();
  }
  [[nodiscard]] const PlantsView& view() const {
    ESPALIER_CHECK(view_ != nullptr);
    return *view_;
  }
  [[nodiscard]] const ModelSet& models() const { return studio_->models; }

 private:
  /// The tools that draw views of the same Programs and options.
  struct Studio {
    explicit Studio(const PlantsView& view)
        : models(view.programs), options(silent(*view.options)), factory(models, options, isCancelled, messages) {}

    /// Another thread owns the simulation, so drawing a view tells its caller nothing.
    static SimulationOptions silent(SimulationOptions options) {
      options.messages = nullptr;
      options.fileWriter = nullptr;
      return options;
    }

    const ModelSet models;
    const SimulationOptions options;
    const std::atomic<bool> isCancelled{false};
    PlantMessages messages{nullptr};
    const DerivationFactory factory;
    PlantDrawing drawing{models, options, factory};
  };

  void joinChanges();

  std::shared_ptr<const PlantsView> view_;                  // null: none is shown
  std::vector<derivation::PlantState> states_;              // of the view; drawing works on them
  std::shared_ptr<const SimulationOptions> studioOptions_;  // that the studio was made with
  std::unique_ptr<Studio> studio_;
  std::uint64_t shown_ = 0;                           // the number of the last view
  std::uint64_t generation_ = 0;                      // of the last chain that was made
  std::shared_ptr<const turtle::RecordChain> chain_;  // null: none, or another run
  std::vector<derivation::StepChanges> changes_;      // by plant: from the chain's strings to the view's
};

void ViewDrawing::Implementation::show(std::shared_ptr<const PlantsView> view) {
  view_ = std::move(view);
  if (studio_ == nullptr || studioOptions_ != view_->options || studio_->models.programs() != view_->programs) {
    studio_ = std::make_unique<Studio>(*view_);
    studioOptions_ = view_->options;
  }
  states_.clear();
  states_.reserve(view_->plants.size());
  for (const derivation::PlantState& plant : view_->plants) {
    states_.push_back(sharedState(plant));
  }
  joinChanges();
  shown_ = view_->number;
}

void ViewDrawing::Implementation::joinChanges() {
  if (chain_ == nullptr) {
    return;
  }
  if (view_->base == 0 || view_->base != shown_) {
    forgetChain();
    return;
  }
  changes_.resize(view_->plants.size());
  for (std::size_t plant = 0; plant < view_->changes.size(); ++plant) {
    changes_[plant] = changes_[plant].then(view_->changes[plant]);
  }
}

std::optional<core::SimulationError> ViewDrawing::Implementation::draw(turtle::InterpretationOutput output) {
  try {
    studio_->drawing.draw(*view().members, states_, std::move(output));
    return std::nullopt;
  } catch (const core::SimulationFailure& failure) {
    return sayingWhereItStays(failure.error(), view().completedSteps);
  }
}

tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError>
ViewDrawing::Implementation::recordChain() {
  const Programs& programs = view().programs;
  if (!std::all_of(programs.begin(), programs.end(), [](const auto& it) { return turtle::isRepeatable(*it); })) {
    return nullptr;
  }
  auto chain = std::make_shared<turtle::RecordChain>();
  chain->generation = ++generation_;
  try {
    studio_->drawing.chainRecords(*view().members, states_, chain_.get(), changes_, *chain);
  } catch (const core::SimulationFailure& failure) {
    return tl::unexpected(sayingWhereItStays(failure.error(), view().completedSteps));
  }
  chain_ = std::move(chain);
  changes_.clear();
  for (const derivation::PlantState& plant : view().plants) {
    changes_.push_back(derivation::StepChanges::nothing(plant.string.size()));
  }
  return chain_;
}

ViewDrawing::ViewDrawing() : implementation_(std::make_unique<Implementation>()) {}
ViewDrawing::~ViewDrawing() = default;

void ViewDrawing::show(std::shared_ptr<const PlantsView> view) {
  implementation_->show(std::move(view));
}
const PlantsView& ViewDrawing::view() const {
  return implementation_->view();
}
void ViewDrawing::close() {
  implementation_->close();
}
const std::vector<std::string>& ViewDrawing::symbolNames() const {
  return implementation_->models().symbolNames();
}
const files::ViewSettings& ViewDrawing::settings() const {
  return implementation_->models().view();
}
std::string ViewDrawing::stringText(std::size_t plant) const {
  const language::Program& program = view().program(plant);
  return derivation::toText(program, view().plants[plant].string, derivation::numberStyle(program.compatibility));
}
tl::expected<turtle::Scene, core::SimulationError> ViewDrawing::scene() {
  turtle::Scene scene;
  if (auto error = implementation_->draw({.scene = &scene})) {
    return tl::unexpected(std::move(*error));
  }
  return scene;
}
tl::expected<std::vector<turtle::TurtleRecord>, core::SimulationError> ViewDrawing::turtleRecords() {
  std::vector<turtle::TurtleRecord> records;
  if (auto error = implementation_->draw({.records = &records})) {
    return tl::unexpected(std::move(*error));
  }
  return records;
}
std::optional<core::SimulationError> ViewDrawing::visitModules(
    const std::function<void(const turtle::TurtleRecord&, std::uint64_t first)>& visit) {
  return implementation_->draw({.onModule = visit});
}
tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> ViewDrawing::recordChain() {
  return implementation_->recordChain();
}
void ViewDrawing::forgetChain() {
  implementation_->forgetChain();
}

}  // namespace espalier::simulation
