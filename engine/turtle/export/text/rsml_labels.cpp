#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "engine/turtle/export/text/rsml_text.h"

namespace espalier::turtle {

namespace {

/// The pieces of labels that are drawn after a step. Nothing: they are not the lines of the scene.
std::optional<std::vector<RsmlLabels::Piece>> drawnPieces(std::span<const Segment> segments, std::uint64_t step,
                                                          const RsmlLabels& labels) {
  // a turtle comes to a point by lengths and directions
  constexpr double kError = 1e-9;  // of the largest coordinate
  std::vector<RsmlLabels::Piece> pieces;
  double largest = 0.0;
  for (const RsmlLabels::Piece& piece : labels.pieces) {
    const RsmlLabels::Point& point = labels.roots[piece.root].points[piece.point];
    if (point.step <= step) {
      pieces.push_back(piece);
      largest = std::max({largest, std::abs(point.place.x), std::abs(point.place.y), std::abs(point.place.z)});
    }
  }
  if (pieces.size() != segments.size()) {
    return std::nullopt;
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const core::Vec3& place = labels.roots[pieces[i].root].points[pieces[i].point].place;
    if (!(core::length(segments[i].end - place) <= kError * largest)) {
      return std::nullopt;
    }
  }
  return pieces;
}

/// Names of plants or of roots. One without a name has its number, or another number if that is the name of one.
class RsmlNames {
 public:
  template <typename Named>
  explicit RsmlNames(const std::vector<Named>& all) : next_(all.size()) {
    for (const Named& each : all) {
      given_.insert(each.id);
    }
  }

  [[nodiscard]] std::string of(const std::string& id, std::size_t number) {
    if (!id.empty()) {
      return id;
    }
    std::string name = std::to_string(number);
    while (given_.contains(name)) {
      name = std::to_string(next_++);
    }
    return name;
  }

 private:
  std::unordered_set<std::string> given_;
  std::size_t next_;  // a number that is the place of none
};

class LabelledWriter {
 public:
  LabelledWriter(const std::vector<RsmlLabels::Piece>& pieces, std::uint64_t step, const RsmlFacts& facts,
                 core::ByteSink& sink)
      : facts_(facts), labels_(*facts.labels), plantNames_(labels_.plants), rootNames_(labels_.roots), text_(sink) {
    findPoints(pieces, step);
    findDays(pieces);
    laterals_.resize(labels_.roots.size());
    rootsOf_.resize(labels_.plants.size());
    for (std::uint32_t i = 0; i < labels_.roots.size(); ++i) {
      const RsmlLabels::Root& root = labels_.roots[i];
      if (counts_[i] > 0) {
        (root.parent == RsmlLabels::kNone ? rootsOf_[root.plant] : laterals_[root.parent]).push_back(i);
      }
    }
  }

  void write() {
    text_.beginScene(facts_);
    for (std::size_t plant = 0; plant < labels_.plants.size(); ++plant) {
      const bool isLater = rootsOf_[plant].empty() && std::ranges::any_of(labels_.roots, [&](const auto& root) {
                             return root.plant == plant && !root.points.empty();
                           });
      if (isLater) {
        continue;
      }
      text_.beginPlant(plantNames_.of(labels_.plants[plant].id, plant), labels_.plants[plant].label);
      for (const std::uint32_t root : rootsOf_[plant]) {
        writeWithLaterals(root);
      }
      text_.endPlant();
    }
    text_.endScene();
  }

 private:
  /// How many points of each root are there.
  void findPoints(const std::vector<RsmlLabels::Piece>& pieces, std::uint64_t step) {
    std::vector<bool> hasLength(labels_.roots.size(), false);
    std::vector<bool> isDrawn(labels_.roots.size(), false);
    for (const RsmlLabels::Piece& piece : labels_.pieces) {
      hasLength[piece.root] = true;
    }
    for (const RsmlLabels::Piece& piece : pieces) {
      isDrawn[piece.root] = true;
    }
    counts_.resize(labels_.roots.size(), 0);
    // laterals come behind their parents, which are there when a lateral is
    for (std::size_t i = labels_.roots.size(); i-- > 0;) {
      const RsmlLabels::Root& root = labels_.roots[i];
      if (isDrawn[i] || !hasLength[i]) {
        const auto later = std::ranges::find_if(root.points, [&](const auto& point) { return point.step > step; });
        counts_[i] = std::max(counts_[i], static_cast<std::size_t>(later - root.points.begin()));
      }
      if (counts_[i] > 0 && root.parent != RsmlLabels::kNone) {
        counts_[root.parent] = std::max(counts_[root.parent], root.parentNode + 1);
      }
    }
  }

