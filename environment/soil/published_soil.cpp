// The process `soil` as the published program: queries take in string order, layers act by twice their angle and end
// below, obstacles count in gradients with their value 0, and a cell of the first slice is its own neighbour from the
// second sweep of a step on. Concentrations are 32-bit floats. y is up. O(n + cells · sweeps).
//
// After every step with diffusion, obstacles and sources change into cells of no kind and back: they give every query
// all it asks for and do not change.

#include "environment/soil/published_soil.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "engine/core/work_meter.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/float_vec.h"
#include "environment/soil/soil_avoidance.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr int kMostSweeps = 1000000;  // of a diffusion until the tolerance is met
constexpr double kVertical = 1e-6;    // sideways part of a heading that counts as none

class PublishedSoil final : public turtle::EnvironmentProcess {
 public:
  PublishedSoil(SoilCells cells, const Configuration& configuration)
      : isObstacle_(std::move(cells.isObstacle)),
        isSource_(std::move(cells.isSource)),
        field_(cells.shape, withoutObstacles(std::move(cells.concentrations), isObstacle_), isObstacle_, {}),
        sweepCount_(static_cast<int>(configuration.integer("diffusionSteps"))),
        tolerance_(toFloat(configuration.number("diffusionTolerance"))),
        relaxation_(toFloat(configuration.number("relaxationFactor"))),
        thicknesses_(configuration.numbers("layerThicknesses")),
        angles_(configuration.numbers("geotropicAngles")),
        least_(toFloat(configuration.numbers("concentrationRange")[0])),
        most_(toFloat(configuration.numbers("concentrationRange")[1])),
        depletes_(configuration.flag("depletion")) {
    angles_.resize(thicknesses_.size(), 0.0);
    isObstacle_.resize(field_.cells().size(), 0);
    isSource_.resize(field_.cells().size(), 0);
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return describeSoil(lengthUnit_, field_.isInSpace());
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    field_.reset();
    areKindsGone_ = false;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<float> next(sweepCount_ != 0 ? field_.cells().size() : 0);
    field_.orGoBack(mostSweeps(), [&] {
      for (std::size_t query = 0; query < queries.size(); ++query) {
        answer(queries, query, replies);
      }
      countAnswers(queries, replies);
      if (queries.size() > 0) {
        diffuse(next);
      }
    });
    return std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override { return {field_.field("concentration", "1")}; }

  [[nodiscard]] std::string save() const override {
    StateWriter writer;
    writer.integer(areKindsGone_ ? 1 : 0);
    writer.text(saveNumbers(field_.cells()));
    return writer.take();
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    StateReader reader(state);
    const bool areKindsGone = reader.integer() != 0;
    const std::string_view numbers = reader.text();
    // a damaged state has no numbers, which restoreNumbers refuses
    auto error = restoreNumbers(reader.isComplete() ? numbers : std::string_view(), "soil", field_.cells());
    areKindsGone_ = error ? areKindsGone_ : areKindsGone;
    return error;
  }

 private:
  static std::vector<double> withoutObstacles(std::vector<double> concentrations,
                                              const std::vector<std::uint8_t>& isObstacle) {
    for (std::size_t cell = 0; cell < concentrations.size(); ++cell) {
      const bool isSolid = cell < isObstacle.size() && isObstacle[cell] != 0;
      concentrations[cell] = isSolid ? 0.0 : toFloat(concentrations[cell]);
    }
    return concentrations;
  }

  /// A cell that is an obstacle or a source at another time.
  [[nodiscard]] bool isOfNoKind(std::size_t cell) const {
    return areKindsGone_ && (isObstacle_[cell] != 0 || isSource_[cell] != 0);
  }
  [[nodiscard]] float valueOf(std::size_t cell) const { return static_cast<float>(field_.cells()[cell]); }

  /// The cell of a point in floats; nothing outside the box, which ends in z too.
  [[nodiscard]] std::optional<std::size_t> cellOf(const Vec3& point) const {
    const SoilField::Shape& shape = field_.shape();
    const FloatVec offset = toFloat(point) - toFloat(shape.position);
    const FloatVec size = toFloat(shape.size);
    const std::array<float, 3> parts{offset.x / size.x, offset.y / size.y, offset.z / size.z};
    std::array<std::size_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float place = parts[axis] * static_cast<float>(shape.cells[axis]);
      if (!(place >= 0.0F && place < static_cast<float>(shape.cells[axis]))) {
        return std::nullopt;
      }
      cell[axis] = static_cast<std::size_t>(place);
    }
    return (cell[2] * shape.cells[1] + cell[1]) * shape.cells[0] + cell[0];
  }

  void answer(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) {
    const auto parameters = queries.parametersOf(query);
    if (parameters.empty()) {
      return;
    }
    const auto cell = cellOf(queries.position[query]);
    replies.set(queries, query, 0, cell ? take(*cell, toFloat(parameters[0])) : 0.0F);
    if (!cell) {
      for (std::size_t k = 4; k < parameters.size(); ++k) {
        replies.set(queries, query, k, 0.0);
      }
      return;
    }
    if (parameters.size() > 2) {
      const Vec3 direction = geotropicDirection(queries.position[query], queries.heading[query]) * parameters[1] +
                             gradientAt(*cell) * parameters[2];
      const std::array<double, 3> components{direction.x, direction.y, direction.z};
      for (std::size_t k = 1; k < std::min<std::size_t>(parameters.size(), 4); ++k) {
        replies.set(queries, query, k, components[k - 1]);
      }
    }
    answerAvoidance(field_, queries, query, replies);
  }

