#include "engine/language/view/view_lexer.h"

#include <algorithm>

namespace espalier::language {

std::optional<ViewLexer::Label> ViewLexer::nextLabel() {
  // a line of blanks and TABs is not a label
  while (!cursor_.atEnd() && cursor_.atLineEnd()) {
    (void)cursor_.takeLine();
  }
  cursor_.skip(" ");
  if (cursor_.atEnd()) {
    return std::nullopt;
  }
  labelBegin_ = cursor_.position();
  const std::string_view rest = cursor_.rest();
  const std::size_t end = rest.find_first_of(":\n");
  std::string_view text = rest.substr(0, end);
  if (end != std::string_view::npos && rest[end] == ':') {
    text = rest.substr(0, end + 1);
  } else if (text.ends_with('\r')) {
    text.remove_suffix(1);
  }
  labelEnd_ = labelBegin_ + text.size();
  cursor_.setPosition(labelEnd_);
  return Label{text, cursor_.rangeFrom(labelBegin_)};
}

void ViewLexer::beginArgument(std::string_view expected) {
  expected_ = expected;
  cursor_.skipSpace();
}

std::optional<double> ViewLexer::number() {
  beginArgument("a number");
  return cursor_.number();
}

std::optional<int> ViewLexer::integer() {
  beginArgument("an integer");
  return cursor_.integer();
}

std::optional<std::string_view> ViewLexer::word() {
  expected_ = "a word";
  if (isCompatible_) {
    cursor_.skipSpace();
  } else {
    cursor_.skipBlanks();
  }
  const std::string_view text = cursor_.word();
  return text.empty() ? std::nullopt : std::optional<std::string_view>(text);
}

std::optional<core::Vec3> ViewLexer::triple() {
  beginArgument("three numbers separated by commas");
  core::Vec3 value;
  double* const parts[3] = {&value.x, &value.y, &value.z};
  for (int i = 0; i < 3; ++i) {
    if (i > 0 && !cursor_.take(',')) {
      return std::nullopt;
    }
    cursor_.skipSpace();
    const std::optional<double> part = cursor_.number();
    if (!part) {
      return std::nullopt;
    }
    *parts[i] = *part;
  }
  return value;
}

std::optional<double> ViewLexer::optionalNumber() {
  files::TextCursor next = cursor_;
  next.skipSpace();
  const std::optional<double> value = next.number();
  if (value) {
    cursor_ = next;
  }
  return value;
}

std::optional<int> ViewLexer::optionalInteger() {
  files::TextCursor next = cursor_;
  next.skipSpace();
  const std::optional<int> value = next.integer();
  if (value) {
    cursor_ = next;
  }
  return value;
}

std::string_view ViewLexer::optionalUnit() {
  files::TextCursor next = cursor_;
  next.skip(" ");
  if (next.position() == cursor_.position() || next.atEnd() || next.atLineEnd() || next.peek() == '\t') {
    return {};
  }
  const std::string_view unit = next.word();
  cursor_ = next;
  return unit;
}

void ViewLexer::recover() {
  if (!isCompatible_) {
    // back to the label when the search for the argument went beyond its line
    files::TextCursor labelLine = cursor_;
    labelLine.setPosition(labelEnd_);
    (void)labelLine.takeLine();
    if (cursor_.position() >= labelLine.position()) {
      cursor_ = labelLine;
      return;
    }
  }
  skipLine();
}

core::SourceRange ViewLexer::commandRange() const {
  const std::string_view read = cursor_.textBetween(labelBegin_, cursor_.position());
  const std::size_t end = std::max(labelEnd_, labelBegin_ + std::min(read.find('\n'), read.size()));
  return {static_cast<std::uint32_t>(labelBegin_), static_cast<std::uint32_t>(std::max(end, labelBegin_ + 1))};
}

}  // namespace espalier::language
