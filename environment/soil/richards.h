#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "environment/soil/flow_system.h"
#include "environment/soil/flux_potential.h"
#include "environment/soil/soil_layer.h"

namespace espalier::environment {

/// The conditions at the top and at the bottom of the ground for a time. Lengths per day, inwards positive.
struct SoilBorders {
  bool hasTopHead = false;
  double topHead = 0.0;        // at the surface, length
  double rain = 0.0;           // offered; water that the soil cannot take runs off
  double evaporation = 0.0;    // demanded; water that the soil cannot give stays
  double driestHead = -150.0;  // at the surface when it is dry, length
  enum class Bottom : std::uint8_t { Closed, Free, Head };
  Bottom bottom = Bottom::Free;  // Free: drainage by gravity alone
  double bottomHead = 0.0;       // at the lower border, length
};

/// Water in unsaturated soil: Richards' equation ∂θ/∂t = ∇·(K(h) ∇(h + z)) − sink in its mixed form, which conserves
/// water (Celia, Bouloutas & Zarba, Water Resources Research 26, 1990), in a box of cells, each with a soil of its own
/// or impermeable. Finite volumes. The conductivity of a face is the mean of K between the heads of both sides, from
/// the matric flux potential. Implicit in time, solved by Newton's method.
///
/// A time step ends when θ(h) is met to a tolerance. Water contents are then set to the result of the fluxes, and the
/// next step starts from these, so the balance is exact to rounding. The length of a time step follows its error: half
/// the step times the change of dθ/dt since the last one (Thomas & Gladwell 1988; Kavetski et al. 2001).
class RichardsSolver {
 public:
  struct Shape {
    std::array<std::size_t, 2> columns{1, 1};  // along the two horizontal directions
    std::size_t layers = 1;                    // of cells, the first one is the lowest
    std::array<double, 2> cellSize{1, 1};      // horizontal, length
    std::vector<double> heights{1};            // of the layers, length
  };
  /// Amounts of water since the beginning, length³.
  struct Balance {
    double infiltrated = 0.0;  // through the surface; negative: evaporated
    double drained = 0.0;      // through the bottom
    double runOff = 0.0;       // rain that did not get in

    bool operator==(const Balance&) const = default;
  };
  /// Everything that changes, cell by cell: the index is (layer * columns[0] + i) * columns[1] + k.
  struct State {
    std::vector<double> heads;     // length
    std::vector<double> contents;  // volume of water per volume of soil, 0 in impermeable cells
    std::vector<double> rates;     // dθ/dt of the last time step, 1/day
    double timeStep = 1e-4;        // tried next, days
    Balance balance;
  };

  /// How exactly a time step is solved, as volume of water per volume of soil.
  struct Tolerance {
    double iteration = 1e-6;  // of each cell's content against the content that belongs to its head
    double time = 1e-3;       // error of one time step
  };

  /// `soilOf` is the number of each cell's soil in `soils`, −1: impermeable.
  RichardsSolver(const Shape& shape, std::vector<SoilLayer> soils, std::vector<int> soilOf);

  [[nodiscard]] const Shape& shape() const { return shape_; }
  /// Difference of the indices of a cell and the next one along an axis.
  [[nodiscard]] std::size_t stride(std::size_t axis) const {
    return axis == 0 ? shape_.columns[1] : axis == 1 ? 1 : shape_.columns[0] * shape_.columns[1];
  }
  [[nodiscard]] std::size_t cellCount() const { return soilOf_.size(); }
  /// Size of a cell along an axis (0, 1: horizontal; 2: vertical).
  [[nodiscard]] double sizeOf(std::size_t cell, std::size_t axis) const {
    return axis == 2 ? shape_.heights[cell / stride(2)] : shape_.cellSize[axis];
  }
  /// Distance of the middles of a cell and the next one along an axis.
  [[nodiscard]] double distanceToNext(std::size_t cell, std::size_t axis) const {
    return axis == 2 ? 0.5 * (sizeOf(cell, 2) + sizeOf(cell + stride(2), 2)) : shape_.cellSize[axis];
  }
  /// Area of the face between a cell and the next one along an axis.
  [[nodiscard]] double faceArea(std::size_t cell, std::size_t axis) const {
    return axis == 2 ? shape_.cellSize[0] * shape_.cellSize[1] : shape_.cellSize[1 - axis] * sizeOf(cell, 2);
  }
  [[nodiscard]] double cellVolume(std::size_t cell) const { return faceArea(cell, 2) * sizeOf(cell, 2); }
  [[nodiscard]] bool isSoil(std::size_t cell) const { return soilOf_[cell] >= 0; }
  [[nodiscard]] const SoilLayer& soilOf(std::size_t cell) const {
    return soils_[static_cast<std::size_t>(soilOf_[cell])];
  }
  [[nodiscard]] const FluxPotential& potentialOf(std::size_t cell) const {
    return potentials_[static_cast<std::size_t>(soilOf_[cell])];
  }
  [[nodiscard]] State& state() { return state_; }
  [[nodiscard]] const State& state() const { return state_; }
  /// Whether the upper side of a cell is the surface of the ground.
  [[nodiscard]] bool isSurface(std::size_t cell) const { return isSurface_[cell] != 0; }
  /// Whether water can flow from a cell to the next one along an axis (2: upwards).
  [[nodiscard]] bool hasFace(std::size_t cell, std::size_t axis) const { return hasFace_[axis][cell] != 0; }
  /// Water content of a cell; 0 in impermeable ones.
  [[nodiscard]] double contentOf(std::size_t cell) const { return state_.contents[cell]; }
  /// Sets the head of a cell and the water content that belongs to it.
  void setHead(std::size_t cell, double head);
  /// Water that leaves each cell during advance(), length³ per day; negative where water is added (cells).
  [[nodiscard]] std::vector<double>& sinks() { return sinks_; }
  /// All water in the box, length³.
  [[nodiscard]] double storedWater() const;

