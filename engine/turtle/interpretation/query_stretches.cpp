#include "engine/turtle/interpretation/query_stretches.h"

#include <algorithm>
#include <utility>

namespace espalier::turtle {
namespace {

// of a stretch, about: with fewer modules, turtle states cost more; with more, one change costs more
constexpr std::uint64_t kStretchModules = 256;
constexpr std::uint64_t kMostBytesPerModule = 32;    // of the string
constexpr std::uint64_t kNever = ~std::uint64_t{0};  // no module has this index

}  // namespace

std::uint64_t QueryStretches::Stretch::bytes() const {
  return sizeof *this + (passage.closed.size() + passage.opened.size()) * sizeof passage.entry +
         queries.size() * sizeof queries[0];
}

/// One pass over the string, from the stretches of the pass before to those of this one.
class QueryStretches::Pass {
 public:
  Pass(const Interpretation::Subject& subject, const InterpretationOutput& output,
       std::span<const derivation::KeptModules> kept, Stretches known)
      : size_(subject.plantState.string.size()),
        output_(output),
        interpretation_(subject, output),
        kept_(kept),
        known_(std::move(known)) {
    interpretation_.noteIn(&notes_);
  }

  void run(QueryStretches& result) {
    interpretation_.begin();
    findNext();
    while (module_ < size_) {
      if (nextModule_ > module_) {
        interpret();
      } else if (nextFollows()) {
        take();
      } else {
        // another turtle comes here
        ++next_;
      }
      findNext();
    }
    arrive();
    interpretation_.end();
    result.bytes_ = bytes_;
    result.isWhole_ = isWhole_;
    result.stretches_ = std::move(made_);
  }

 private:
  /// Moves next_ to the first stretch that was kept and is not behind the present module.
  void findNext() {
    nextModule_ = kNever;
    for (; next_ < known_.size(); ++next_) {
      const Stretch& stretch = *known_[next_];
      while (!kept_.empty() && kept_.front().from + kept_.front().modules <= stretch.firstModule) {
        kept_ = kept_.subspan(1);
      }
      if (kept_.empty()) {
        return;
      }
      const derivation::KeptModules& run = kept_.front();
      const bool isKept =
          stretch.firstModule >= run.from && stretch.firstModule + stretch.passage.modules <= run.from + run.modules;
      const std::uint64_t place = run.to + (stretch.firstModule - run.from);
      if (isKept && place >= module_) {
        nextModule_ = place;
        return;
      }
    }
  }

  [[nodiscard]] bool nextFollows() {
    const TurtlePassage& passage = known_[next_]->passage;
    const std::uint64_t left = size_ - module_;
    if (last_ != nullptr && known_[next_]->firstModule == lastEnd_) {
      // the turtle is where it was; only branches from before the stretches that were just taken can be others
      return (!passage.endsString || passage.modules == left) &&
             (passage.closed.size() <= opened_.size() ||
              passage.closesSame(opened_.size(), interpretation_.openBranches()));
    }
    arrive();
    return passage.isSameFor(interpretation_.state(), interpretation_.openBranches(), left);
  }

  void take() {
    Stretch& stretch = *known_[next_];
    const TurtlePassage& passage = stretch.passage;
    for (const Query& query : stretch.queries) {
      interpretation_.askAgain(module_ + query.module, offset_ + query.offset, query.place);
    }
    for (std::size_t i = 0; i < passage.closed.size(); ++i) {
      opened_.empty() ? interpretation_.openBranches().pop_back() : opened_.pop_back();
    }
    for (const TurtleState& opened : passage.opened) {
      opened_.push_back(&opened);
    }
    last_ = &stretch;
    lastEnd_ = stretch.firstModule + passage.modules;
    stretch.firstModule = module_;
    module_ += passage.modules;
    offset_ += passage.parameters;
    bytes_ += stretch.bytes();
    made_.push_back(std::move(known_[next_++]));
  }

  /// Moves the turtle behind the stretches that were taken.
  void arrive() {
    if (last_ == nullptr) {
      return;
    }
    for (const TurtleState* const opened : std::exchange(opened_, {})) {
      interpretation_.openBranches().push_back(*opened);
    }
    interpretation_.state() = last_->passage.exit;
    last_ = nullptr;
  }

  void interpret() {
    arrive();
    const std::uint64_t firstOffset = offset_;
    std::vector<TurtleState>& open = interpretation_.openBranches();
    auto stretch = std::make_unique<Stretch>();
    stretch->firstModule = module_;
    TurtlePassage& passage = stretch->passage;
    notes_.lowest = open.size();
    notes_.closed.clear();
    notes_.outer.clear();
    passage.entry = interpretation_.state();

    // up to where the pass before goes on, or far enough
    while (module_ < size_) {
      const std::size_t queries = output_.queries->size();
      const std::uint64_t offset = offset_;
      const bool mayEnd = interpretation_.walkOne(module_, offset_);
      if (output_.queries->size() > queries) {
        // a `?` has no parameters: those of the query come first
        const TurtleState& turtle = interpretation_.state();
        stretch->queries.push_back({output_.queries->module.back() - stretch->firstModule,
                                    offset - firstOffset,
                                    {turtle.position, turtle.frame, turtle.width, turtle.scale}});
      }
      if (module_ > nextModule_) {
        findNext();
      }
      if (mayEnd && (module_ - stretch->firstModule >= kStretchModules || (module_ == nextModule_ && nextFollows()))) {
        break;
      }
    }

    passage.closed = notes_.closed;
    passage.exit = interpretation_.state();
    passage.opened.assign(open.begin() + static_cast<std::ptrdiff_t>(notes_.lowest), open.end());
    passage.endsString = module_ == size_;
    passage.modules = module_ - stretch->firstModule;
    passage.parameters = offset_ - firstOffset;
    // stretches beyond the bound are interpreted again in the next pass
    const std::uint64_t bytes = stretch->bytes();
    isWhole_ = isWhole_ && bytes_ + bytes <= std::max(size_, kStretchModules) * kMostBytesPerModule;
    if (isWhole_) {
      bytes_ += bytes;
      made_.push_back(std::move(stretch));
    }
  }

  std::uint64_t size_;
  const InterpretationOutput& output_;
  Interpretation interpretation_;
  Interpretation::StretchNotes notes_;
  std::span<const derivation::KeptModules> kept_;  // those behind are passed
  Stretches known_;
  std::size_t next_ = 0;               // of known_, expected next
  std::uint64_t nextModule_ = kNever;  // where it is now; kNever: nothing of the pass before is left
  std::uint64_t module_ = 0;           // the next
  std::uint64_t offset_ = 0;           // of its parameters
  Stretches made_;
  std::uint64_t bytes_ = 0;  // of made_
  bool isWhole_ = true;
  const Stretch* last_ = nullptr;           // taken; the turtle is not yet behind it
  std::uint64_t lastEnd_ = 0;               // behind it, in the string of the pass before
  std::vector<const TurtleState*> opened_;  // by the stretches taken since, and not closed by them
};

void QueryStretches::run(const Interpretation::Subject& subject, const InterpretationOutput& output,
                         const derivation::StepChanges& changes) {
  Stretches known = std::exchange(stretches_, {});
  forget();
  Pass(subject, output, changes.kept(), std::move(known)).run(*this);
}

}  // namespace espalier::turtle
