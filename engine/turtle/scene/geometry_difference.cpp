#include "engine/turtle/scene/geometry_difference.h"

#include <bit>
#include <cstring>
#include <unordered_map>
#include <utility>

#include "engine/turtle/scene/meeting_place.h"

namespace espalier::turtle {
namespace {

using core::Vec3;

/// A quick hash of a row's content.
class RowHash {
 public:
  void add(std::uint64_t value) {
    value_ = (value_ ^ value) * 0x9E3779B97F4A7C15ULL;
    value_ ^= value_ >> 29U;
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(const Vec3& v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  void add(const GeometrySources& sources, std::size_t row) {
    add(std::uint64_t{sources.plant[row]} << 32U | std::uint64_t{sources.symbol[row]} << 8U | sources.colour[row]);
    add(std::uint64_t{sources.branchOrder[row]});
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0x243F6A8885A308D3ULL;
};

bool isSame(const GeometrySources& a, std::size_t i, const GeometrySources& b, std::size_t j) {
  return a.plant[i] == b.plant[j] && a.symbol[i] == b.symbol[j] && a.colour[i] == b.colour[j] &&
         a.branchOrder[i] == b.branchOrder[j];
}

// bits, not values: -0 is not 0
template <typename T>
bool isSame(const std::vector<T>& a, std::uint64_t i, const std::vector<T>& b, std::uint64_t j,
            std::uint64_t count = 1) {
  return count == 0 || std::memcmp(a.data() + i, b.data() + j, count * sizeof(T)) == 0;
}

/// The table of segments.
struct Segments {
  static const GeometrySources& sources(const Geometry& geometry) { return geometry.segments; }
  static std::uint64_t hash(const Geometry& geometry, std::size_t row) {
    RowHash hash;
    hash.add(geometry.segments, row);
    hash.add(geometry.start[row]);
    hash.add(geometry.end[row]);
    hash.add(geometry.startWidth[row]);
    hash.add(geometry.endWidth[row]);
    return hash.value();
  }
  static bool equal(const Geometry& a, std::size_t i, const Geometry& b, std::size_t j) {
    return isSame(a.segments, i, b.segments, j) && isSame(a.start, i, b.start, j) && isSame(a.end, i, b.end, j) &&
           isSame(a.startWidth, i, b.startWidth, j) && isSame(a.endWidth, i, b.endWidth, j);
  }
  static void append(const Geometry& from, std::size_t row, Geometry& to) {
    to.start.push_back(from.start[row]);
    to.end.push_back(from.end[row]);
    to.startWidth.push_back(from.startWidth[row]);
    to.endWidth.push_back(from.endWidth[row]);
  }
  static GeometrySources& sources(Geometry& geometry) { return geometry.segments; }
};

/// The table of organs.
struct Organs {
  static const GeometrySources& sources(const Geometry& geometry) { return geometry.organs; }
  static GeometrySources& sources(Geometry& geometry) { return geometry.organs; }
  static std::uint64_t hash(const Geometry& geometry, std::size_t row) {
    RowHash hash;
    hash.add(geometry.organs, row);
    hash.add(static_cast<std::uint64_t>(geometry.kind[row]));
    hash.add(geometry.triangleOffset[row + 1] - geometry.triangleOffset[row]);
    for (std::uint64_t v = geometry.vertexOffset[row]; v < geometry.vertexOffset[row + 1]; ++v) {
      hash.add(geometry.vertices[v]);
    }
    return hash.value();
  }
  static bool equal(const Geometry& a, std::size_t i, const Geometry& b, std::size_t j) {
    const std::uint64_t vertexCount = a.vertexOffset[i + 1] - a.vertexOffset[i];
    const std::uint64_t triangleCount = a.triangleOffset[i + 1] - a.triangleOffset[i];
    if (!isSame(a.organs, i, b.organs, j) || a.kind[i] != b.kind[j] ||
        vertexCount != b.vertexOffset[j + 1] - b.vertexOffset[j] ||
        triangleCount != b.triangleOffset[j + 1] - b.triangleOffset[j] ||
        !isSame(a.vertices, a.vertexOffset[i], b.vertices, b.vertexOffset[j], vertexCount)) {
      return false;
    }
    for (std::uint64_t t = 0; t < triangleCount; ++t) {
      for (std::size_t corner = 0; corner < 3; ++corner) {
        if (a.triangles[a.triangleOffset[i] + t][corner] - a.vertexOffset[i] !=
            b.triangles[b.triangleOffset[j] + t][corner] - b.vertexOffset[j]) {
          return false;
        }
      }
    }
    return true;
  }
  static void append(const Geometry& from, std::size_t row, Geometry& to) {
    to.kind.push_back(from.kind[row]);
    const std::uint64_t before = from.vertexOffset[row];
    const std::uint64_t after = to.vertices.size();
    to.vertices.insert(to.vertices.end(), from.vertices.begin() + static_cast<std::ptrdiff_t>(before),
                       from.vertices.begin() + static_cast<std::ptrdiff_t>(from.vertexOffset[row + 1]));
    for (std::uint64_t t = from.triangleOffset[row]; t < from.triangleOffset[row + 1]; ++t) {
      auto triangle = from.triangles[t];
      for (std::uint32_t& corner : triangle) {
        corner = static_cast<std::uint32_t>(corner - before + after);
      }
      to.triangles.push_back(triangle);
    }
    to.vertexOffset.push_back(to.vertices.size());
    to.triangleOffset.push_back(to.triangles.size());
  }
};

template <typename Table>
void appendRow(const Geometry& from, std::size_t row, std::uint64_t moduleShift, Geometry& to) {
  const GeometrySources& sources = Table::sources(from);
  GeometrySources& added = Table::sources(to);
  added.plant.push_back(sources.plant[row]);
  added.module.push_back(sources.module[row] + moduleShift);
  added.symbol.push_back(sources.symbol[row]);
  added.colour.push_back(sources.colour[row]);
  added.branchOrder.push_back(sources.branchOrder[row]);
  Table::append(from, row, to);
}

void extend(std::vector<GeometryRun>& runs, std::uint32_t row, std::uint64_t moduleShift) {
  if (!runs.empty()) {
    GeometryRun& last = runs.back();
    const bool isNext = row == GeometryRun::kNew ? last.first == GeometryRun::kNew
                                                 : last.first != GeometryRun::kNew && last.first + last.count == row &&
                                                       last.moduleShift == moduleShift;
    if (isNext) {
      ++last.count;
      return;
    }
  }
  runs.push_back({row, 1, moduleShift});
}

// rows added or taken away that are looked for, where two tables part, before all rows are searched
constexpr std::size_t kAddedRows = 64;

/// Rows of a table by their hashes. Each row is taken once; rows with equal hashes are taken in their order.
template <typename Table>
class RowFinder {
 public:
  explicit RowFinder(const Geometry& geometry)
      : geometry_(geometry), isTaken_(Table::sources(geometry).size(), false) {}

  [[nodiscard]] bool isNext(std::uint32_t row, const Geometry& other, std::size_t otherRow) const {
    return row < isTaken_.size() && !isTaken_[row] && Table::equal(geometry_, row, other, otherRow);
  }
  void take(std::uint32_t row) {
    isTaken_[row] = true;
    ++takenCount_;
  }
  [[nodiscard]] bool hasSearched() const { return !next_.empty(); }

  /// Some row that looks like `row` of `other`; kNew: there is none left.
  [[nodiscard]] std::uint32_t find(const Geometry& other, std::size_t row) {
    if (takenCount_ == isTaken_.size()) {
      return GeometryRun::kNew;
    }
    if (!hasSearched()) {
      buildTable();
    }
    const auto entry = firstOf_.find(Table::hash(other, row));
    if (entry == firstOf_.end()) {
      return GeometryRun::kNew;
    }
    while (entry->second != kEnd && isTaken_[entry->second]) {
      entry->second = next_[entry->second];
    }
    for (std::uint32_t found = entry->second; found != kEnd; found = next_[found]) {
      if (!isTaken_[found] && Table::equal(geometry_, found, other, row)) {
        return found;
      }
    }
    return GeometryRun::kNew;
  }

 private:
  static constexpr std::uint32_t kEnd = std::numeric_limits<std::uint32_t>::max();

  void buildTable() {
    const auto count = static_cast<std::uint32_t>(isTaken_.size());
    next_.assign(count + std::size_t{1}, kEnd);
    firstOf_.reserve(count);
    // from the last to the first, so that each list begins with its first row
    for (std::uint32_t row = count; row-- > 0;) {
      const auto [entry, isNew] = firstOf_.try_emplace(Table::hash(geometry_, row), row);
      if (!isNew) {
        next_[row] = entry->second;
        entry->second = row;
      }
    }
  }

  const Geometry& geometry_;
  std::vector<bool> isTaken_;
  std::size_t takenCount_ = 0;
  std::vector<std::uint32_t> next_;  // of equal hash, kEnd: none; one more; empty: nothing was searched so far
  std::unordered_map<std::uint64_t, std::uint32_t> firstOf_;
};

template <typename Table>
void compare(const Geometry& before, const Geometry& now, std::vector<GeometryRun>& runs, Geometry& added) {
  RowFinder<Table> finder(before);
  const GeometrySources& sourcesBefore = Table::sources(before);
  const GeometrySources& sources = Table::sources(now);
  std::uint32_t expected = 0;
  for (std::size_t row = 0; row < sources.size(); ++row) {
    std::uint32_t found = expected;
    if (!finder.isNext(expected, now, row)) {
      // a few rows were added, changed or taken away; else it may be anywhere
      const auto isAlike = [&](std::size_t gone, std::size_t come) {
        return row + come < sources.size() &&
               finder.isNext(expected + static_cast<std::uint32_t>(gone), now, row + come);
      };
      const bool mayBeNear = expected < sourcesBefore.size() && !finder.hasSearched();
      const auto place = mayBeNear ? meetingPlace(kAddedRows, isAlike) : std::nullopt;
      for (std::size_t i = 0; place && i < place->second; ++i, ++row) {
        appendRow<Table>(now, row, 0, added);
        extend(runs, GeometryRun::kNew, 0);
      }
      found = place ? expected + static_cast<std::uint32_t>(place->first) : finder.find(now, row);
    }
    if (found == GeometryRun::kNew) {
      appendRow<Table>(now, row, 0, added);
      extend(runs, found, 0);
    } else {
      finder.take(found);
      extend(runs, found, sources.module[row] - sourcesBefore.module[found]);
      expected = found + 1;
    }
  }
}

template <typename Table>
std::optional<std::string> rebuild(const char* name, const Geometry& before, const std::vector<GeometryRun>& runs,
                                   const Geometry& added, Geometry& now) {
  const std::size_t rowsBefore = Table::sources(before).size();
  const std::size_t rowsAdded = Table::sources(added).size();
  std::size_t nextAdded = 0;
  std::uint64_t total = 0;
  for (const GeometryRun& run : runs) {
    // each row is used once: a peer's difference cannot grow without end
    total += run.count;
    if (total > rowsBefore + rowsAdded) {
      return std::string("the runs of ") + name + " take more rows than the " + std::to_string(rowsBefore) +
             " before and the " + std::to_string(rowsAdded) + " new ones";
    }
    const bool isNew = run.first == GeometryRun::kNew;
    const std::uint64_t first = isNew ? nextAdded : run.first;
    const std::uint64_t rows = isNew ? rowsAdded : rowsBefore;
    if (first + run.count > rows) {
      return std::string("a run of ") + name + " takes rows " + std::to_string(first) + " to " +
             std::to_string(first + run.count) + " of " + (isNew ? "the new ones" : "those before") +
             ", of which there are " + std::to_string(rows);
    }
    for (std::uint64_t row = first; row < first + run.count; ++row) {
      appendRow<Table>(isNew ? added : before, row, isNew ? 0 : run.moduleShift, now);
    }
    nextAdded += isNew ? run.count : 0;
  }
  if (nextAdded != rowsAdded) {
    return std::string("the runs of ") + name + " take " + std::to_string(nextAdded) + " new rows, but " +
           std::to_string(rowsAdded) + " came";
  }
  return std::nullopt;
}

}  // namespace

GeometryDifference differenceOf(const Geometry& before, const Geometry& now) {
  GeometryDifference difference;
  difference.added.areWidthsPixels = now.areWidthsPixels;
  compare<Segments>(before, now, difference.segments, difference.added);
  compare<Organs>(before, now, difference.organs, difference.added);
  return difference;
}

std::optional<std::string> applyDifference(const Geometry& before, const GeometryDifference& difference,
                                           Geometry& now) {
  now = {};
  now.areWidthsPixels = difference.added.areWidthsPixels;
  if (auto problem = rebuild<Segments>("segments", before, difference.segments, difference.added, now)) {
    return problem;
  }
  return rebuild<Organs>("organs", before, difference.organs, difference.added, now);
}

}  // namespace espalier::turtle