  /// Water that something takes from the cells as their heads allow: it replaces the sinks.
  class Uptake {
   public:
    Uptake() = default;
    Uptake(const Uptake&) = delete;
    Uptake& operator=(const Uptake&) = delete;
    virtual ~Uptake() = default;
    /// Sets what leaves each cell in a step of so many days that ends with these heads, length³ per day, and how it
    /// grows with the head of the cell alone, length² per day. False: there is no such uptake.
    [[nodiscard]] virtual bool takeAt(const std::vector<double>& heads, double days, std::vector<double>& sinks,
                                      std::vector<double>& byHead) = 0;
    /// Adds how all that changes with the heads near those of the last takeAt().
    virtual void addChange(const std::vector<double>& headChanges, std::vector<double>& sinkChanges) const = 0;
  };

  /// Lets time pass in one step of at most `days`, as long as converges and as its error allows. Returns the days that
  /// passed. 0 means that not even the shortest step of 10⁻⁹ days converged, and nothing has changed. Afterwards flux()
  /// has the flow of the step, and sinks() what `uptake` took.
  [[nodiscard]] double advance(double days, const SoilBorders& borders, const Tolerance& tolerance,
                               Uptake* uptake = nullptr);
  /// The residual at the end of the last iteration in advance(), volume of water per volume of soil.
  [[nodiscard]] double lastResidual() const { return lastResidual_; }
  /// The cell where it was largest.
  [[nodiscard]] std::size_t lastCell() const { return lastCell_; }

  /// Water that crossed the face above (axis 2), or towards higher i (axis 0) or k (axis 1) of a cell in the last
  /// advance(), length³ per day, in that direction.
  [[nodiscard]] double flux(std::size_t cell, std::size_t axis) const { return fluxes_[axis][cell]; }
  /// Water that came in through the surface and left through the bottom of a cell in the last advance(), length³ per
  /// day.
  [[nodiscard]] double surfaceFlux(std::size_t cell) const { return surfaceFlux_[cell]; }
  [[nodiscard]] double bottomFlux(std::size_t cell) const { return bottomFlux_[cell]; }

 private:
  /// Flow through a face and its derivatives by the heads of both sides, length³ and length² per day.
  struct FaceFlow {
    double flux = 0.0;
    double byFrom = 0.0;
    double byTo = 0.0;
  };
  /// One side of a face: the number of its soil, and its head.
  struct Side {
    int soil = 0;
    FluxPotential::Point point;
  };
  [[nodiscard]] FaceFlow faceFlow(const Side& from, const Side& to, double rise, double areaPerDistance) const;
  [[nodiscard]] Side sideOf(std::size_t cell) const { return {soilOf_[cell], points_[cell]}; }
  [[nodiscard]] Side sideAt(std::size_t cell, double head) const {
    return {soilOf_[cell], potentialOf(cell).pointAt(head)};
  }
  [[nodiscard]] bool isBottomOfColumn(std::size_t cell) const { return cell < stride(2) && isSoil(cell); }
  /// How a change of heads that the linear equations give is made: as it is, or where a cell gets wetter no further
  /// than the same change of water contents goes. In a very dry cell the head that belongs to a little water jumps, and
  /// a step by its slope goes far beyond.
  enum class Newton : std::uint8_t { ByHeads, ByContents };
  [[nodiscard]] double advanceBy(Newton kind, double days, const SoilBorders& borders, const Tolerance& tolerance,
                                 Uptake* uptake);
  [[nodiscard]] bool iterate(Newton kind, double days, const SoilBorders& borders, double tolerance, Uptake* uptake);
  [[nodiscard]] double headAfter(Newton kind, std::size_t cell, double start, double change) const;
  [[nodiscard]] bool hasDryCell(double content) const;
  [[nodiscard]] bool solveSystem(const Uptake* uptake);
  [[nodiscard]] bool assemble(double days, const SoilBorders& borders, Uptake* uptake);
  void addSurface(std::size_t cell, const SoilBorders& borders);
  void addBottom(std::size_t cell, const SoilBorders& borders);
  [[nodiscard]] double largestResidual();
  [[nodiscard]] double timeErrorOf(double days) const;
  void accept(double days, const SoilBorders& borders);

  Shape shape_;
  std::vector<SoilLayer> soils_;
  std::vector<FluxPotential> potentials_;  // of the soils
  std::vector<int> soilOf_;
  std::array<std::vector<std::uint8_t>, 3> hasFace_;  // an open face towards the next cell along an axis (cells)
  std::vector<std::uint8_t> isSurface_;               // its upper face is the surface of the ground (cells)
  State state_;
  std::vector<double> sinks_;                  // (cells)
  std::vector<double> heads_;                  // of the iteration (cells)
  std::array<std::vector<double>, 3> fluxes_;  // (cells)
  std::vector<double> surfaceFlux_, bottomFlux_, residual_, change_;
  std::vector<FluxPotential::Point> points_;  // of the iteration (cells)
  std::vector<double> contents_;              // of the iteration (cells)
  std::vector<double> uptakeByHead_;          // of what an Uptake takes, 0 without one (cells)
  double lastResidual_ = 0.0;
  std::size_t lastCell_ = 0;
  FlowSystem system_;
};

}  // namespace espalier::environment
