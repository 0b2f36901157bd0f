#include "engine/files/data_file.h"

#include <algorithm>
#include <utility>

namespace espalier::files {

void DataFile::warnExpected(const TextCursor& at, const std::string& expected, const std::string& context,
                            std::string hint) const {
  TextCursor next = at;
  next.skipBlanks();
  const std::size_t begin = next.position();
  const std::string found = next.found();
  (void)next.word();
  warn(next.rangeFrom(begin), "expected " + expected + " while reading " + context + ", found " + found,
       std::move(hint));
}

bool DataFile::spendPoints(std::size_t count) const {
  if (budget_ == nullptr) {
    return true;
  }
  const bool isEnough = count <= budget_->points;
  budget_->points -= isEnough ? count : 0;
  return isEnough;
}

bool DataFile::spendSamples(std::size_t count) const {
  if (budget_ == nullptr) {
    return true;
  }
  const bool isEnough = count <= budget_->samples;
  budget_->samples -= isEnough ? count : 0;
  return isEnough;
}

int boundedSampleCount(const DataFile& file, core::SourceRange range, int count) {
  if (count > kMostSamples) {
    file.warn(range,
              "more than " + std::to_string(kMostSamples) + " samples; " + std::to_string(kMostSamples) + " are used");
  }
  const int bounded = std::clamp(count, 0, kMostSamples);
  if (!file.spendSamples(static_cast<std::size_t>(bounded))) {
    file.warn(range, "the functions and curves of one view file have too many samples; this one has no table");
    return 0;
  }
  return bounded;
}

}  // namespace espalier::files
