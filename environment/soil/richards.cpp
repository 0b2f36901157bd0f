#include "environment/soil/richards.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace espalier::environment {

namespace {

constexpr int kMostIterations = 30;
constexpr double kShortestStepDays = 1e-9;
constexpr double kSystemTolerance = 1e-8;  // of a linear system, relative: outer iterations repair the rest

double dotProduct(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

}  // namespace

RichardsSolver::RichardsSolver(const Shape& shape, std::vector<SoilLayer> soils, std::vector<int> soilOf)
    : shape_(shape), soils_(std::move(soils)), soilOf_(std::move(soilOf)) {
  const std::size_t count = soilOf_.size();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    hasFace_[axis].assign(count, 0);
    coupling_[axis].assign(count, 0.0);
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
  for (std::size_t cell = 0; cell < count; ++cell) {
    setHead(cell, -1.0);
  }
  surfaceFlux_.assign(count, 0.0);
  bottomFlux_.assign(count, 0.0);
  diagonal_.assign(count, 1.0);
  residual_.assign(count, 0.0);
  change_.assign(count, 0.0);
  conductivities_.assign(count, 0.0);
  forward_.assign(shape_.layers, 0.0);
}

bool RichardsSolver::isTopOfColumn(std::size_t cell) const {
  return isSurface_[cell] != 0;
}

bool RichardsSolver::isBottomOfColumn(std::size_t cell) const {
  return cell < stride(2) && isSoil(cell);
}

void RichardsSolver::setHead(std::size_t cell, double head) {
  state_.heads[cell] = head;
  state_.contents[cell] = isSoil(cell) ? soilOf(cell).content(head) : 0.0;
}

void RichardsSolver::take(std::size_t cell, double amount) {
  const SoilLayer& soil = soilOf(cell);
  state_.contents[cell] -= amount / cellVolume();
  state_.heads[cell] = soil.headAt(soil.content(state_.heads[cell]) - amount / cellVolume());
}

double RichardsSolver::storedWater() const {
  double sum = 0.0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    sum += contentOf(cell);
  }
  return sum * cellVolume();
}

double RichardsSolver::advance(double days, const SoilBorders& borders, double tolerance) {
  double step = std::min(days, state_.timeStep);
  for (; step >= std::min(kShortestStepDays, days); step /= 3.0) {
    heads_ = state_.heads;
    int iteration = 0;
    bool isConverged = false;
    for (; iteration <= kMostIterations; ++iteration) {
      assemble(step, borders);
      isConverged = largestResidual() * step <= tolerance * cellVolume();
      if (isConverged || iteration == kMostIterations) {
        break;
      }
      solve();
      for (std::size_t cell = 0; cell < cellCount(); ++cell) {
        heads_[cell] += change_[cell];
      }
    }
    if (!isConverged) {
      continue;
    }
    state_.heads = heads_;
    for (std::size_t cell = 0; cell < cellCount(); ++cell) {
      if (isSoil(cell)) {
        // the content after inflow and outflow, which differs a little from that of the head
        state_.contents[cell] = soilOf(cell).content(heads_[cell]) + residual_[cell] * step / cellVolume();
      }
      state_.balance.infiltrated += surfaceFlux_[cell] * step;
      state_.balance.drained += bottomFlux_[cell] * step;
      if (isTopOfColumn(cell) && !borders.hasTopHead) {
        const double offered = borders.rain * shape_.cellSize[0] * shape_.cellSize[1];
        const double demanded = borders.evaporation * shape_.cellSize[0] * shape_.cellSize[1];
        state_.balance.runOff +=
            std::max(offered - demanded - surfaceFlux_[cell], 0.0) * step * (offered > demanded ? 1.0 : 0.0);
      }
    }
    // steps that converge quickly become longer; one cut by the end of the time says nothing about the next
    if (step < days || iteration >= 15) {
      state_.timeStep = iteration <= 7 ? step * 1.5 : iteration >= 15 ? step * 0.7 : step;
    } else {
      state_.timeStep = std::max(state_.timeStep, iteration <= 7 ? step * 1.5 : step);
    }
    return step;
  }
  return 0.0;
}

void RichardsSolver::assemble(double days, const SoilBorders& borders) {
  const std::size_t count = cellCount();
  const double volume = cellVolume();
  // storage: the term that the modified Picard iteration linearises
  for (std::size_t cell = 0; cell < count; ++cell) {
    surfaceFlux_[cell] = 0.0;
    bottomFlux_[cell] = 0.0;
    residual_[cell] = 0.0;
    diagonal_[cell] = 1.0;
    if (isSoil(cell)) {
      const SoilLayer& soil = soilOf(cell);
      conductivities_[cell] = soil.conductivityAt(heads_[cell]);
      diagonal_[cell] = soil.capacity(heads_[cell]) * volume / days;
      residual_[cell] = -(soil.content(heads_[cell]) - state_.contents[cell]) * volume / days;
    }
  }
  // flow through the faces
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double distance = shape_.cellSize[axis];
    const double area = volume / distance;
    const double rise = axis == 2 ? distance : 0.0;
    const std::size_t next = stride(axis);
    for (std::size_t cell = 0; cell < count; ++cell) {
      if (hasFace_[axis][cell] == 0) {
        continue;
      }
      const double conductance = 0.5 * (conductivities_[cell] + conductivities_[cell + next]) * area / distance;
      const double flux = conductance * (heads_[cell] - heads_[cell + next] - rise);
      coupling_[axis][cell] = conductance;
      fluxes_[axis][cell] = flux;
      residual_[cell] -= flux;
      residual_[cell + next] += flux;
      diagonal_[cell] += conductance;
      diagonal_[cell + next] += conductance;
    }
  }
  for (std::size_t cell = 0; cell < count; ++cell) {
    if (isTopOfColumn(cell)) {
      addSurface(cell, borders);
    }
    if (isBottomOfColumn(cell)) {
      addBottom(cell, borders);
    }
  }
}

