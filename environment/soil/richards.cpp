#include "environment/soil/richards.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace espalier::environment {

namespace {

constexpr int kMostIterations = 25;
constexpr int kMostHalvings = 6;
constexpr double kShortestStepDays = 1e-9;
constexpr double kSystemTolerance = 1e-8;  // of the linear equations: the next iteration repairs the rest
constexpr double kUptakeTolerance = 1e-5;  // the same with an Uptake, which costs more
constexpr double kMostGrowth = 2.0;        // of a time step from one to the next

}  // namespace

RichardsSolver::RichardsSolver(const Shape& shape, std::vector<SoilLayer> soils, std::vector<int> soilOf)
    : shape_(shape), soils_(std::move(soils)), soilOf_(std::move(soilOf)), system_(shape.columns, shape.layers) {
  for (const SoilLayer& soil : soils_) {
    potentials_.emplace_back(soil);
  }
  const std::size_t count = soilOf_.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    hasFace_[axis].assign(count, 0);
    fluxes_[axis].assign(count, 0.0);
  }
  isSurface_.assign(count, 0);
  for (std::size_t cell = 0; cell < count; ++cell) {
    const std::array<std::size_t, 3> place{cell / shape_.columns[1] % shape_.columns[0], cell % shape_.columns[1],
                                           cell / (shape_.columns[0] * shape_.columns[1])};
    const std::array<std::size_t, 3> sizes{shape_.columns[0], shape_.columns[1], shape_.layers};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      hasFace_[axis][cell] = place[axis] + 1 < sizes[axis] && isSoil(cell) && isSoil(cell + stride(axis)) ? 1 : 0;
    }
    isSurface_[cell] = place[2] + 1 == shape_.layers && isSoil(cell) ? 1 : 0;
  }
  state_.heads.assign(count, -1.0);
  state_.contents.assign(count, 0.0);
  state_.rates.assign(count, 0.0);
  for (std::size_t cell = 0; cell < count; ++cell) {
    setHead(cell, -1.0);
  }
  for (auto* numbers : {&sinks_, &surfaceFlux_, &bottomFlux_, &residual_, &change_, &contents_, &uptakeByHead_}) {
    numbers->assign(count, 0.0);
  }
  points_.resize(count);
}

void RichardsSolver::setHead(std::size_t cell, double head) {
  state_.heads[cell] = head;
  state_.contents[cell] = isSoil(cell) ? soilOf(cell).content(head) : 0.0;
}

double RichardsSolver::storedWater() const {
  double sum = 0.0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    sum += contentOf(cell) * cellVolume(cell);
  }
  return sum;
}

double RichardsSolver::advance(double days, const SoilBorders& borders, const Tolerance& tolerance, Uptake* uptake) {
  // heads of a cell with less water than the tolerance mean nothing to Newton's method
  if (!hasDryCell(tolerance.iteration)) {
    if (const double passed = advanceBy(Newton::ByHeads, days, borders, tolerance, uptake); passed > 0.0) {
      return passed;
    }
  }
  return advanceBy(Newton::ByContents, days, borders, tolerance, uptake);
}

bool RichardsSolver::hasDryCell(double content) const {
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    if (isSoil(cell) && state_.contents[cell] - soilOf(cell).residualContent < content) {
      return true;
    }
  }
  return false;
}

double RichardsSolver::advanceBy(Newton kind, double days, const SoilBorders& borders, const Tolerance& tolerance,
                                 Uptake* uptake) {
  double step = std::min(days, state_.timeStep);
  for (; step >= std::min(kShortestStepDays, days); step /= 3.0) {
    heads_ = state_.heads;
    if (!iterate(kind, step, borders, tolerance.iteration, uptake)) {
      continue;
    }
    const double error = timeErrorOf(step);
    // the error grows with the square of the step
    const double factor = 0.9 * std::sqrt(tolerance.time / std::max(error, 1e-300));
    if (factor < 0.5 && step > 1e3 * kShortestStepDays) {
      step *= 3.0 * std::max(factor, 0.1);
      continue;
    }
    const double next = step * std::min(factor, kMostGrowth);
    // a step that was cut by the end of the time says only that the next one may be as long
    state_.timeStep = step < days ? next : std::max(state_.timeStep, next);
    accept(step, borders);
    return step;
  }
  return 0.0;
}

double RichardsSolver::headAfter(Newton kind, std::size_t cell, double start, double change) const {
  const double head = start + change;
  if (kind == Newton::ByHeads || !isSoil(cell) || !(change > 0.0) || start >= 0.0) {
    return head;
  }
  constexpr double kAlmostSaturated = 0.99;
  const SoilLayer& soil = soilOf(cell);
  const double before = soil.saturation(start);
  const double after = std::min(before + soil.capacity(start) * change / (soil.saturatedContent - soil.residualContent),
                                kAlmostSaturated);
  return after > before ? std::min(head, soil.headAtSaturation(after)) : head;
}

