#include "clients/espalier/sweep/designs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>

#include "engine/core/random.h"

namespace espalier::command {
namespace {

constexpr std::size_t kSobolBits = 32;
constexpr std::uint64_t kMostValues = 1'000'000'000;

/// A primitive polynomial over GF(2) and the first direction numbers of one column.
struct SobolColumn {
  std::uint32_t degree;
  std::uint32_t polynomial;  // its inner coefficients
  std::array<std::uint32_t, 13> first;
};

// columns 2, 3, ...
constexpr SobolColumn kSobolTable[] = {
#include "clients/espalier/sweep/sobol_numbers.inc"
};
static_assert(std::size(kSobolTable) + 1 == kSobolColumns);

// the direction numbers of a column, as fractions of 2^32
std::array<std::uint32_t, kSobolBits> directionNumbers(std::size_t column) {
  std::array<std::uint32_t, kSobolBits> v{};
  if (column == 0) {
    for (std::size_t bit = 0; bit < kSobolBits; ++bit) {
      v[bit] = 1U << (kSobolBits - 1 - bit);
    }
    return v;
  }
  const SobolColumn& row = kSobolTable[column - 1];
  const std::size_t s = row.degree;
  for (std::size_t bit = 0; bit < kSobolBits; ++bit) {
    if (bit < s) {
      v[bit] = row.first[bit] << (kSobolBits - 1 - bit);
      continue;
    }
    v[bit] = v[bit - s] ^ (v[bit - s] >> s);
    for (std::size_t k = 1; k < s; ++k) {
      v[bit] ^= ((row.polynomial >> (s - 1 - k)) & 1U) * v[bit - k];
    }
  }
  return v;
}

/// Random numbers of a design: draw `index` of one of its parts.
class DesignRandom {
 public:
  explicit DesignRandom(std::uint64_t seed) : random_(seed, 0) {}
  [[nodiscard]] double operator()(std::uint32_t part, std::uint64_t index) const {
    return random_.uniform(core::DrawDomain::Environment, part, index, 0);
  }
  /// A random order of 0 ... count - 1.
  [[nodiscard]] std::vector<std::uint64_t> order(std::uint32_t part, std::uint64_t count) const {
    std::vector<std::uint64_t> order(count);
    std::iota(order.begin(), order.end(), std::uint64_t{0});
    for (std::uint64_t i = count; i > 1; --i) {
      const auto other = static_cast<std::uint64_t>((*this)(part, i) * static_cast<double>(i));
      std::swap(order[i - 1], order[std::min(other, i - 1)]);
    }
    return order;
  }

 private:
  core::CounterRandom random_;
};

// inside (0, 1), because the quantile of 0 may be infinite
double inside(double u) {
  return std::max(u, 0x1.0p-54);
}

Result<DesignPoints> gridValues(const Design& design, const std::vector<SweepParameter>& parameters) {
  std::vector<std::vector<double>> axes;
  double count = 1.0;
  for (const SweepParameter& parameter : parameters) {
    using Kind = Distribution::Kind;
    const Distribution& distribution = parameter.distribution;
    std::vector<double>& axis = axes.emplace_back();
    if (distribution.kind == Kind::Discrete) {
      axis = distribution.values;
    } else if (distribution.kind == Kind::Integer) {
      count *= distribution.second - distribution.first + 1.0;
      for (double value = distribution.first; value <= distribution.second && count < 1e9; ++value) {
        axis.push_back(value);
      }
      continue;
    } else {
      const auto levels = static_cast<double>(design.levels);
      for (std::uint64_t i = 0; i < design.levels; ++i) {
        const auto place = static_cast<double>(i);
        axis.push_back(
            distribution.quantile(distribution.kind == Kind::Normal ? (place + 0.5) / levels : place / (levels - 1.0)));
      }
    }
    count *= static_cast<double>(axis.size());
  }
  if (count * static_cast<double>(parameters.size()) > static_cast<double>(kMostValues)) {
    return problem("the grid has more than " + std::to_string(kMostValues / parameters.size()) +
                   " points: give fewer levels, or a latin-hypercube");
  }
  DesignPoints points{.columns = axes.size()};
  std::vector<std::size_t> place(axes.size());
  while (true) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      points.values.push_back(axes[i][place[i]]);
    }
    // the last parameter changes fastest
    std::size_t digit = axes.size();
    while (digit > 0 && ++place[digit - 1] == axes[digit - 1].size()) {
      place[--digit] = 0;
    }
    if (digit == 0) {
      return points;
    }
  }
}

}  // namespace

DesignPoints sobolPoints(std::uint64_t count, std::size_t columns, std::optional<std::uint64_t> shift) {
  DesignPoints points{.columns = columns, .values = std::vector<double>(count * columns)};
  for (std::size_t column = 0; column < columns; ++column) {
    const std::array<std::uint32_t, kSobolBits> v = directionNumbers(column);
    std::uint32_t x = 0;
    std::uint32_t mask = 0;
    if (shift) {
      mask = static_cast<std::uint32_t>(DesignRandom(*shift)(0, column) * 0x1.0p32);
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i > 0) {
        // the lowest 0 bit of i - 1
        std::size_t bit = 0;
        for (std::uint64_t rest = i - 1; (rest & 1U) != 0; rest >>= 1U) {
          ++bit;
        }
        x ^= v[bit];
      }
      points.values[i * columns + column] = (static_cast<double>(x ^ mask) + 0.5) * 0x1.0p-32;
    }
  }
  return points;
}

