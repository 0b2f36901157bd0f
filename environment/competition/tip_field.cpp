#include "environment/competition/tip_field.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/elementary.h"

namespace espalier::environment {

namespace {

constexpr std::uint32_t kBoxLeafSize = 8;   // points
constexpr std::size_t kTargetLeafSize = 8;  // centres
constexpr std::uint32_t kFewPoints = 8;     // act one by one rather than through nodes
constexpr int kMaximumDepth = 48;
constexpr double kSmooth = 1.0;  // distance of the kernel's singularities from the real distances
constexpr int kMatrixReach = 5;  // sides apart at most, when the squares around two have not acted on each other

double kernel(double dx, double dy) {
  return 1.0 / (1.0 + (dx * dx + dy * dy));
}

}  // namespace

TipField::TipField(std::vector<PlanePoint> points) : points_(std::move(points)) {
  for (std::size_t i = 0; i < kNodes; ++i) {
    chebyshev_[i] = core::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(kNodes));
  }
  for (std::size_t i = 0; i < kNodes; ++i) {
    double product = 1.0;
    for (std::size_t k = 0; k < kNodes; ++k) {
      product *= k == i ? 1.0 : chebyshev_[i] - chebyshev_[k];
    }
    scale_[i] = 1.0 / product;
  }
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t node = 0; node < kNodes; ++node) {
      const auto basis = basisAt((chebyshev_[node] + (half == 0 ? -1.0 : 1.0)) / 2.0);
      std::copy(basis.begin(), basis.end(), halves_[half].begin() + static_cast<std::ptrdiff_t>(node * kNodes));
    }
  }
  std::sort(points_.begin(), points_.end());
}

std::array<double, TipField::kNodes> TipField::basisAt(double u) const {
  // products of the distances from the nodes before and behind each
  std::array<double, kNodes> values{};
  double before = 1.0;
  for (std::size_t i = 0; i < kNodes; ++i) {
    values[i] = scale_[i] * before;
    before *= u - chebyshev_[i];
  }
  double behind = 1.0;
  for (std::size_t i = kNodes; i-- > 0;) {
    values[i] *= behind;
    behind *= u - chebyshev_[i];
  }
  return values;
}

TipField::Square TipField::quarterOf(const Square& square, std::size_t quarter) {
  const double half = square.half / 2.0;
  return {square.x + (quarter % 2 == 0 ? -half : half), square.y + (quarter < 2 ? -half : half), half};
}

void TipField::buildBox(std::uint32_t index, int depth) {
  const Square square = boxes_[index].square;
  const std::uint32_t count = boxes_[index].end - boxes_[index].begin;
  if (count > kBoxLeafSize && 4.0 * square.half > kSmooth && depth < kMaximumDepth) {
    // four quarters; a stable partition keeps the sorted order within each
    const auto first = points_.begin() + boxes_[index].begin;
    const auto last = points_.begin() + boxes_[index].end;
    const auto isLeft = [&](const PlanePoint& p) { return p.x < square.x; };
    const auto middle = std::stable_partition(first, last, [&](const PlanePoint& p) { return p.y < square.y; });
    const std::array bounds{first, std::stable_partition(first, middle, isLeft), middle,
                            std::stable_partition(middle, last, isLeft), last};
    boxes_[index].isLeaf = false;
    for (std::size_t quarter = 0; quarter < 4; ++quarter) {
      if (bounds[quarter] != bounds[quarter + 1]) {
        const auto child = static_cast<std::uint32_t>(boxes_.size());
        boxes_.emplace_back();
        boxes_.back().square = quarterOf(square, quarter);
        boxes_.back().begin = static_cast<std::uint32_t>(bounds[quarter] - points_.begin());
        boxes_.back().end = static_cast<std::uint32_t>(bounds[quarter + 1] - points_.begin());
        boxes_[index].children[quarter] = child;
        buildBox(child, depth + 1);
      }
    }
  }
  gather(boxes_[index]);
}

