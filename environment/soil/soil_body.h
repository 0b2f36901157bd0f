#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/turtle/environment_process.h"
#include "engine/turtle/field.h"
#include "environment/obstacles/obstacle_scene.h"
#include "environment/soil/ground.h"
#include "environment/soil/richards.h"
#include "environment/soil/soil_water_keys.h"
#include "environment/soil/solutes.h"

namespace espalier::environment {

/// The ground of `soil-water`: its cells, the water and the solutes in them, the weather and the time. The process
/// `soil-water` answers queries from it, and `xylem` lets roots draw from it. It must not move after open().
class SoilBody {
 public:
  /// `configuration` has no errors. Until open() keys() is as in a world of metres.
  SoilBody(ObstacleScene stones, Configuration configuration)
      : stones_(std::move(stones)), given_(std::move(configuration)), keys_(readSoilWater(given_, nullptr)) {}

  /// Goes to the initial state. `process` stands in messages.
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(std::string_view process, const turtle::World& world);
  [[nodiscard]] bool isOpen() const { return water_.has_value(); }

  [[nodiscard]] const SoilWaterKeys& keys() const { return keys_; }
  [[nodiscard]] const Ground& ground() const { return ground_; }
  [[nodiscard]] RichardsSolver& water() { return *water_; }
  [[nodiscard]] const RichardsSolver& water() const { return *water_; }
  /// Those of the configuration, then H⁺ when acidity is on.
  [[nodiscard]] SoluteTransport& solutes() { return *solutes_; }
  [[nodiscard]] const SoluteTransport& solutes() const { return *solutes_; }
  [[nodiscard]] const std::string& lengthUnit() const { return lengthUnit_; }
  /// Days since the beginning.
  [[nodiscard]] double day() const { return day_; }
  /// The cell of a point; nothing outside of the box and in stones.
  [[nodiscard]] std::optional<std::size_t> cellOf(const core::Vec3& point) const;
  [[nodiscard]] double phOf(std::size_t cell) const;

  /// One internal time step of at most `days` under the weather of its beginning, with the sinks of water(). Returns
  /// the days that passed; 0 when none converges. With `uptake`, that replaces the sinks, and θ(h) is met to
  /// `tolerance` or better. The weather's rain and evaporation, in means over hours, take the place of the
  /// configuration's.
  [[nodiscard]] double advance(double days, RichardsSolver::Uptake* uptake = nullptr, double tolerance = 1.0);
  /// Why the weather of the coming days is not known, as in advance(); nothing when it is or is not needed.
  [[nodiscard]] std::optional<turtle::EnvironmentError> problemOfWeather(std::string_view process, double days) const;
  /// Begins a step of the simulation, in which advance() is called.
  void beginStep(double days) { solutes_->beginStep(days); }
  /// Why the last advance() has failed: where, how far it was from a solution, and the remedy, behind the name of the
  /// process. It was not the water but solutes that spread too fast when areSolutesTooFast().
  [[nodiscard]] std::string problemOfFlow() const;
  [[nodiscard]] bool areSolutesTooFast() const { return areSolutesTooFast_; }
  /// Says that time has come to `day`, which it has but for rounding.
  void arriveAt(double day) { day_ = day; }
  /// Internal steps for `days`; an error when one does not converge. The state then is not as before.
  [[nodiscard]] std::optional<turtle::EnvironmentError> passTime(double days);

  [[nodiscard]] std::vector<turtle::Field> fields() const;
  /// The whole state as one list of numbers of a fixed length.
  [[nodiscard]] std::vector<double> numbers() const;
  void setNumbers(const std::vector<double>& all);

 private:
  void fill();
  /// Water in the box and through its borders since the beginning, on a unit of its base; `fields` has others of the
  /// box.
  void addBalance(std::vector<turtle::Field>& fields) const;
  [[nodiscard]] double rainFrom(double day, double& until) const;
  [[nodiscard]] double evaporationFrom(double day, double& until) const;
  [[nodiscard]] double meanOfHour(std::string_view quantity, double day, double& until) const;
  /// The quantities of the weather that advance() reads.
  [[nodiscard]] std::vector<std::string_view> quantitiesOfWeather() const;

  ObstacleScene stones_;
  Configuration given_;
  SoilWaterKeys keys_;
  Ground ground_;
  std::optional<RichardsSolver> water_;
  std::optional<SoluteTransport> solutes_;
  std::vector<double> contentsBefore_;  // of an internal step (cells)
  double day_ = 0.0;
  bool areSolutesTooFast_ = false;  // for the last advance()
  double litres_ = 1000.0;          // in a volume of length unit cubed
  std::string lengthUnit_ = "m";
  turtle::World world_;
  bool hasRain_ = false;        // the weather has rain
  double perMillimetre_ = 0.0;  // lengths in a millimetre, when the weather is read
};

/// The ground of a configuration of `soil-water`, or its errors.
[[nodiscard]] tl::expected<SoilBody, std::vector<core::Diagnostic>> makeSoilBody(const Configuration& configuration);

}  // namespace espalier::environment
