#include "environment/soil/solutes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"

namespace espalier::environment {

namespace {

constexpr double kLogarithm10 = 2.302585092994045684;
constexpr double kMostWork = 1e9;         // changes of cells in a step of the simulation: about half a minute
constexpr double kMostWorkAtRate = 1e12;  // the same if the whole step were as one part of it: hours
constexpr double kPartOfStep = 0.9;       // of its content that a cell loses in an internal step

}  // namespace

SoluteTransport::SoluteTransport(std::vector<Solute> solutes, const RichardsSolver& water, bool hasSurfaceConcentration)
    : solutes_(std::move(solutes)),
      water_(&water),
      hasSurfaceConcentration_(hasSurfaceConcentration),
      balances_(solutes_.size()) {
  for (const Solute& solute : solutes_) {
    std::vector<double> amounts(water.cellCount(), 0.0);
    for (std::size_t cell = 0; cell < amounts.size(); ++cell) {
      if (water.isSoil(cell)) {
        amounts[cell] = (water.contentOf(cell) + solute.sorption) * solute.initialConcentration;
      }
    }
    amounts_.push_back(std::move(amounts));
  }
  contents_.assign(water.cellCount(), 0.0);
  concentrations_.assign(water.cellCount(), 0.0);
  changes_.assign(water.cellCount(), 0.0);
}

double SoluteTransport::concentration(std::size_t number, std::size_t cell, double content) const {
  const Solute& solute = solutes_[number];
  const double amount = amounts_[number][cell];
  if (!(solute.bufferCapacity > 0.0)) {
    return amount / (content + solute.sorption);
  }
  // θ c₀ e^x + β x/ln 10 = amount, with x = ln(c/c₀): both terms grow with x, so Newton's method from the side where
  // the function is positive goes down to the only solution
  const double linear = solute.bufferCapacity / kLogarithm10;
  const double scale = content * solute.initialConcentration;
  double x = amount / linear;
  if (x > 0.0) {
    x = std::min(x, core::log1p(amount / scale));
  }
  for (int round = 0; round < 100; ++round) {
    const double dissolved = scale * core::exp(x);
    const double change = (dissolved + linear * x - amount) / (dissolved + linear);
    x -= change;
    if (std::abs(change) <= 1e-15 * std::max(1.0, std::abs(x))) {
      break;
    }
  }
  return solute.initialConcentration * core::exp(x);
}

double SoluteTransport::diffusivityIn(const Solute& solute, std::size_t cell) const {
  const double full = water_->soilOf(cell).saturatedContent;
  return solute.diffusivity * core::pow(contents_[cell], 10.0 / 3.0) / (full * full);
}

double SoluteTransport::coefficientOf(const Solute& solute, std::size_t cell, std::size_t axis) const {
  const double mean = 0.5 * (diffusivityIn(solute, cell) + diffusivityIn(solute, cell + water_->stride(axis)));
  return (mean * water_->faceArea(cell, axis) + solute.dispersivity * std::abs(water_->flux(cell, axis))) /
         water_->distanceToNext(cell, axis);
}

double SoluteTransport::surfaceCoefficientOf(const Solute& solute, std::size_t cell) const {
  if (!hasSurfaceConcentration_ || !water_->isSurface(cell)) {
    return 0.0;
  }
  return (diffusivityIn(solute, cell) * water_->faceArea(cell, 2) +
          solute.dispersivity * std::abs(water_->surfaceFlux(cell))) /
         (0.5 * water_->sizeOf(cell, 2));
}

/// Whether the rest of the step of the simulation is clearly too much work. Soil that dries slows diffusion down, so
/// the limit is wider at the beginning of the step than after a tenth of the work.
bool SoluteTransport::isWorkTooMuch() {
  const bool isTimeToLook = looks_ == 0 || (looks_ == 1 && work_ > 0.1 * kMostWork);
  if (!isTimeToLook) {
    return false;
  }
  ++looks_;
  return !(work_ + workOfDiffusion(stepDays_ - passedDays_) <= (looks_ == 1 ? 4.0 : 1.5) * kMostWork);
}

double SoluteTransport::workOfDiffusion(double days) const {
  double steps = 0.0;
  for (const Solute& solute : solutes_) {
    double fastest = 0.0;
    for (std::size_t cell = 0; cell < contents_.size(); ++cell) {
      double leaving = 0.0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t stride = water_->stride(axis);
        const auto add = [&](std::size_t from) {
          const double mean = 0.5 * (diffusivityIn(solute, from) + diffusivityIn(solute, from + stride));
          leaving += mean * water_->faceArea(from, axis) / water_->distanceToNext(from, axis);
        };
        if (water_->hasFace(cell, axis)) {
          add(cell);
        }
        if (cell >= stride && water_->hasFace(cell - stride, axis)) {
          add(cell - stride);
        }
      }
      if (leaving > 0.0) {
        fastest = std::max(fastest, leaving / (water_->cellVolume(cell) * (contents_[cell] + solute.sorption)));
      }
    }
    steps += fastest * days / kPartOfStep;
  }
  return steps * static_cast<double>(contents_.size());
}