DesignPoints latinHypercube(std::uint64_t count, std::size_t columns, std::uint64_t seed) {
  DesignPoints points{.columns = columns, .values = std::vector<double>(count * columns)};
  const DesignRandom random(seed);
  for (std::size_t column = 0; column < columns; ++column) {
    const auto part = static_cast<std::uint32_t>(2 * column);
    const std::vector<std::uint64_t> order = random.order(part, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const double place = static_cast<double>(order[i]) + random(part + 1, i);
      points.values[i * columns + column] = inside(place / static_cast<double>(count));
    }
  }
  return points;
}

DesignPoints randomPoints(std::uint64_t count, std::size_t columns, std::uint64_t seed) {
  DesignPoints points{.columns = columns, .values = std::vector<double>(count * columns)};
  const DesignRandom random(seed);
  for (std::uint64_t i = 0; i < points.values.size(); ++i) {
    points.values[i] = inside(random(static_cast<std::uint32_t>(i % columns), i / columns));
  }
  return points;
}

DesignPoints saltelliPoints(std::uint64_t count, std::size_t columns, std::optional<std::uint64_t> shift) {
  const DesignPoints pairs = sobolPoints(count, 2 * columns, shift);
  DesignPoints points{.columns = columns};
  points.values.reserve(count * (columns + 2) * columns);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::span<const double> a(pairs.values.data() + i * 2 * columns, columns);
    const std::span<const double> b(a.data() + columns, columns);
    points.values.insert(points.values.end(), a.begin(), a.end());
    for (std::size_t column = 0; column < columns; ++column) {
      points.values.insert(points.values.end(), a.begin(), a.end());
      *(points.values.end() - static_cast<std::ptrdiff_t>(columns - column)) = b[column];
    }
    points.values.insert(points.values.end(), b.begin(), b.end());
  }
  return points;
}

DesignPoints morrisPoints(std::uint64_t trajectories, std::size_t columns, std::uint64_t levels, std::uint64_t seed) {
  DesignPoints points{.columns = columns};
  const DesignRandom random(seed);
  const auto last = static_cast<double>(levels - 1);
  const std::uint64_t jump = levels / 2;
  for (std::uint64_t walk = 0; walk < trajectories; ++walk) {
    const auto part = static_cast<std::uint32_t>(3 * walk);
    // a start among the lower half of the levels, and the direction in which each column moves
    std::vector<std::uint64_t> level(columns);
    std::vector<bool> goesUp(columns);
    for (std::size_t column = 0; column < columns; ++column) {
      const double u = random(part, column) * static_cast<double>(levels - jump);
      goesUp[column] = random(part + 1, column) < 0.5;
      level[column] = std::min(static_cast<std::uint64_t>(u), levels - jump - 1) + (goesUp[column] ? 0 : jump);
    }
    const auto add = [&] {
      for (const std::uint64_t place : level) {
        points.values.push_back(static_cast<double>(place) / last);
      }
    };
    add();
    for (const std::uint64_t column : random.order(part + 2, columns)) {
      level[column] = goesUp[column] ? level[column] + jump : level[column] - jump;
      add();
    }
  }
  return points;
}

Result<DesignPoints> designValues(const Design& design, const std::vector<SweepParameter>& parameters) {
  using Kind = Design::Kind;
  const std::size_t columns = parameters.size();
  if (design.kind == Kind::Single) {
    return DesignPoints{};
  }
  if (columns == 0) {
    return problem("a design needs parameters: give 'parameters' with their distributions");
  }
  for (const SweepParameter& parameter : parameters) {
    if (parameter.distribution.kind == Distribution::Kind::None) {
      return problem("parameters." + parameter.name +
                     ": a design needs a distribution: give uniform, log, normal, integer or discrete");
    }
  }
  if (design.kind == Kind::Grid) {
    return gridValues(design, parameters);
  }
  const bool isSaltelli = design.kind == Kind::Saltelli;
  const std::uint64_t rows = design.kind == Kind::Morris ? columns + 1 : isSaltelli ? columns + 2 : 1;
  if (design.count > kMostValues / rows / columns) {
    return problem("the design has more than " + std::to_string(kMostValues) + " values: give fewer points");
  }
  if ((isSaltelli || design.kind == Kind::Sobol) && columns * (isSaltelli ? 2 : 1) > kSobolColumns) {
    return problem("Sobol' points have at most " + std::to_string(kSobolColumns) +
                   " columns, and the design of Saltelli needs two for each parameter: give fewer parameters, or a "
                   "latin-hypercube");
  }
  DesignPoints points;
  switch (design.kind) {
    case Kind::Random:
      points = randomPoints(design.count, columns, design.seed);
      break;
    case Kind::LatinHypercube:
      points = latinHypercube(design.count, columns, design.seed);
      break;
    case Kind::Sobol:
      points = sobolPoints(design.count, columns, design.shift);
      break;
    case Kind::Saltelli:
      points = saltelliPoints(design.count, columns, design.shift);
      break;
    default:
      points = morrisPoints(design.count, columns, design.levels, design.seed);
  }
  const auto levels = static_cast<double>(design.levels);
  for (std::size_t i = 0; i < points.values.size(); ++i) {
    const Distribution& distribution = parameters[i % columns].distribution;
    double u = points.values[i];
    if (design.kind == Kind::Morris && distribution.kind == Distribution::Kind::Normal) {
      // a normal distribution has no first and last level: the middles of equal parts
      u = (u * (levels - 1.0) + 0.5) / levels;
    }
    points.values[i] = distribution.quantile(u);
  }
  return points;
}

}  // namespace espalier::command