void RichardsSolver::addSurface(std::size_t cell, const SoilBorders& borders) {
  const double area = shape_.cellSize[0] * shape_.cellSize[1];
  const double half = shape_.cellSize[2] / 2.0;
  const SoilLayer& soil = soilOf(cell);
  // flow from a surface that has a head
  const auto conductance = [&](double surfaceHead) {
    return 0.5 * (soil.conductivityAt(surfaceHead) + conductivities_[cell]) * area / half;
  };
  const auto inflow = [&](double surfaceHead) {
    return conductance(surfaceHead) * (surfaceHead + half - heads_[cell]);
  };
  double flux = 0.0;
  bool isByHead = borders.hasTopHead;
  double head = borders.topHead;
  if (!isByHead) {
    flux = (borders.rain - borders.evaporation) * area;
    // no more than a flooded surface lets in, no more out than a dry one gives
    head = flux > 0.0 ? 0.0 : borders.driestHead;
    const double most = inflow(head);
    isByHead = flux > 0.0 ? most < flux : most > flux;
  }
  if (isByHead) {
    flux = inflow(head);
    if (!borders.hasTopHead && head < 0.0 && flux > 0.0) {
      flux = 0.0;
    } else {
      diagonal_[cell] += conductance(head);
    }
  }
  surfaceFlux_[cell] = flux;
  residual_[cell] += flux;
}

void RichardsSolver::addBottom(std::size_t cell, const SoilBorders& borders) {
  const double area = shape_.cellSize[0] * shape_.cellSize[1];
  const double half = shape_.cellSize[2] / 2.0;
  double flux = 0.0;
  if (borders.bottom == SoilBorders::Bottom::Free) {
    flux = conductivities_[cell] * area;
  } else if (borders.bottom == SoilBorders::Bottom::Head) {
    const double mean = 0.5 * (soilOf(cell).conductivityAt(borders.bottomHead) + conductivities_[cell]);
    flux = mean * area / half * (heads_[cell] + half - borders.bottomHead);
    diagonal_[cell] += mean * area / half;
  }
  bottomFlux_[cell] = flux;
  residual_[cell] -= flux;
}

double RichardsSolver::largestResidual() const {
  double largest = 0.0;
  for (const double residual : residual_) {
    // not a number is as bad as infinite
    largest = std::isfinite(residual) ? std::max(largest, std::abs(residual)) : HUGE_VAL;
  }
  return largest;
}

void RichardsSolver::multiply(const std::vector<double>& v, std::vector<double>& result) const {
  for (std::size_t cell = 0; cell < v.size(); ++cell) {
    result[cell] = diagonal_[cell] * v[cell];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = stride(axis);
    for (std::size_t cell = 0; cell < v.size(); ++cell) {
      if (hasFace_[axis][cell] != 0) {
        result[cell] -= coupling_[axis][cell] * v[cell + next];
        result[cell + next] -= coupling_[axis][cell] * v[cell];
      }
    }
  }
}

void RichardsSolver::solveColumns(const std::vector<double>& right, std::vector<double>& result) const {
  const std::size_t up = stride(2);
  const auto link = [&](std::size_t cell) { return hasFace_[2][cell] != 0 ? coupling_[2][cell] : 0.0; };
  for (std::size_t column = 0; column < up; ++column) {
    // elimination upwards, then back
    double pivot = diagonal_[column];
    result[column] = right[column] / pivot;
    std::size_t cell = column;
    for (std::size_t layer = 1; layer < shape_.layers; ++layer) {
      const double coupling = link(cell);
      forward_[layer] = coupling / pivot;
      cell += up;
      pivot = diagonal_[cell] - coupling * forward_[layer];
      result[cell] = (right[cell] + coupling * result[cell - up]) / pivot;
    }
    for (std::size_t layer = shape_.layers; layer-- > 1;) {
      result[cell - up] += forward_[layer] * result[cell];
      cell -= up;
    }
  }
}

void RichardsSolver::solve() {
  const std::size_t count = cellCount();
  std::vector<double> rest = residual_;
  std::vector<double> improved(count);
  std::vector<double> image(count);
  std::fill(change_.begin(), change_.end(), 0.0);
  solveColumns(rest, improved);
  std::vector<double> direction = improved;
  double product = dotProduct(rest, improved);
  const double enough = product * kSystemTolerance * kSystemTolerance;
  for (std::size_t round = 0; round < 1000 && product > enough; ++round) {
    multiply(direction, image);
    const double width = product / dotProduct(direction, image);
    for (std::size_t i = 0; i < count; ++i) {
      change_[i] += width * direction[i];
      rest[i] -= width * image[i];
    }
    solveColumns(rest, improved);
    const double next = dotProduct(rest, improved);
    const double turn = next / product;
    product = next;
    for (std::size_t i = 0; i < count; ++i) {
      direction[i] = improved[i] + turn * direction[i];
    }
  }
}

}  // namespace espalier::environment