bool RichardsSolver::iterate(Newton kind, double days, const SoilBorders& borders, double tolerance, Uptake* uptake) {
  double residual = assemble(days, borders, uptake) ? largestResidual() : HUGE_VAL;
  lastResidual_ = residual * days;
  if (!std::isfinite(residual)) {
    return false;
  }
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    if (residual * days <= tolerance) {
      return true;
    }
    if (!solveSystem(uptake)) {
      return false;
    }
    // a whole step of Newton's method, or as much of it as makes the residual smaller
    const std::vector<double> start = heads_;
    double share = 1.0;
    double best = HUGE_VAL;
    for (int halving = 0; halving <= kMostHalvings; ++halving, share *= 0.5) {
      for (std::size_t cell = 0; cell < cellCount(); ++cell) {
        heads_[cell] = headAfter(kind, cell, start[cell], share * change_[cell]);
      }
      best = assemble(days, borders, uptake) ? largestResidual() : HUGE_VAL;
      if (best < residual) {
        break;
      }
    }
    if (!std::isfinite(best)) {
      return false;
    }
    residual = best;
    lastResidual_ = residual * days;
  }
  return false;
}

bool RichardsSolver::solveSystem(const Uptake* uptake) {
  if (uptake == nullptr) {
    return system_.solve(residual_, kSystemTolerance, change_);
  }
  // the matrix has what each cell gives by its own head; the plants carry that to all cells
  return system_.solve(residual_, kUptakeTolerance, change_,
                       [this, uptake](const std::vector<double>& v, std::vector<double>& result) {
                         for (std::size_t cell = 0; cell < v.size(); ++cell) {
                           result[cell] -= uptakeByHead_[cell] * v[cell];
                         }
                         uptake->addChange(v, result);
                       });
}

double RichardsSolver::timeErrorOf(double days) const {
  double largest = 0.0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    if (isSoil(cell)) {
      const double rate = (contents_[cell] - state_.contents[cell]) / days;
      largest = std::max(largest, std::abs(rate - state_.rates[cell]));
    }
  }
  return 0.5 * days * largest;
}

void RichardsSolver::accept(double days, const SoilBorders& borders) {
  state_.heads = heads_;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    if (isSoil(cell)) {
      // the content after inflow and outflow, which differs a little from that of the head
      const double content = contents_[cell] + residual_[cell] * days / cellVolume(cell);
      state_.rates[cell] = (content - state_.contents[cell]) / days;
      state_.contents[cell] = content;
    }
    state_.balance.infiltrated += surfaceFlux_[cell] * days;
    state_.balance.drained += bottomFlux_[cell] * days;
    if (isSurface(cell) && !borders.hasTopHead && borders.rain > borders.evaporation) {
      const double offered = (borders.rain - borders.evaporation) * faceArea(cell, 2);
      state_.balance.runOff += std::max(offered - surfaceFlux_[cell], 0.0) * days;
    }
  }
}

RichardsSolver::FaceFlow RichardsSolver::faceFlow(const Side& from, const Side& to, double rise,
                                                  double areaPerDistance) const {
  // K of the face is the mean over both soils of their mean K between the heads
  const FluxPotential& potential = potentials_[static_cast<std::size_t>(from.soil)];
  const bool isOneSoil = from.soil == to.soil;
  FluxPotential::Mean mean = potential.meanBetween(from.point, isOneSoil ? to.point : potential.pointAt(to.point.head));
  if (!isOneSoil) {
    const FluxPotential& second = potentials_[static_cast<std::size_t>(to.soil)];
    const FluxPotential::Mean other = second.meanBetween(second.pointAt(from.point.head), to.point);
    mean = {0.5 * (mean.conductivity + other.conductivity), 0.5 * (mean.byA + other.byA), 0.5 * (mean.byB + other.byB)};
  }
  const double drop = from.point.head - to.point.head;
  FaceFlow flow{areaPerDistance * mean.conductivity * drop, areaPerDistance * (mean.conductivity + mean.byA * drop),
                areaPerDistance * (-mean.conductivity + mean.byB * drop)};
  if (rise == 0.0) {
    return flow;
  }
  // gravity: where the upper side is the wetter one, with the mean of K at both sides, so that water in the soil behind
  // a front is not held back by the dry soil before it; elsewhere with the same mean as above, so that water at rest
  // stays
  if ((rise < 0.0) == (from.point.head > to.point.head)) {
    const FluxPotential::Point& upper = rise < 0.0 ? from.point : to.point;
    double atUpper = upper.conductivity;
    double slope = upper.conductivitySlope;
    if (!isOneSoil) {
      const SoilLayer& other = soils_[static_cast<std::size_t>(rise < 0.0 ? to.soil : from.soil)];
      atUpper = 0.5 * (atUpper + other.conductivityAt(upper.head));
      slope = 0.5 * (slope + other.conductivitySlope(upper.head));
    }
    const double least = std::abs(rise) * areaPerDistance * atUpper;
    const double matric = std::abs(flow.flux);
    const double whole = matric + std::abs(rise) * areaPerDistance * mean.conductivity;
    if (whole < least) {
      const double sign = rise < 0.0 ? 1.0 : -1.0;
      return {sign * least, rise < 0.0 ? -areaPerDistance * rise * slope : 0.0,
              rise < 0.0 ? 0.0 : -areaPerDistance * rise * slope};
    }
  }
  flow.flux -= areaPerDistance * rise * mean.conductivity;
  flow.byFrom -= areaPerDistance * rise * mean.byA;
  flow.byTo -= areaPerDistance * rise * mean.byB;
  return flow;
}

