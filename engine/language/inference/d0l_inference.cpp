#include "engine/language/inference/d0l_inference.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <tuple>
#include <utility>

#include "engine/language/inference/length_equations.h"

namespace espalier::language {
namespace {

using String = std::vector<std::uint16_t>;

// a part of a string that became a symbol's successor
using Part = std::span<const std::uint16_t>;

// the part of one step that is not yet explained: from[first..last) became to[nextFirst..nextLast)
struct Window {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t nextFirst = 0;
  std::size_t nextLast = 0;
  std::vector<std::size_t> counts;  // occurrences in from[first..last), by symbol

  [[nodiscard]] std::size_t nextLength() const { return nextLast - nextFirst; }
};

struct State {
  std::vector<std::optional<Part>> successors;  // by symbol
  std::vector<std::size_t> least;               // bounds of their lengths, by symbol
  std::vector<std::size_t> most;
  std::vector<Window> windows;  // by step
};

std::vector<std::size_t> countSymbols(Part string, std::size_t symbolCount) {
  std::vector<std::size_t> counts(symbolCount);
  for (const std::uint16_t symbol : string) {
    ++counts[symbol];
  }
  return counts;
}

class Search {
 public:
  Search(const StepStrings& steps, std::size_t stringCount, const InferenceOptions& options)
      : strings_(steps.strings.data(), stringCount), names_(steps.names), options_(options) {
    for (const String& string : strings_) {
      counts_.push_back(countSymbols(string, names_.size()));
    }
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      const bool isBracket = names_[symbol] == "[" || names_[symbol] == "]";
      isConstant_.push_back((options.isBracketed && isBracket) ||
                            std::count(options.constants.begin(), options.constants.end(), symbol) > 0);
    }
  }

  // false: the search was stopped
  bool run() {
    State state;
    if (begin(state)) {
      explore(std::move(state));
    }
    return !isGivenUp_;
  }

  [[nodiscard]] bool hasReachedLimit() const { return systems_.size() >= options_.systemLimit; }
  std::vector<D0lSystem> takeSystems() { return std::move(systems_); }

 private:
  [[nodiscard]] std::size_t stepCount() const { return strings_.size() - 1; }

  // the state before the search; false: a contradiction already
  bool begin(State& state) {
    const std::size_t symbolCount = names_.size();
    state.successors.resize(symbolCount);
    state.least.assign(symbolCount, options_.mayErase ? 0 : 1);
    state.most.assign(symbolCount, std::numeric_limits<std::size_t>::max());
    for (std::size_t step = 0; step < stepCount(); ++step) {
      state.windows.push_back({0, strings_[step].size(), 0, strings_[step + 1].size(), counts_[step]});
    }
    return boundByLetters(state) && solveEquations(state) && fixConstants(state) && propagate(state);
  }

  // no symbol makes more of a letter than the next string has, divided by the symbol's occurrences
  bool boundByLetters(State& state) const {
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      std::vector<std::size_t> most(names_.size(), std::numeric_limits<std::size_t>::max());
      bool occurs = false;
      for (std::size_t step = 0; step < stepCount(); ++step) {
        const std::size_t count = counts_[step][symbol];
        if (count == 0) {
          continue;
        }
        occurs = true;
        for (std::size_t letter = 0; letter < names_.size(); ++letter) {
          most[letter] = std::min(most[letter], counts_[step + 1][letter] / count);
        }
      }
      if (occurs) {
        state.most[symbol] = 0;
        for (const std::size_t count : most) {
          state.most[symbol] += count;
        }
        if (state.most[symbol] < state.least[symbol]) {
          return false;
        }
      }
    }
    return true;
  }