void TipField::gather(Box& box) const {
  if (box.isLeaf) {
    const double inverse = box.square.half > 0.0 ? 1.0 / box.square.half : 0.0;
    for (std::uint32_t p = box.begin; p < box.end; ++p) {
      const auto across = basisAt((points_[p].x - box.square.x) * inverse);
      const auto along = basisAt((points_[p].y - box.square.y) * inverse);
      for (std::size_t j = 0; j < kNodes; ++j) {
        for (std::size_t i = 0; i < kNodes; ++i) {
          box.weights[j * kNodes + i] += across[i] * along[j];
        }
      }
    }
    return;
  }
  // the nodes of a quarter are points of the whole: exact, a polynomial of this degree is its own interpolation
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    if (box.children[quarter] == 0) {
      continue;
    }
    const Expansion& weights = boxes_[box.children[quarter]].weights;
    const Matrix& across = halves_[quarter % 2];
    const Matrix& along = halves_[quarter / 2];
    Expansion rows{};
    for (std::size_t j = 0; j < kNodes; ++j) {
      for (std::size_t k = 0; k < kNodes; ++k) {
        for (std::size_t i = 0; i < kNodes; ++i) {
          rows[j * kNodes + i] += across[k * kNodes + i] * weights[j * kNodes + k];
        }
      }
    }
    for (std::size_t k = 0; k < kNodes; ++k) {
      for (std::size_t j = 0; j < kNodes; ++j) {
        for (std::size_t i = 0; i < kNodes; ++i) {
          box.weights[j * kNodes + i] += along[k * kNodes + j] * rows[k * kNodes + i];
        }
      }
    }
  }
}

void TipField::begin(std::span<const PlanePoint> centres, std::span<const double> offsets) {
  ESPALIER_CHECK(!offsets.empty() && offsets.size() <= kMostOffsets);
  centres_ = centres;
  offsets_ = offsets;
  open_.clear();
  boxes_.clear();
  if (points_.empty() && centres.empty()) {
    return;
  }
  // one square around everything, so that boxes and targets of a depth are the same squares
  double lowX = INFINITY;
  double highX = -INFINITY;
  double lowY = INFINITY;
  double highY = -INFINITY;
  const auto reach = [&](double x, double y) {
    lowX = std::min(lowX, x);
    highX = std::max(highX, x);
    lowY = std::min(lowY, y);
    highY = std::max(highY, y);
  };
  for (const PlanePoint& point : points_) {
    reach(point.x, point.y);
  }
  for (const PlanePoint& centre : centres) {
    reach(centre.x + offsets.front(), centre.y + offsets.front());
    reach(centre.x + offsets.back(), centre.y + offsets.back());
  }
  root_ = {lowX + (highX - lowX) / 2.0, lowY + (highY - lowY) / 2.0, std::max(highX - lowX, highY - lowY) / 2.0};
  if (!points_.empty()) {
    boxes_.emplace_back();
    boxes_.front().square = root_;
    boxes_.front().end = static_cast<std::uint32_t>(points_.size());
    buildBox(0, 0);
  }
  matrices_.assign(kMaximumDepth + 1, {});
  Target whole;
  whole.square = root_;
  for (std::uint32_t centre = 0; centre < centres.size(); ++centre) {
    const auto count = static_cast<std::uint8_t>(offsets.size());
    whole.parts.push_back({centre, 0, count, 0, count});
  }
  if (!boxes_.empty()) {
    whole.boxes.push_back(0);
  }
  open_.push_back(std::move(whole));
}

const TipField::Leaf* TipField::nextLeaf() {
  while (!open_.empty()) {
    leaf_ = std::move(open_.back());
    open_.pop_back();
    addFarBoxes(leaf_);
    if (isLeaf(leaf_)) {
      return &leaf_;
    }
    divide(leaf_);
  }
  return nullptr;
}

bool TipField::isLeaf(const Target& target) const {
  return target.parts.size() <= kTargetLeafSize || 4.0 * target.square.half <= kSmooth || target.depth == kMaximumDepth;
}

