#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "engine/turtle/environment_process.h"
#include "environment/geometry/disc_tree.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

/// A disc of influence with the values that its query sends.
struct Contender {
  core::Vec3 centre;  // flattened
  double radius = 0.0;
  double second = 0.0;  // group or vigor
};

/// The contender of a query.
[[nodiscard]] inline Contender contenderOf(const turtle::QueryBatch& queries, std::size_t query, Plane plane) {
  const auto parameters = queries.parametersOf(query);
  return {flattened(plane, queries.position[query]), parameters.empty() ? 0.0 : parameters[0],
          parameters.size() < 2 ? 0.0 : parameters[1]};
}

struct ContestRules {
  bool hasVigor = false;         // `second` is a vigor that decides before the radius, instead of a group
  bool isInStringOrder = false;  // with vigor: settle in the order of the contenders instead of the strongest first
};

/// Which contenders are dominated, as docs/environments.md says of `ecosystem`. `overlaps(a, b)` decides for two discs
/// (DiscTree::isOverlapped). O(n log n).
template <typename Overlaps>
[[nodiscard]] std::vector<bool> dominatedOf(std::span<const Contender> all, const ContestRules& rules,
                                            const Overlaps& overlaps) {
  std::vector<bool> isDominated(all.size());
  // vigor, when it counts, then radius
  const auto strengthOf = [&](std::size_t i) { return std::pair(rules.hasVigor ? all[i].second : 0.0, all[i].radius); };
  const auto settle = [&](std::span<const std::size_t> contest) {
    // ranks by strength; equal strengths share one
    struct Strength {
      std::pair<double, double> value;
      std::size_t member;
    };
    std::vector<Strength> strongestFirst(contest.size());
    for (std::size_t member = 0; member < contest.size(); ++member) {
      strongestFirst[member] = {strengthOf(contest[member]), member};
    }
    std::stable_sort(strongestFirst.begin(), strongestFirst.end(),
                     [](const Strength& a, const Strength& b) { return a.value > b.value; });
    std::vector<Disc> discs(contest.size());
    auto rank = static_cast<std::uint32_t>(contest.size());
    for (std::size_t k = 0; k < contest.size(); ++k) {
      const std::size_t member = strongestFirst[k].member;
      if (k > 0 && strongestFirst[k].value != strongestFirst[k - 1].value) {
        --rank;
      }
      discs[member] = {all[contest[member]].centre, all[contest[member]].radius, rank};
    }
    // the dominated ones; with vigor they leave the contest
    DiscTree tree(discs);
    for (std::size_t k = 0; k < contest.size(); ++k) {
      // without vigor no disc is taken out, so the order does not matter
      const std::size_t member = !rules.hasVigor         ? tree.order()[k]
                                 : rules.isInStringOrder ? k
                                                         : strongestFirst[k].member;
      isDominated[contest[member]] =
          tree.isOverlapped(member, discs[member].rank + (rules.hasVigor ? 1U : 0U), overlaps);
      if (isDominated[contest[member]] && rules.hasVigor) {
        tree.remove(member);
      }
    }
  };

  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (rules.hasVigor) {
    settle(order);
    return isDominated;
  }
  // the groups do not compete with each other
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return all[a].second < all[b].second; });
  for (auto begin = order.begin(); begin != order.end();) {
    const auto end =
        std::find_if(begin, order.end(), [&](std::size_t i) { return all[i].second != all[*begin].second; });
    settle(std::span(begin, end));
    begin = end;
  }
  return isDominated;
}

/// Answers every query that has parameters.
inline void answerContest(const turtle::QueryBatch& queries, const std::vector<bool>& isDominated,
                          turtle::ReplyBatch& replies) {
  for (std::size_t query = 0; query < queries.size(); ++query) {
    if (!queries.parametersOf(query).empty()) {
      replies.set(queries, query, 0, isDominated[query] ? 0.0 : 1.0);
    }
  }
}

}  // namespace espalier::environment