  /// The days of points that have none in the labels: those of the segments that end there.
  void findDays(const std::vector<RsmlLabels::Piece>& pieces) {
    for (const RsmlLabels::Root& root : labels_.roots) {
      hasDays_ = hasDays_ || std::ranges::any_of(root.points, [](const auto& point) { return !std::isnan(point.day); });
    }
    if (hasDays_ || facts_.days.empty()) {
      return;
    }
    for (const RsmlLabels::Root& root : labels_.roots) {
      days_.emplace_back(root.points.size(), std::numeric_limits<double>::quiet_NaN());
    }
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      days_[pieces[i].root][pieces[i].point] = facts_.days[i];
    }
    // a first point is there with the first segment, a point that repeats one with that
    for (std::vector<double>& days : days_) {
      const auto first = std::ranges::find_if(days, [](double day) { return !std::isnan(day); });
      double before = first == days.end() ? std::numeric_limits<double>::quiet_NaN() : *first;
      for (double& day : days) {
        day = std::isnan(day) ? before : day;
        before = day;
      }
    }
  }

  /// Writes the part that belongs to a root alone, without the end of its element.
  void begin(std::uint32_t index) {
    const RsmlLabels::Root& root = labels_.roots[index];
    const bool isLateral = root.parent != RsmlLabels::kNone;
    text_.beginRoot(rootNames_.of(root.id, index), root.label,
                    isLateral ? std::optional(root.parentNode) : std::nullopt);
    std::vector<double> diameters, days;
    for (std::size_t i = 0; i < counts_[index]; ++i) {
      text_.point(root.points[i].place, std::nullopt);
      diameters.push_back(root.points[i].diameter);
      days.push_back(days_.empty() ? root.points[i].day : days_[index][i]);
    }
    text_.endPoints();
    text_.function("diameter", diameters);
    text_.function("emergence_time", days);
    text_.endFunctions();
  }

  /// Laterals of any depth, without recursion.
  void writeWithLaterals(std::uint32_t first) {
    std::vector<std::pair<std::uint32_t, std::size_t>> open{{first, 0}};  // root, and the number of its next lateral
    begin(first);
    while (!open.empty()) {
      auto& [root, next] = open.back();
      if (next == laterals_[root].size()) {
        text_.endRoot();
        open.pop_back();
        continue;
      }
      const std::uint32_t lateral = laterals_[root][next++];
      begin(lateral);
      open.emplace_back(lateral, 0);
    }
  }

  RsmlFacts facts_;
  const RsmlLabels& labels_;
  RsmlNames plantNames_, rootNames_;
  std::vector<std::size_t> counts_;                   // points that are there (roots)
  std::vector<std::vector<std::uint32_t>> laterals_;  // that are there (roots)
  std::vector<std::vector<std::uint32_t>> rootsOf_;   // that are there and no laterals (plants)
  bool hasDays_ = false;                              // the labels know a day at least
  std::vector<std::vector<double>> days_;             // (roots, points), or empty: those of the labels
  RsmlText text_;
};

}  // namespace

bool writeLabelledRsml(std::span<const Segment> segments, std::uint64_t step, const RsmlFacts& facts,
                       core::ByteSink& sink) {
  if (facts.labels == nullptr || facts.labels->roots.empty()) {
    return false;
  }
  const auto pieces = drawnPieces(segments, step, *facts.labels);
  if (!pieces) {
    return false;
  }
  LabelledWriter(*pieces, step, facts, sink).write();
  return true;
}

}  // namespace espalier::turtle