void TipField::addFarBoxes(Target& target) {
  const bool isLast = isLeaf(target);
  const Square& to = target.square;
  std::vector<std::uint32_t> open = std::move(target.boxes);
  target.boxes.clear();
  std::reverse(open.begin(), open.end());
  while (!open.empty()) {
    const std::uint32_t index = open.back();
    open.pop_back();
    const Box& box = boxes_[index];
    const Square& from = box.square;
    // the kernel's singularities, seen from one square for places in the other, are four half sides away
    const double distance = std::max(std::abs(to.x - from.x), std::abs(to.y - from.y));
    const double outsideTo = std::max(distance - to.half, 0.0);
    const double outsideFrom = std::max(distance - from.half, 0.0);
    const bool isFar = outsideTo * outsideTo + kSmooth >= 16.0 * from.half * from.half &&
                       outsideFrom * outsideFrom + kSmooth >= 16.0 * to.half * to.half;
    if (isFar) {
      actOn(target, box);
    } else if (!box.isLeaf && (isLast || from.half >= to.half)) {
      for (std::size_t quarter = 4; quarter-- > 0;) {
        if (box.children[quarter] != 0) {
          open.push_back(box.children[quarter]);
        }
      }
    } else {
      target.boxes.push_back(index);
    }
  }
}

void TipField::actOn(Target& target, const Box& box) {
  const Square& to = target.square;
  if (box.end - box.begin <= kFewPoints) {
    for (std::uint32_t p = box.begin; p < box.end; ++p) {
      for (std::size_t j = 0; j < kNodes; ++j) {
        const double dy = to.y + to.half * chebyshev_[j] - points_[p].y;
        for (std::size_t i = 0; i < kNodes; ++i) {
          target.far[j * kNodes + i] += kernel(to.x + to.half * chebyshev_[i] - points_[p].x, dy);
        }
      }
    }
    return;
  }
  const std::vector<double>& matrix = matrixOf(target, box.square);
  for (std::size_t node = 0; node < kNodeCount; ++node) {
    const double weight = box.weights[node];
    const double* row = matrix.data() + node * kNodeCount;
    for (std::size_t k = 0; k < kNodeCount; ++k) {
      target.far[k] += row[k] * weight;
    }
  }
}

const std::vector<double>& TipField::matrixOf(const Target& target, const Square& from) {
  // squares of one size lie whole sides apart: the same matrices again and again
  const Square& to = target.square;
  const double side = 2.0 * to.half;
  double dx = to.x - from.x;
  double dy = to.y - from.y;
  std::vector<double>* matrix = &other_;
  const double i = std::round(dx / side);
  const double j = std::round(dy / side);
  if (to.half == from.half && std::abs(i) <= kMatrixReach && std::abs(j) <= kMatrixReach) {
    constexpr std::size_t kOffsets = 2 * kMatrixReach + 1;
    auto& ofDepth = matrices_[static_cast<std::size_t>(target.depth)];
    ofDepth.resize(kOffsets * kOffsets);
    matrix =
        &ofDepth[static_cast<std::size_t>(j + kMatrixReach) * kOffsets + static_cast<std::size_t>(i + kMatrixReach)];
    if (!matrix->empty()) {
      return *matrix;
    }
    // not of the rounded places of these two squares, but of any two of this size that far apart
    dx = i * side;
    dy = j * side;
  }
  matrix->resize(kNodeCount * kNodeCount);
  double* value = matrix->data();
  for (std::size_t node = 0; node < kNodeCount; ++node) {
    for (std::size_t k = 0; k < kNodeCount; ++k) {
      *value++ = kernel(dx + to.half * chebyshev_[k % kNodes] - from.half * chebyshev_[node % kNodes],
                        dy + to.half * chebyshev_[k / kNodes] - from.half * chebyshev_[node / kNodes]);
    }
  }
  return *matrix;
}

