#include "environment/soil/flow_system.h"

#include <algorithm>
#include <cmath>

namespace espalier::environment {

namespace {

constexpr int kMostRounds = 1000;

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

}  // namespace

FlowSystem::FlowSystem(std::array<std::size_t, 2> columns, std::size_t layers) : columns_(columns) {
  const std::size_t count = columns[0] * columns[1] * layers;
  diagonal_.assign(count, 0.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    next_[axis].assign(count, 0.0);
    back_[axis].assign(count, 0.0);
  }
  for (auto* numbers : {&pivot_, &factor_, &rest_, &shadow_, &direction_, &turned_, &image_, &half_, &halfImage_}) {
    numbers->assign(count, 0.0);
  }
}

void FlowSystem::clear() {
  std::fill(diagonal_.begin(), diagonal_.end(), 0.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::fill(next_[axis].begin(), next_[axis].end(), 0.0);
    std::fill(back_[axis].begin(), back_[axis].end(), 0.0);
  }
}

void FlowSystem::eliminate() {
  const std::size_t up = stride(2);
  for (std::size_t cell = 0; cell < diagonal_.size(); ++cell) {
    factor_[cell] = cell < up ? 0.0 : back_[2][cell - up] / pivot_[cell - up];
    pivot_[cell] = diagonal_[cell] - (cell < up ? 0.0 : factor_[cell] * next_[2][cell - up]);
  }
}

void FlowSystem::solveColumns(const std::vector<double>& right, std::vector<double>& result) const {
  const std::size_t up = stride(2);
  const std::size_t count = diagonal_.size();
  for (std::size_t cell = 0; cell < count; ++cell) {
    result[cell] = right[cell] - (cell < up ? 0.0 : factor_[cell] * result[cell - up]);
  }
  for (std::size_t cell = count; cell-- > 0;) {
    const double above = cell + up < count ? next_[2][cell] * result[cell + up] : 0.0;
    result[cell] = (result[cell] - above) / pivot_[cell];
  }
}

void FlowSystem::multiply(const std::vector<double>& v, const Addition& addition, std::vector<double>& result) const {
  for (std::size_t cell = 0; cell < v.size(); ++cell) {
    result[cell] = diagonal_[cell] * v[cell];
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t step = stride(axis);
    for (std::size_t cell = 0; cell + step < v.size(); ++cell) {
      result[cell] += next_[axis][cell] * v[cell + step];
      result[cell + step] += back_[axis][cell] * v[cell];
    }
  }
  if (addition) {
    addition(v, result);
  }
}

bool FlowSystem::solve(const std::vector<double>& right, double tolerance, std::vector<double>& result,
                       const Addition& addition) {
  const std::size_t count = right.size();
  eliminate();
  solveColumns(right, result);
  if (columns_[0] * columns_[1] == 1 && !addition) {
    return std::isfinite(product(result, result));
  }
  const double enough = tolerance * tolerance * product(right, right);
  multiply(result, addition, image_);
  for (std::size_t i = 0; i < count; ++i) {
    rest_[i] = right[i] - image_[i];
  }
  shadow_ = rest_;
  direction_ = rest_;
  double along = product(shadow_, rest_);
  for (int round = 0; round < kMostRounds; ++round) {
    const double left = product(rest_, rest_);
    if (left <= enough) {
      return true;
    }
    solveColumns(direction_, turned_);
    multiply(turned_, addition, image_);
    const double width = along / product(shadow_, image_);
    for (std::size_t i = 0; i < count; ++i) {
      result[i] += width * turned_[i];
      rest_[i] -= width * image_[i];
    }
    solveColumns(rest_, half_);
    multiply(half_, addition, halfImage_);
    const double norm = product(halfImage_, halfImage_);
    const double share = norm > 0.0 ? product(halfImage_, rest_) / norm : 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      result[i] += share * half_[i];
      rest_[i] -= share * halfImage_[i];
    }
    const double next = product(shadow_, rest_);
    const double turn = next / along * (width / share);
    along = next;
    for (std::size_t i = 0; i < count; ++i) {
      direction_[i] = rest_[i] + turn * (direction_[i] - share * image_[i]);
    }
    if (!std::isfinite(turn)) {
      return product(rest_, rest_) <= enough;
    }
  }
  return false;
}

}  // namespace espalier::environment
