#include "engine/core/diagnostic.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "engine/core/message_text.h"

namespace espalier::core {
namespace {

std::string_view severityWord(Severity severity) {
  switch (severity) {
    case Severity::Error:
      return "error";
    case Severity::Warning:
      return "warning";
    case Severity::Note:
      return "note";
  }
  return "note";
}

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

// a substitution costs 2, a change of letter case 1: distances are in half steps
int substitutionCost(char a, char b) {
  if (a == b) {
    return 0;
  }
  return lower(a) == lower(b) ? 1 : 2;
}

/// Optimal string alignment distance in half steps (Damerau 1964).
int editDistance(std::string_view a, std::string_view b) {
  constexpr int kStep = 2;
  std::vector<int> beforeLast(b.size() + 1);
  std::vector<int> last(b.size() + 1);
  std::vector<int> current(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    last[j] = static_cast<int>(j) * kStep;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    current[0] = static_cast<int>(i) * kStep;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      current[j] =
          std::min({last[j] + kStep, current[j - 1] + kStep, last[j - 1] + substitutionCost(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        current[j] = std::min(current[j], beforeLast[j - 2] + kStep);
      }
    }
    std::swap(beforeLast, last);
    std::swap(last, current);
  }
  return last[b.size()];
}

/// A part of a line that fits the width of a message.
struct LineExcerpt {
  std::string text;
  std::size_t before = 0;  // bytes of `text` before the place
  std::size_t length = 0;  // bytes of `text` to underline
};

LineExcerpt excerptOf(const std::string& line, std::size_t place, std::size_t length) {
  constexpr std::size_t kMostColumns = 190;  // the number of the line stands before it
  constexpr std::size_t kBefore = 120;       // columns before the place, of a line that is cut
  const auto isInside = [&](std::size_t i) {
    return i < line.size() && (static_cast<unsigned char>(line[i]) & 0xC0U) == 0x80U;
  };
  std::size_t begin = 0;
  std::size_t end = line.size();
  if (line.size() > kMostColumns) {
    begin = place > kBefore ? place - kBefore : 0;
    end = std::min(line.size(), begin + kMostColumns - 6);
    while (isInside(begin)) {
      ++begin;
    }
    while (isInside(end)) {
      --end;
    }
  }
  LineExcerpt excerpt;
  const std::string front = begin > 0 ? "..." : "";
  excerpt.text = front + line.substr(begin, end - begin) + (end < line.size() ? "..." : "");
  makePrintable(excerpt.text);
  excerpt.before = std::min(front.size() + place - begin, excerpt.text.size());
  excerpt.length = std::min(length, end > place ? end - place : 1);
  return excerpt;
}

}  // namespace

std::string formatDiagnostic(const Diagnostic& diagnostic) {
  const SourceLocation& at = diagnostic.location;
  std::string text;
  if (!at.file.empty()) {
    text += (at.line > 0 ? placeText(at) : at.file) + ": ";
  }
  text += severityWord(diagnostic.severity);
  text += ": ";
  text += messageText(diagnostic.message, text.size());
  if (at.line > 0 && !at.lineText.empty()) {
    std::string number = std::to_string(at.line);
    number.insert(0, number.size() < 5 ? 5 - number.size() : 0, ' ');
    const std::size_t place = std::min<std::size_t>(at.column > 0 ? at.column - 1 : 0, at.lineText.size());
    const LineExcerpt line = excerptOf(at.lineText, place, at.length);
    text += '\n' + number + " | " + line.text;
    text += '\n' + std::string(number.size(), ' ') + " | ";
    // a blank for each character up to the column, TABs kept so that the caret stays below its place
    const auto beginsCharacter = [&](std::size_t i) {
      return (static_cast<unsigned char>(line.text[i]) & 0xC0U) != 0x80U;  // no further byte of UTF-8
    };
    for (std::size_t i = 0; i < line.before; ++i) {
      if (beginsCharacter(i)) {
        text += line.text[i] == '\t' ? '\t' : ' ';
      }
    }
    text += '^';
    const std::size_t end = std::min<std::size_t>(line.text.size(), line.before + line.length);
    for (std::size_t i = line.before + 1; i < end; ++i) {
      text.append(beginsCharacter(i) ? 1 : 0, '~');
    }
  }
  if (!at.expansion.empty()) {
    text += "\n   " + at.expansion;
  }
  if (!diagnostic.hint.empty()) {
    constexpr std::string_view kHint = "   hint: ";
    text += '\n' + std::string(kHint) + messageText(diagnostic.hint, kHint.size());
  }
  return text;
}

void DiagnosticList::add(Diagnostic diagnostic) {
  const bool isError = diagnostic.severity == Severity::Error;
  std::size_t& count = isError ? errorCount_ : warningCount_;
  ++count;
  if (count > kLimit) {
    return;
  }
  makePrintable(diagnostic.message);
  makePrintable(diagnostic.hint);
  makePrintable(diagnostic.location.lineText);
  // a list keeps few copies of a very long line
  constexpr std::size_t kLongLine = 10'000;
  constexpr std::size_t kMostLongLines = 5;
  const auto isLong = [](const Diagnostic& entry) { return entry.location.lineText.size() > kLongLine; };
  if (isLong(diagnostic) &&
      std::count_if(entries_.begin(), entries_.end(), isLong) >= static_cast<std::ptrdiff_t>(kMostLongLines)) {
    diagnostic.location.lineText.clear();
  }
  entries_.push_back(std::move(diagnostic));
}

std::string_view nearestName(std::string_view name, const std::vector<std::string_view>& candidates) {
  std::string_view nearest;
  // half steps: a third of the length, at least one whole step
  int best = std::max(2, static_cast<int>(name.size() * 2 / 3)) + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t difference =
        candidate.size() > name.size() ? candidate.size() - name.size() : name.size() - candidate.size();
    if (static_cast<int>(difference) * 2 >= best) {
      continue;
    }
    const int distance = editDistance(name, candidate);
    // two names that share no character are not near
    const bool sharesNothing = distance >= 2 * static_cast<int>(std::max(name.size(), candidate.size()));
    if (distance < best && !sharesNothing) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string suggestName(std::string_view name, const std::vector<std::string_view>& candidates) {
  std::string text;
  const std::string_view nearest = nearestName(name, candidates);
  if (!nearest.empty()) {
    text += "Did you mean '";
    text += nearest;
    text += "'? ";
  }
  text += "Available: ";
  constexpr std::size_t kMostNames = 40;
  const std::size_t shown = candidates.size() > kMostNames + 5 ? kMostNames : candidates.size();
  for (std::size_t i = 0; i < shown; ++i) {
    if (i > 0) {
      text += ", ";
    }
    text += candidates[i];
  }
  if (shown < candidates.size()) {
    text += " and " + std::to_string(candidates.size() - shown) + " more";
  }
  text += '.';
  return text;
}

}  // namespace espalier::core
