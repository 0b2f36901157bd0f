#include "engine/turtle/export/text/rsml_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "engine/core/number_text.h"

namespace espalier::turtle {

void RsmlText::beginScene(const RsmlFacts& facts) {
  out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<rsml>\n<metadata><version>1</version><unit>";
  escaped(facts.unit.empty() ? "unknown" : facts.unit);
  out_ << "</unit><resolution>1</resolution><software>Espalier</software>";
  if (facts.step) {
    out_ << "<time-sequence><index>" << std::to_string(*facts.step)
         << "</index><unified>false</unified></time-sequence>";
  }
  out_ << "</metadata>\n<scene>\n";
}

void RsmlText::beginPlant(std::string_view id, std::string_view label) {
  out_ << "<plant";
  named(id, label);
  out_ << ">\n";
}

void RsmlText::beginRoot(std::string_view id, std::string_view label, std::optional<std::size_t> parentNode) {
  out_ << "<root";
  named(id, label);
  out_ << ">";
  if (parentNode) {
    out_ << "<properties><parent-node value=\"" << std::to_string(*parentNode) << "\"/></properties>";
  }
  out_ << "\n<geometry><polyline>";
}

void RsmlText::point(const core::Vec3& place, std::optional<int> decimals) {
  out_ << "<point";
  coordinate("x", place.x, decimals);
  coordinate("y", place.y, decimals);
  coordinate("z", place.z, decimals);
  out_ << "/>";
}

void RsmlText::endPoints() {
  out_ << "</polyline></geometry>\n<functions>";
  hasFunction_ = false;
}

void RsmlText::function(std::string_view name, std::span<const double> values) {
  std::size_t count = values.size();
  while (count > 0 && std::isnan(values[count - 1])) {
    --count;
  }
  const bool isOfAll = count == 1 && values.size() > 1;
  if (count == 0 || isOfAll ||
      std::ranges::any_of(values.first(count), [](double value) { return std::isnan(value); })) {
    return;
  }
  out_ << (hasFunction_ ? "\n" : "") << "<function name=\"" << name << "\" domain=\"polyline\">";
  std::string text;
  for (const double value : values.first(count)) {
    text.clear();
    core::appendNumber(text, value, core::NumberStyle::Shortest);
    out_ << "<sample value=\"" << text << "\"/>";
  }
  out_ << "</function>";
  hasFunction_ = true;
}

void RsmlText::escaped(std::string_view text) {
  for (const char letter : text) {
    out_ << (letter == '&'   ? "&amp;"
             : letter == '<' ? "&lt;"
             : letter == '>' ? "&gt;"
             : letter == '"' ? "&quot;"
             // else a reader of XML gives a blank
             : letter == '\n' ? "&#10;"
             : letter == '\t' ? "&#9;"
             : letter == '\r' ? "&#13;"
                              : std::string_view(&letter, 1));
  }
}

void RsmlText::named(std::string_view id, std::string_view label) {
  out_ << " ID=\"";
  escaped(id);
  if (!label.empty()) {
    out_ << "\" label=\"";
    escaped(label);
  }
  out_ << '"';
}

void RsmlText::coordinate(const char* name, double value, std::optional<int> decimals) {
  char text[700];  // 309 digits, the point and 324 decimals
  const auto written = decimals ? std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed, *decimals)
                                : std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed);
  std::string_view digits(text, static_cast<std::size_t>(written.ptr - text));
  if (digits.find('.') != std::string_view::npos) {
    digits = digits.substr(0, digits.find_last_not_of('0') + 1);
    digits.remove_suffix(digits.ends_with('.') ? 1 : 0);
  }
  out_ << ' ' << name << "=\"" << (digits == "-0" ? "0" : digits) << '"';
}

}  // namespace espalier::turtle