/// The concentration that water carries through a face: that of the cell it leaves, and a limited part of the slope
/// there, less what flows through while the slope passes (Lax & Wendroff 1960; van Leer 1974).
double SoluteTransport::atFace(const Solute& solute, std::size_t cell, std::size_t axis, double days) const {
  const std::size_t stride = water_->stride(axis);
  const double flux = water_->flux(cell, axis);
  const std::size_t from = flux > 0.0 ? cell : cell + stride;
  const std::size_t to = flux > 0.0 ? cell + stride : cell;
  const double own = concentrations_[from];
  const double ahead = concentrations_[to] - own;
  const bool hasBehind =
      flux > 0.0 ? from >= stride && water_->hasFace(from - stride, axis) : water_->hasFace(from, axis);
  if (!hasBehind || ahead == 0.0) {
    return own;
  }
  const double behind = own - concentrations_[flux > 0.0 ? from - stride : from + stride];
  const double ratio = behind / ahead;
  const double limiter = ratio > 0.0 ? 2.0 * ratio / (1.0 + ratio) : 0.0;
  const double passing = std::abs(flux) * days / (water_->cellVolume(from) * (contents_[from] + solute.sorption));
  return own + 0.5 * limiter * (1.0 - std::min(passing, 1.0)) * ahead;
}

bool SoluteTransport::follow(double days, const std::vector<double>& before) {
  // no cell loses more than it has: the largest part of its water that leaves it, or spreads, in a step
  const std::size_t count = water_->cellCount();
  std::vector<double> after(count);
  for (std::size_t cell = 0; cell < count; ++cell) {
    after[cell] = water_->contentOf(cell);
    contents_[cell] = std::min(before[cell], after[cell]);
  }
  if (isWorkTooMuch()) {
    return false;
  }
  passedDays_ += days;
  for (std::size_t number = 0; number < solutes_.size(); ++number) {
    const Solute& solute = solutes_[number];
    std::vector<double>& leaving = changes_;
    for (std::size_t cell = 0; cell < count; ++cell) {
      leaving[cell] =
          std::max(water_->bottomFlux(cell), 0.0) + (water_->isSoil(cell) ? surfaceCoefficientOf(solute, cell) : 0.0);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t stride = water_->stride(axis);
      for (std::size_t cell = 0; cell + stride < count; ++cell) {
        if (!water_->hasFace(cell, axis)) {
          continue;
        }
        const double flux = water_->flux(cell, axis);
        const double spreading = coefficientOf(solute, cell, axis);
        leaving[cell] += std::max(flux, 0.0) + spreading;
        leaving[cell + stride] += std::max(-flux, 0.0) + spreading;
      }
    }
    double fastest = 0.0;
    for (std::size_t cell = 0; cell < count; ++cell) {
      if (water_->isSoil(cell)) {
        fastest = std::max(fastest, leaving[cell] / (water_->cellVolume(cell) * (contents_[cell] + solute.sorption)));
      }
    }
    const double steps = std::max(1.0, std::ceil(fastest * days / kPartOfStep));
    work_ += steps * static_cast<double>(count);
    // the first part of a step is short, and does not show that all of them take hours
    if (!(work_ <= kMostWork) || !(fastest * stepDays_ * static_cast<double>(count) <= kMostWorkAtRate)) {
      return false;
    }
    for (double step = 0.0; step < steps; step += 1.0) {
      core::pollWork();
      // concentrations at the water content with which the part begins
      for (std::size_t cell = 0; cell < count; ++cell) {
        const double part = step / steps;
        const double content = before[cell] + (after[cell] - before[cell]) * part;
        concentrations_[cell] = water_->isSoil(cell) ? concentration(number, cell, content) : 0.0;
      }
      move(number, days / steps);
    }
  }
  return true;
}

void SoluteTransport::move(std::size_t number, double days) {
  const Solute& solute = solutes_[number];
  const std::size_t count = water_->cellCount();
  Balance& balance = balances_[number];
  for (std::size_t cell = 0; cell < count; ++cell) {
    // in with the rain, out through the bottom; nothing with water that evaporates
    const double spreading = water_->isSoil(cell) ? surfaceCoefficientOf(solute, cell) : 0.0;
    const double in = std::max(water_->surfaceFlux(cell), 0.0) * solute.rainConcentration +
                      spreading * (solute.rainConcentration - concentrations_[cell]);
    const double out = water_->bottomFlux(cell) * concentrations_[cell];
    changes_[cell] = in - out;
    balance.left += (out - in) * days;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t stride = water_->stride(axis);
    for (std::size_t cell = 0; cell + stride < count; ++cell) {
      if (!water_->hasFace(cell, axis)) {
        continue;
      }
      const double flux = water_->flux(cell, axis);
      const double carried =
          flux * atFace(solute, cell, axis, days) +
          coefficientOf(solute, cell, axis) * (concentrations_[cell] - concentrations_[cell + stride]);
      changes_[cell] -= carried;
      changes_[cell + stride] += carried;
    }
  }
  const double staying = core::exp(-solute.decayRate * days);
  for (std::size_t cell = 0; cell < count; ++cell) {
    double& amount = amounts_[number][cell];
    amount += changes_[cell] * days / water_->cellVolume(cell);
    balance.decayed += amount * (1.0 - staying) * water_->cellVolume(cell);
    amount *= staying;
  }
}

}  // namespace espalier::environment
