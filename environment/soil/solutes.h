#pragma once

#include <vector>

#include "environment/soil/richards.h"

namespace espalier::environment {

/// A dissolved substance. Amounts per length³ of water, or of soil where it says so.
struct Solute {
  double initialConcentration = 0.0;  // in the water
  double rainConcentration = 0.0;     // of the water that comes in through the surface
  double diffusivity = 0.0;           // in free water, length²/day
  double dispersivity = 0.0;          // length
  double sorption = 0.0;              // sorbed amount per volume of soil over the concentration
  double decayRate = 0.0;             // 1/day
  /// Above 0: the substance is H⁺, whose sorbed amount per volume of soil is −bufferCapacity · (pH − initial pH), a
  /// soil with a constant buffer capacity (amount per length³ of soil and unit of pH).
  double bufferCapacity = 0.0;
};

/// Transport of solutes with the water of a RichardsSolver: advection of second order with van Leer's limiter (1974),
/// dispersion and diffusion with the tortuosity θ^(7/3)/θs² (Millington & Quirk 1961), sorption or buffering in
/// equilibrium, decay. Explicit, in as many steps as stability needs, and conservative: the flow out of one cell
/// through a face enters the other cell. Water that evaporates leaves its solutes behind.
class SoluteTransport {
 public:
  /// `water` must outlive the transport and hold the initial water contents.
  /// With `hasSurfaceConcentration` the surface of the ground keeps the concentration of the rain.
  SoluteTransport(std::vector<Solute> solutes, const RichardsSolver& water, bool hasSurfaceConcentration = false);

  [[nodiscard]] std::size_t soluteCount() const { return solutes_.size(); }
  [[nodiscard]] const Solute& solute(std::size_t number) const { return solutes_[number]; }
  /// Amounts per volume of soil, in the water and sorbed; for H⁺ without the initial content of the buffer (cells).
  [[nodiscard]] std::vector<double>& amounts(std::size_t solute) { return amounts_[solute]; }
  [[nodiscard]] const std::vector<double>& amounts(std::size_t solute) const { return amounts_[solute]; }
  /// Concentration in the water of a cell at a water content.
  [[nodiscard]] double concentration(std::size_t solute, std::size_t cell, double content) const;

  /// Begins a step of the simulation of so many days.
  void beginStep(double days) {
    stepDays_ = days;
    passedDays_ = 0.0;
    work_ = 0.0;
    looks_ = 0;
  }
  /// Follows the solver's last advance(), which took `days` and before which the water contents were `before`. False: a
  /// solute spreads too fast for the cells, so that the step of the simulation would take minutes.
  [[nodiscard]] bool follow(double days, const std::vector<double>& before);

  /// The total amounts that have left the box through its borders since the beginning, and that have decayed.
  struct Balance {
    double left = 0.0;
    double decayed = 0.0;
  };
  [[nodiscard]] std::vector<Balance>& balances() { return balances_; }
  [[nodiscard]] const std::vector<Balance>& balances() const { return balances_; }

 private:
  [[nodiscard]] double diffusivityIn(const Solute& solute, std::size_t cell) const;
  /// Changes of cells by diffusion alone in so many days, as fast as it is at the water contents contents_.
  [[nodiscard]] double workOfDiffusion(double days) const;
  [[nodiscard]] bool isWorkTooMuch();
  [[nodiscard]] double coefficientOf(const Solute& solute, std::size_t cell, std::size_t axis) const;
  [[nodiscard]] double surfaceCoefficientOf(const Solute& solute, std::size_t cell) const;
  [[nodiscard]] double atFace(const Solute& solute, std::size_t cell, std::size_t axis, double days) const;
  void move(std::size_t number, double days);

  std::vector<Solute> solutes_;
  const RichardsSolver* water_;
  bool hasSurfaceConcentration_;
  std::vector<std::vector<double>> amounts_;  // by solute and cell
  std::vector<Balance> balances_;             // by solute
  double stepDays_ = 0.0;                     // of the step of the simulation
  double work_ = 0.0;                         // cells that follow() has changed in it
  double passedDays_ = 0.0;                   // of it, before the last follow()
  int looks_ = 0;                             // of isWorkTooMuch() in it
  std::vector<double> contents_;              // of water, in a step (cells)
  std::vector<double> concentrations_;        // of one solute, in a step (cells)
  std::vector<double> changes_;               // of one solute, in a step (cells)
};

}  // namespace espalier::environment