  bool solveEquations(State& state) const {
    std::vector<std::vector<std::uint64_t>> coefficients;
    std::vector<std::uint64_t> right;
    for (std::size_t step = 0; step < stepCount(); ++step) {
      coefficients.emplace_back(counts_[step].begin(), counts_[step].end());
      right.push_back(strings_[step + 1].size());
    }
    const SolvedLengths solved = solveLengths(coefficients, right);
    if (solved.isContradiction) {
      return false;
    }
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      if (const auto length = solved.values[symbol]) {
        if (*length < state.least[symbol] || *length > state.most[symbol]) {
          return false;
        }
        state.least[symbol] = state.most[symbol] = static_cast<std::size_t>(*length);
      }
    }
    return true;
  }

  bool fixConstants(State& state) const {
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      if (!isConstant_[symbol]) {
        continue;
      }
      for (const String& string : strings_) {
        const auto at = std::find(string.begin(), string.end(), symbol);
        if (at != string.end()) {
          if (!assign(state, symbol, Part(&*at, 1))) {
            return false;
          }
          break;
        }
      }
    }
    return true;
  }

  [[nodiscard]] bool isBalanced(Part part) const {
    std::ptrdiff_t depth = 0;
    for (const std::uint16_t symbol : part) {
      depth += names_[symbol] == "[" ? 1 : names_[symbol] == "]" ? -1 : 0;
      if (depth < 0) {
        return false;
      }
    }
    return depth == 0;
  }

  // makes `part` the successor of a symbol; false: it cannot be
  bool assign(State& state, std::size_t symbol, Part part) const {
    if (part.size() < state.least[symbol] || part.size() > state.most[symbol]) {
      return false;
    }
    if (options_.isBracketed && !isConstant_[symbol] && !isBalanced(part)) {
      return false;
    }
    // the next strings have letters enough
    for (std::size_t step = 0; step < stepCount(); ++step) {
      const std::size_t count = counts_[step][symbol];
      if (count > 0) {
        for (const std::uint16_t letter : part) {
          if (counts_[step + 1][letter] < count) {
            return false;
          }
        }
      }
    }
    state.successors[symbol] = part;
    state.least[symbol] = state.most[symbol] = part.size();
    return true;
  }

  // draws every conclusion that needs no guess; false: a contradiction
  bool propagate(State& state) {
    bool hasChanged = true;
    while (hasChanged) {
      hasChanged = false;
      for (std::size_t step = 0; step < stepCount(); ++step) {
        if (!consume(state, step) || !narrow(state, step, hasChanged)) {
          return false;
        }
      }
      if (!fixEnds(state, hasChanged)) {
        return false;
      }
    }
    return true;
  }

  // removes symbols with known successors from both ends of a window
  bool consume(State& state, std::size_t step) {
    Window& window = state.windows[step];
    const String& from = strings_[step];
    const String& to = strings_[step + 1];
    while (window.first < window.last && state.successors[from[window.first]]) {
      const std::uint16_t symbol = from[window.first];
      const Part part = *state.successors[symbol];
      if (window.nextLength() < part.size() ||
          !std::equal(part.begin(), part.end(), to.begin() + static_cast<std::ptrdiff_t>(window.nextFirst))) {
        return false;
      }
      window.nextFirst += part.size();
      ++window.first;
      --window.counts[symbol];
      work_ += part.size() + 1;
    }
    while (window.first < window.last && state.successors[from[window.last - 1]]) {
      const std::uint16_t symbol = from[window.last - 1];
      const Part part = *state.successors[symbol];
      if (window.nextLength() < part.size() ||
          !std::equal(part.begin(), part.end(),
                      to.begin() + static_cast<std::ptrdiff_t>(window.nextLast - part.size()))) {
        return false;
      }
      window.nextLast -= part.size();
      --window.last;
      --window.counts[symbol];
      work_ += part.size() + 1;
    }
    return window.first < window.last || window.nextLength() == 0;
  }

  // bounds the lengths of a window's symbols by what the others need and can be at most
  bool narrow(State& state, std::size_t step, bool& hasChanged) {
    const Window& window = state.windows[step];
    const std::size_t total = window.nextLength();
    std::size_t least = 0;
    std::size_t most = 0;
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      if (const std::size_t count = window.counts[symbol]) {
        least += count * std::min(state.least[symbol], total + 1);
        most += count * std::min(state.most[symbol], total + 1);
      }
    }
    if (least > total || most < total) {
      return false;
    }
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      const std::size_t count = window.counts[symbol];
      if (count == 0) {
        continue;
      }
      const std::size_t othersLeast = least - count * std::min(state.least[symbol], total + 1);
      const std::size_t othersMost = most - count * std::min(state.most[symbol], total + 1);
      const std::size_t upper = (total - othersLeast) / count;
      const std::size_t lower = othersMost >= total ? 0 : (total - othersMost + count - 1) / count;
      if (upper < state.most[symbol] || lower > state.least[symbol]) {
        state.most[symbol] = std::min(state.most[symbol], upper);
        state.least[symbol] = std::max(state.least[symbol], lower);
        hasChanged = true;
        if (state.least[symbol] > state.most[symbol]) {
          return false;
        }
        // the sums above are now too wide: the next round narrows them
      }
    }
    work_ += names_.size();
    return true;
  }

  // a symbol of known length at an end of a window has a known successor
  bool fixEnds(State& state, bool& hasChanged) {
    for (std::size_t step = 0; step < stepCount(); ++step) {
      const Window& window = state.windows[step];
      if (window.first == window.last) {
        continue;
      }
      const std::uint16_t front = strings_[step][window.first];
      const std::uint16_t back = strings_[step][window.last - 1];
      if (!state.successors[front] && state.least[front] == state.most[front]) {
        if (!assignFront(state, step, state.least[front])) {
          return false;
        }
        hasChanged = true;
      } else if (!state.successors[back] && state.least[back] == state.most[back]) {
        if (!assignBack(state, step, state.least[back])) {
          return false;
        }
        hasChanged = true;
      }
    }
    return true;
  }

  bool assignFront(State& state, std::size_t step, std::size_t length) const {
    const Window& window = state.windows[step];
    return length <= window.nextLength() &&
           assign(state, strings_[step][window.first], Part(strings_[step + 1]).subspan(window.nextFirst, length));
  }

  bool assignBack(State& state, std::size_t step, std::size_t length) const {
    const Window& window = state.windows[step];
    return length <= window.nextLength() && assign(state, strings_[step][window.last - 1],
                                                   Part(strings_[step + 1]).subspan(window.nextLast - length, length));
  }

  // an end of a window whose symbol has the fewest possible lengths
  struct Choice {
    std::size_t step = 0;
    bool isFront = true;
    std::uint16_t symbol = 0;
    std::size_t width = std::numeric_limits<std::size_t>::max();
  };

  [[nodiscard]] std::optional<Choice> choose(const State& state) const {
    std::optional<Choice> best;
    for (std::size_t step = 0; step < stepCount(); ++step) {
      const Window& window = state.windows[step];
      if (window.first == window.last) {
        continue;
      }
      for (const bool isFront : {true, false}) {
        const std::uint16_t symbol = strings_[step][isFront ? window.first : window.last - 1];
        const std::size_t width = state.most[symbol] - state.least[symbol];
        if (!best || width < best->width) {
          best = Choice{step, isFront, symbol, width};
        }
      }
    }
    return best;
  }

  void explore(State state) {
    if (isGivenUp_ || hasReachedLimit()) {
      return;
    }
    const std::optional<Choice> choice = choose(state);
    if (!choice) {
      keep(state);
      return;
    }
    for (std::size_t length = state.least[choice->symbol]; length <= state.most[choice->symbol]; ++length) {
      if (!mayContinue()) {
        return;
      }
      State next = state;
      const bool isAssigned =
          choice->isFront ? assignFront(next, choice->step, length) : assignBack(next, choice->step, length);
      if (isAssigned && propagate(next)) {
        explore(std::move(next));
      }
      if (isGivenUp_ || hasReachedLimit()) {
        return;
      }
    }
  }

  bool mayContinue() {
    // the call may take as long as reading a clock
    constexpr std::size_t kWorkBetween = 100'000;
    if (work_ >= kWorkBetween || !hasAsked_) {
      hasAsked_ = true;
      work_ = 0;
      isGivenUp_ = options_.mayContinue && !options_.mayContinue();
    }
    work_ += 100;
    return !isGivenUp_;
  }

  void keep(const State& state) {
    D0lSystem system;
    for (const std::optional<Part>& part : state.successors) {
      system.successors.push_back(part ? std::optional(String(part->begin(), part->end())) : std::nullopt);
    }
    // constants of the last string only have no production to show
    for (std::size_t symbol = 0; symbol < names_.size(); ++symbol) {
      const bool isDerived =
          std::any_of(counts_.begin(), counts_.end() - 1, [symbol](const auto& counts) { return counts[symbol] > 0; });
      if (!isDerived) {
        system.successors[symbol].reset();
      }
    }
    systems_.push_back(std::move(system));
  }

  std::span<const String> strings_;
  const std::vector<std::string>& names_;
  const InferenceOptions& options_;
  std::vector<std::vector<std::size_t>> counts_;  // occurrences by string and symbol
  std::vector<bool> isConstant_;                  // by symbol
  std::vector<D0lSystem> systems_;
  std::size_t work_ = 0;
  bool hasAsked_ = false;
  bool isGivenUp_ = false;
};