  /// The amount that a query obtains; with depletion it leaves the cell at once.
  float take(std::size_t cell, float wanted) {
    if (isOfNoKind(cell)) {
      return wanted;
    }
    const float concentration = valueOf(cell);
    if (!depletes_) {
      return concentration;
    }
    const float obtained = std::min(wanted, concentration);
    field_.cells()[cell] = concentration - obtained;
    return obtained;
  }

  /// Differences of the neighbours, a missing one replaced by the cell itself, relative to the range.
  [[nodiscard]] Vec3 gradientAt(std::size_t cell) const {
    std::array<double, 3> gradient{};
    std::size_t stride = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t count = field_.shape().cells[axis];
      const std::size_t place = cell / stride % count;
      const float lower = valueOf(place > 0 ? cell - stride : cell);
      const float upper = valueOf(place + 1 < count ? cell + stride : cell);
      gradient[axis] = (upper - lower) / (2.0F * (most_ - least_));
      stride *= count;
    }
    return {gradient[0], gradient[1], gradient[2]};
  }

  /// Down, turned towards the heading by twice the angle of the layer; nothing below all layers.
  [[nodiscard]] Vec3 geotropicDirection(const Vec3& position, const Vec3& heading) const {
    const float depth = toFloat(field_.shape().position.y) + toFloat(field_.shape().size.y) - toFloat(position.y);
    float bottom = 0.0F;
    for (std::size_t layer = 0; layer < thicknesses_.size(); ++layer) {
      bottom += toFloat(thicknesses_[layer]);
      if (bottom > depth) {
        const double angle = 2.0 * angles_[layer] * std::numbers::pi / 180.0;
        const Vec3 sideways{heading.x, 0.0, heading.z};
        const Vec3 side = core::length(sideways) > kVertical ? core::normalised(sideways) : Vec3{-1.0, 0.0, 0.0};
        return angle == 0.0 ? Vec3{0.0, -1.0, 0.0} : Vec3{0.0, -std::cos(angle), 0.0} + side * std::sin(angle);
      }
    }
    return {};
  }

  [[nodiscard]] int mostSweeps() const { return sweepCount_ < 0 ? kMostSweeps : sweepCount_; }

  void diffuse(std::vector<float>& next) {
    for (std::size_t cell = 0; cell < isSource_.size() && !areKindsGone_; ++cell) {
      if (isSource_[cell] != 0) {
        field_.cells()[cell] = most_;
      }
    }
    for (int sweep = 0; sweep < mostSweeps(); ++sweep) {
      if (SoilField::isLong(mostSweeps())) {
        core::pollWork();
      }
      if (!relax(sweep > 0, next) && sweepCount_ < 0) {
        break;
      }
    }
    areKindsGone_ = areKindsGone_ != (sweepCount_ != 0);
  }

  /// One sweep over all cells. False: until the tolerance is met, and no cell would change by more.
  bool relax(bool areFirstCellsTheirOwnNeighbours, std::vector<float>& next) {
    const auto [nx, ny, nz] = field_.shape().cells;
    const std::array<std::size_t, 3> counts{nx, ny, nz};
    bool hasChanged = false;
    for (std::size_t cell = 0; cell < next.size(); ++cell) {
      const float own = valueOf(cell);
      next[cell] = own;
      if (isObstacle_[cell] != 0 || isOfNoKind(cell)) {
        continue;
      }
      float sum = 0.0F;
      float count = 0.0F;
      const auto add = [&](std::size_t neighbour) {
        if (isObstacle_[neighbour] == 0 || areKindsGone_) {
          sum += valueOf(neighbour);
          count += 1.0F;
        }
      };
      std::size_t stride = 1;
      for (const std::size_t size : counts) {
        const std::size_t place = cell / stride % size;
        if (place > 0) {
          add(cell - stride);
        }
        if (place + 1 < size) {
          add(cell + stride);
        }
        stride *= size;
      }
      if (areFirstCellsTheirOwnNeighbours && cell < nx * ny) {
        add(cell);
      }
      if (count == 0.0F) {
        continue;
      }
      const float relaxed = (1.0F - relaxation_) * own + relaxation_ * (sum / count);
      if (sweepCount_ >= 0 || std::abs(relaxed - own) > tolerance_) {
        next[cell] = relaxed;
        hasChanged = true;
      }
    }
    std::copy(next.begin(), next.end(), field_.cells().begin());
    return hasChanged;
  }

  std::vector<std::uint8_t> isObstacle_;  // by cell
  std::vector<std::uint8_t> isSource_;    // by cell
  SoilField field_;                       // concentrations are floats
  int sweepCount_;                        // -1: until the tolerance is met
  float tolerance_;
  float relaxation_;
  std::vector<double> thicknesses_;
  std::vector<double> angles_;  // degrees, as many as thicknesses_
  float least_;
  float most_;
  bool depletes_;
  bool areKindsGone_ = false;  // obstacles and sources are of no kind now
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedSoil(SoilCells cells, const Configuration& configuration) {
  return std::make_unique<PublishedSoil>(std::move(cells), configuration);
}

}  // namespace espalier::environment
