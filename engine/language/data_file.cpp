#include "engine/language/data_file.h"

#include <algorithm>
#include <utility>

namespace espalier::language {

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

int boundedSampleCount(const DataFile& file, core::SourceRange range, int count) {
  if (count > kMostSamples) {
    file.warn(range, "more than " + std::to_string(kMostSamples) + " samples; " + std::to_string(kMostSamples) +
                         " are used");
  }
  return std::clamp(count, 0, kMostSamples);
}

}  // namespace espalier::language