// turtle symbols that change, empty successors, the length of all successors
std::tuple<std::size_t, std::size_t, std::size_t> rank(const D0lSystem& system, const std::vector<std::string>& names) {
  std::size_t changed = 0;
  std::size_t erased = 0;
  std::size_t length = 0;
  for (std::size_t symbol = 0; symbol < names.size(); ++symbol) {
    if (const auto& successor = system.successors[symbol]) {
      const auto first = static_cast<unsigned char>(names[symbol].front());
      const bool isLetter = first >= 0x80 || std::isalpha(first);
      changed += !isLetter && *successor != String{static_cast<std::uint16_t>(symbol)} ? 1 : 0;
      erased += successor->empty() ? 1 : 0;
      length += successor->size();
    }
  }
  return {changed, erased, length};
}

}  // namespace

Inference inferD0l(const StepStrings& steps, const InferenceOptions& options) {
  Inference result;
  Search search(steps, steps.strings.size(), options);
  const bool isComplete = search.run();
  result.hasAll = isComplete && !search.hasReachedLimit();
  result.systems = search.takeSystems();
  std::stable_sort(result.systems.begin(), result.systems.end(),
                   [&](const D0lSystem& a, const D0lSystem& b) { return rank(a, steps.names) < rank(b, steps.names); });
  if (result.systems.size() > 1) {
    result.outcome = InferenceOutcome::Several;
  } else if (!isComplete) {
    result.outcome = InferenceOutcome::Undecided;
  } else if (result.systems.size() == 1) {
    result.outcome = InferenceOutcome::One;
  } else {
    result.outcome = InferenceOutcome::None;
    // the first strings that have no system
    result.firstMisfit = steps.strings.size() - 1;
    InferenceOptions one = options;
    one.systemLimit = 1;
    for (std::size_t count = 2; count < steps.strings.size(); ++count) {
      Search shorter(steps, count, one);
      const bool isDecided = shorter.run();
      if (isDecided && shorter.takeSystems().empty()) {
        result.firstMisfit = count - 1;
        break;
      }
    }
  }
  return result;
}

std::optional<std::vector<std::uint16_t>> deriveOnce(const D0lSystem& system, std::span<const std::uint16_t> string) {
  std::vector<std::uint16_t> result;
  for (const std::uint16_t symbol : string) {
    const auto& successor = system.successors[symbol];
    if (!successor) {
      return std::nullopt;
    }
    result.insert(result.end(), successor->begin(), successor->end());
  }
  return result;
}

}  // namespace espalier::language