void TipField::divide(const Target& target) {
  std::array<Target, 4> quarters;
  for (std::size_t quarter = 0; quarter < 4; ++quarter) {
    quarters[quarter].square = quarterOf(target.square, quarter);
    quarters[quarter].depth = target.depth + 1;
  }
  // a part of a centre's places to each quarter
  for (const Part& part : target.parts) {
    const PlanePoint& centre = centres_[part.centre];
    std::uint8_t middleI = part.firstI;
    while (middleI < part.lastI && centre.x + offsets_[middleI] < target.square.x) {
      ++middleI;
    }
    std::uint8_t middleJ = part.firstJ;
    while (middleJ < part.lastJ && centre.y + offsets_[middleJ] < target.square.y) {
      ++middleJ;
    }
    for (std::size_t quarter = 0; quarter < 4; ++quarter) {
      Part piece = part;
      (quarter % 2 == 0 ? piece.lastI : piece.firstI) = middleI;
      (quarter < 2 ? piece.lastJ : piece.firstJ) = middleJ;
      if (piece.firstI < piece.lastI && piece.firstJ < piece.lastJ) {
        quarters[quarter].parts.push_back(piece);
      }
    }
  }
  for (std::size_t quarter = 4; quarter-- > 0;) {
    if (quarters[quarter].parts.empty()) {
      continue;
    }
    // far tips, at the nodes of the quarter
    const Matrix& across = halves_[quarter % 2];
    const Matrix& along = halves_[quarter / 2];
    Expansion rows{};
    for (std::size_t j = 0; j < kNodes; ++j) {
      for (std::size_t i = 0; i < kNodes; ++i) {
        for (std::size_t k = 0; k < kNodes; ++k) {
          rows[j * kNodes + i] += across[i * kNodes + k] * target.far[j * kNodes + k];
        }
      }
    }
    for (std::size_t j = 0; j < kNodes; ++j) {
      for (std::size_t k = 0; k < kNodes; ++k) {
        for (std::size_t i = 0; i < kNodes; ++i) {
          quarters[quarter].far[j * kNodes + i] += along[j * kNodes + k] * rows[k * kNodes + i];
        }
      }
    }
    quarters[quarter].boxes = target.boxes;
    open_.push_back(std::move(quarters[quarter]));
  }
}

void TipField::sumPart(const Leaf& leaf, const Part& part,
                       std::array<double, kMostOffsets * kMostOffsets>& sums) const {
  const PlanePoint& centre = centres_[part.centre];
  const Square& square = leaf.square;
  const auto width = static_cast<std::size_t>(part.lastI - part.firstI);
  const auto height = static_cast<std::size_t>(part.lastJ - part.firstJ);
  const double inverse = square.half > 0.0 ? 1.0 / square.half : 0.0;
  // far tips: along y at the nodes of x, then along x
  std::array<std::array<double, kNodes>, kMostOffsets> across{};
  std::array<double, kMostOffsets> x{};
  for (std::size_t i = 0; i < width; ++i) {
    x[i] = centre.x + offsets_[part.firstI + i];
    across[i] = basisAt((x[i] - square.x) * inverse);
  }
  for (std::size_t j = 0; j < height; ++j) {
    const double y = centre.y + offsets_[part.firstJ + j];
    const auto along = basisAt((y - square.y) * inverse);
    std::array<double, kNodes> row{};
    for (std::size_t k = 0; k < kNodes; ++k) {
      for (std::size_t i = 0; i < kNodes; ++i) {
        row[i] += along[k] * leaf.far[k * kNodes + i];
      }
    }
    double* sum = sums.data() + j * width;
    for (std::size_t i = 0; i < width; ++i) {
      sum[i] = 0.0;
      for (std::size_t k = 0; k < kNodes; ++k) {
        sum[i] += across[i][k] * row[k];
      }
    }
    // near tips, point by point
    for (const std::uint32_t index : leaf.boxes) {
      for (std::uint32_t p = boxes_[index].begin; p < boxes_[index].end; ++p) {
        const double dy = y - points_[p].y;
        for (std::size_t i = 0; i < width; ++i) {
          sum[i] += kernel(x[i] - points_[p].x, dy);
        }
      }
    }
  }
}

}  // namespace espalier::environment