bool RichardsSolver::assemble(double days, const SoilBorders& borders, Uptake* uptake) {
  const std::size_t count = cellCount();
  if (uptake != nullptr && !uptake->takeAt(heads_, days, sinks_, uptakeByHead_)) {
    return false;
  }
  system_.clear();
  for (std::size_t cell = 0; cell < count; ++cell) {
    surfaceFlux_[cell] = 0.0;
    bottomFlux_[cell] = 0.0;
    residual_[cell] = 0.0;
    system_.diagonal(cell) = 1.0;
    if (isSoil(cell)) {
      const SoilLayer::Functions functions = soilOf(cell).at(heads_[cell]);
      points_[cell] = potentialOf(cell).pointAt(heads_[cell], functions.conductivity, functions.conductivitySlope);
      contents_[cell] = functions.content;
      const double storage = cellVolume(cell) / days;
      system_.diagonal(cell) = functions.capacity * storage;
      residual_[cell] = -(functions.content - state_.contents[cell]) * storage - sinks_[cell];
      if (uptake != nullptr) {
        system_.diagonal(cell) += uptakeByHead_[cell];
      }
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = stride(axis);
    for (std::size_t cell = 0; cell + next < count; ++cell) {
      if (hasFace_[axis][cell] == 0) {
        continue;
      }
      const double distance = distanceToNext(cell, axis);
      const FaceFlow flow =
          faceFlow(sideOf(cell), sideOf(cell + next), axis == 2 ? distance : 0.0, faceArea(cell, axis) / distance);
      fluxes_[axis][cell] = flow.flux;
      residual_[cell] -= flow.flux;
      residual_[cell + next] += flow.flux;
      system_.diagonal(cell) += flow.byFrom;
      system_.diagonal(cell + next) -= flow.byTo;
      system_.next(cell, axis) = flow.byTo;
      system_.back(cell, axis) = -flow.byFrom;
    }
  }
  for (std::size_t cell = 0; cell < count; ++cell) {
    if (isSurface(cell)) {
      addSurface(cell, borders);
    }
    if (isBottomOfColumn(cell)) {
      addBottom(cell, borders);
    }
  }
  return true;
}

void RichardsSolver::addSurface(std::size_t cell, const SoilBorders& borders) {
  const double area = faceArea(cell, 2);
  const double half = sizeOf(cell, 2) / 2.0;
  // flow from a surface that has a head
  const auto inflow = [&](double surfaceHead) {
    return faceFlow(sideAt(cell, surfaceHead), sideOf(cell), -half, area / half);
  };
  double flux = 0.0;
  double byHead = 0.0;
  if (borders.hasTopHead) {
    const FaceFlow flow = inflow(borders.topHead);
    flux = flow.flux;
    byHead = flow.byTo;
  } else {
    flux = (borders.rain - borders.evaporation) * area;
    // no more than a flooded surface lets in, no more out than a dry one gives
    const FaceFlow most = inflow(flux > 0.0 ? 0.0 : borders.driestHead);
    if (flux > 0.0 && most.flux < flux) {
      flux = most.flux;
      byHead = most.byTo;
    } else if (flux < 0.0 && most.flux > flux) {
      // a soil that is drier than the driest surface gives nothing
      flux = std::min(most.flux, 0.0);
      byHead = most.flux < 0.0 ? most.byTo : 0.0;
    }
  }
  surfaceFlux_[cell] = flux;
  residual_[cell] += flux;
  system_.diagonal(cell) -= byHead;
}

void RichardsSolver::addBottom(std::size_t cell, const SoilBorders& borders) {
  const double area = faceArea(cell, 2);
  const double half = sizeOf(cell, 2) / 2.0;
  double flux = 0.0;
  if (borders.bottom == SoilBorders::Bottom::Free) {
    flux = points_[cell].conductivity * area;
    system_.diagonal(cell) += points_[cell].conductivitySlope * area;
  } else if (borders.bottom == SoilBorders::Bottom::Head) {
    const FaceFlow flow = faceFlow(sideOf(cell), sideAt(cell, borders.bottomHead), -half, area / half);
    flux = flow.flux;
    system_.diagonal(cell) += flow.byFrom;
  }
  bottomFlux_[cell] = flux;
  residual_[cell] -= flux;
}

double RichardsSolver::largestResidual() {
  double largest = 0.0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    // not a number is as bad as infinite
    const double residual = residual_[cell] / cellVolume(cell);
    const double size = std::isfinite(residual) ? std::abs(residual) : HUGE_VAL;
    if (size > largest) {
      largest = size;
      lastCell_ = cell;
    }
  }
  return largest;
}

}  // namespace espalier::environment
