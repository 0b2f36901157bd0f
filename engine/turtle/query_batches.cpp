#include "engine/turtle/query_batches.h"

#include <algorithm>

namespace espalier::turtle {

namespace {

template <typename T>
void selectItems(const std::vector<T>& whole, std::span<const std::size_t> chosen, std::vector<T>& part) {
  part.clear();
  if (whole.empty()) {
    return;
  }
  part.reserve(chosen.size());
  for (const std::size_t query : chosen) {
    part.push_back(whole[query]);
  }
}

}  // namespace

void selectQueries(const QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                   QueryBatch& part) {
  part.step = whole.step;
  part.iteration = whole.iteration;
  part.timeDays = whole.timeDays;
  part.geometry = whole.geometry;
  selectItems(whole.plant, chosen, part.plant);
  selectItems(whole.module, chosen, part.module);
  selectItems(whole.symbol, chosen, part.symbol);
  selectItems(whole.isTransient, chosen, part.isTransient);
  selectItems(whole.position, chosen, part.position);
  selectItems(whole.heading, chosen, part.heading);
  selectItems(whole.left, chosen, part.left);
  selectItems(whole.up, chosen, part.up);
  selectItems(whole.width, chosen, part.width);
  selectItems(whole.scale, chosen, part.scale);
  selectItems(whole.following, chosen, part.following);
  selectItems(whole.followingPair, chosen, part.followingPair);

  // parameters; their values may be absent when no process reads them, the offsets never are
  part.parameterOffset.assign(1, 0);
  part.parameters.clear();
  for (const std::size_t query : chosen) {
    const std::uint64_t end = whole.parameterOffset[query + 1];
    const std::uint64_t begin = std::min<std::uint64_t>(whole.parameterOffset[query] + firstParameter, end);
    part.parameterOffset.push_back(part.parameterOffset.back() + (end - begin));
    if (!whole.parameters.empty()) {
      part.parameters.insert(part.parameters.end(), whole.parameters.begin() + static_cast<std::ptrdiff_t>(begin),
                             whole.parameters.begin() + static_cast<std::ptrdiff_t>(end));
    }
  }

  part.followingOffset.assign(1, 0);
  part.followingParameters.clear();
  if (whole.followingOffset.size() == whole.size() + 1) {
    for (const std::size_t query : chosen) {
      const auto parameters = whole.followingParametersOf(query);
      part.followingParameters.insert(part.followingParameters.end(), parameters.begin(), parameters.end());
      part.followingOffset.push_back(part.followingParameters.size());
    }
  }
}

void mergeReplies(const QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                  const QueryBatch& part, const ReplyBatch& partReplies, ReplyBatch& wholeReplies) {
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const std::uint64_t target = whole.parameterOffset[chosen[i]] + firstParameter;
    const std::uint64_t begin = part.parameterOffset[i];
    for (std::uint64_t k = begin; k < part.parameterOffset[i + 1]; ++k) {
      wholeReplies.values[target + (k - begin)] = partReplies.values[k];
      wholeReplies.isSet[target + (k - begin)] = partReplies.isSet[k];
    }
  }
  wholeReplies.answeredCount += partReplies.answeredCount;
  wholeReplies.surplusCount += partReplies.surplusCount;
  wholeReplies.notes.insert(wholeReplies.notes.end(), partReplies.notes.begin(), partReplies.notes.end());
}

}  // namespace espalier::turtle
