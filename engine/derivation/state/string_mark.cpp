#include "engine/derivation/state/string_mark.h"

#include <algorithm>
#include <utility>

namespace espalier::derivation {
namespace {

/// Appends a run, as part of the last run where it continues that run.
void append(std::vector<KeptModules>& list, const KeptModules& next) {
  if (!list.empty()) {
    KeptModules& last = list.back();
    if (last.from + last.modules == next.from && last.to + last.modules == next.to) {
      last.modules += next.modules;
      return;
    }
  }
  list.push_back(next);
}

/// The runs that two steps in a row keep.
std::vector<KeptModules> joined(const std::vector<KeptModules>& first, const std::vector<KeptModules>& second) {
  std::vector<KeptModules> result;
  auto a = first.begin();
  auto b = second.begin();
  while (a != first.end() && b != second.end()) {
    // positions in the string between the two steps
    const std::uint64_t begin = std::max(a->to, b->from);
    const std::uint64_t end = std::min(a->to + a->modules, b->from + b->modules);
    if (begin < end) {
      append(result, {a->from + (begin - a->to), b->to + (begin - b->from), end - begin});
    }
    (a->to + a->modules < b->from + b->modules) ? ++a : ++b;
  }
  return result;
}

}  // namespace

std::vector<KeptModules> keptModules(const StringMark& from, const std::shared_ptr<const StringMark>& to,
                                     std::uint64_t moduleCount) {
  if (to == nullptr) {
    return {};
  }
  if (to.get() == &from) {
    return {{0, 0, moduleCount}};
  }
  return to->base.lock().get() == &from ? to->kept : std::vector<KeptModules>{};
}

void KeptModulesRecorder::begin(const std::shared_ptr<const StringMark>& old) {
  base_ = nullptr;
  earlier_.clear();
  kept_.clear();
  if (old == nullptr) {
    return;
  }
  // a caller keeps the mark of the string, or an earlier mark
  isDirect_ = old.use_count() > 1;
  base_ = isDirect_ ? old : old->base.lock();
  if (!isDirect_ && base_ != nullptr) {
    earlier_ = old->kept;
  }
}

void KeptModulesRecorder::note(std::uint64_t from, std::uint64_t to, std::uint64_t modules) {
  if (base_ != nullptr && modules > 0) {
    append(kept_, {from, to, modules});
  }
}

std::shared_ptr<const StringMark> KeptModulesRecorder::finish() {
  if (base_ == nullptr) {
    return nullptr;
  }
  const std::shared_ptr<const StringMark> base = std::exchange(base_, nullptr);
  std::vector<KeptModules> kept = isDirect_ ? std::exchange(kept_, {}) : joined(earlier_, kept_);
  return kept.empty() ? nullptr : std::make_shared<const StringMark>(StringMark{base, std::move(kept)});
}

}  // namespace espalier::derivation
