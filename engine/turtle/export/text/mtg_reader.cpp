#include "engine/turtle/export/text/mtg_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace espalier::turtle::mtg {

namespace {

constexpr std::uint64_t kLongestSeries = 1'000'000;
/// As the parameters of a module.
constexpr std::size_t kMostFeatures = 1'000;
/// Entities that are looked at to find ends of axes, in all. A file of people needs a small multiple of its entities.
constexpr std::uint64_t kMostLooks = 100'000'000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) {
    text.remove_suffix(1);
  }
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) {
    text.remove_prefix(1);
  }
  return text;
}

std::vector<std::string_view> columnsOf(std::string_view line) {
  std::vector<std::string_view> columns;
  for (std::size_t begin = 0;;) {
    const std::size_t end = line.find('\t', begin);
    columns.push_back(trimmed(line.substr(begin, end == std::string_view::npos ? end : end - begin)));
    if (end == std::string_view::npos) {
      return columns;
    }
    begin = end + 1;
  }
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) {
      break;
    }
    at = std::min(line.find_first_of(" \t", begin), line.size());
    words.push_back(line.substr(begin, at - begin));
  }
  return words;
}

std::string unescaped(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.substr(i).starts_with("\\x23")) {
      result += '#';
      i += 3;
    } else if (text.substr(i).starts_with("\\x5c")) {
      result += '\\';
      i += 3;
    } else {
      result += text[i];
    }
  }
  return result;
}

// whether a cell has no number: it is empty, or has what R and Python write there
bool isMissing(std::string_view cell) {
  const auto isSame = [](char a, char b) { return (a | 0x20) == b; };
  return cell.empty() || std::ranges::equal(cell, std::string_view("na"), isSame) ||
         std::ranges::equal(cell, std::string_view("nan"), isSame);
}

}  // namespace

// where the axis of a vertex's parts of a finer scale ends
std::size_t MtgReader::endOf(std::size_t vertex, int scale) const {
  std::size_t at = vertex;
  while (at != kNoVertex && vertices_[at].scale < scale) {
    at = vertices_[at].firstPart;
    ++looks_;
  }
  if (at == kNoVertex || vertices_[at].scale != scale) {
    return kNoVertex;
  }
  for (std::size_t next = at; next != kNoVertex;) {
    at = next;
    next = kNoVertex;
    for (const std::size_t child : vertices_[at].children) {
      ++looks_;
      if (vertices_[child].edge == '<' && ancestorAt(child, vertices_[vertex].scale) == vertex) {
        next = child;
      }
    }
  }
  return at;
}

// a class of letters and an index of digits
std::string MtgReader::readLabel(std::string_view& code, Vertex& vertex) const {
  std::size_t letters = 0;
  while (letters < code.size() && isLetter(code[letters])) {
    ++letters;
  }
  std::size_t end = letters;
  while (end < code.size() && code[end] >= '0' && code[end] <= '9') {
    ++end;
  }
  vertex.entityClass = code.substr(0, letters);
  const auto scale = scales_.find(vertex.entityClass);
  if (letters == 0) {
    return problem("expected the class of an entity, found '" + std::string(code.substr(0, 20)) + "'");
  }
  if (std::from_chars(code.data() + letters, code.data() + end, vertex.index).ec == std::errc::result_out_of_range) {
    return problem("the number of '" + std::string(code.substr(0, end)) + "' is too large");
  }
  // some programs put the whole scene, which has the scale of `$`, above the plants without declaring it
  if (scale == scales_.end() && vertex.entityClass == "Scene" && vertices_.empty()) {
    code.remove_prefix(end);
    return {};
  }
  if (scale == scales_.end()) {
    return problem("the class '" + vertex.entityClass + "' is not in the section CLASSES");
  }
  vertex.scale = scale->second;
  code.remove_prefix(end);
  return {};
}

// a part of the entity that its base belongs to; the first part of a branch grows where its complex does
void MtgReader::joinPart(Vertex& vertex, std::size_t base) const {
  // scales may be left out
  vertex.complex = base;
  while (vertex.complex != kNoVertex && vertices_[vertex.complex].scale >= vertex.scale) {
    vertex.complex = vertices_[vertex.complex].complex;
    ++looks_;
  }
  if (vertex.complex == kNoVertex || vertices_[vertex.complex].firstPart != kNoVertex) {
    return;
  }
  const Vertex& complex = vertices_[vertex.complex];
  if (complex.origin != kNoVertex && vertices_[complex.origin].scale >= vertex.scale) {
    vertex.parent = ancestorAt(complex.origin, vertex.scale);
    vertex.origin = vertices_[complex.origin].scale > vertex.scale ? complex.origin : kNoVertex;
  } else if (complex.parent != kNoVertex) {
    vertex.parent = endOf(complex.parent, vertex.scale);
  }
  vertex.edge = vertex.parent != kNoVertex ? complex.edge : vertex.edge;
}

std::string MtgReader::join(Vertex& vertex, std::size_t base) const {
  if (vertex.edge == '/') {
    joinPart(vertex, base);
    return {};
  }
  if (base == kNoVertex) {
    return problem(std::string("'") + vertex.edge + vertex.entityClass + "' has no entity before it to join");
  }
  const int baseScale = vertices_[base].scale;
  vertex.parent = baseScale >= vertex.scale ? ancestorAt(base, vertex.scale) : endOf(base, vertex.scale);
  // some programs write the first part of an entity as if it grew on it
  if (vertex.parent == kNoVertex && baseScale < vertex.scale) {
    vertex.edge = '/';
    joinPart(vertex, base);
    return {};
  }
  if (vertex.parent == kNoVertex) {
    return problem(std::string("'") + vertex.edge + vertex.entityClass + "' has no entity of its scale before it to join");
  }
  vertex.origin = baseScale > vertex.scale ? base : kNoVertex;
  vertex.complex = vertices_[vertex.parent].complex;
  return {};
}

// the entities between the one before and `last`, and `last`: each joined to the one before it as `last` is
std::string MtgReader::addSeries(const Vertex& last, std::size_t& base) {
  const std::string name = last.entityClass + std::to_string(last.index);
  const std::string signs(2, last.edge);
  if (base == kNoVertex || vertices_[base].entityClass != last.entityClass || vertices_[base].index >= last.index) {
    return problem("'" + signs + name + "' needs an entity '" + last.entityClass + "' with a smaller number before it");
  }
  // a few bytes can ask for many entities: they share one bound
  seriesEntities_ += last.index - vertices_[base].index;
  if (seriesEntities_ > kLongestSeries) {
    return problem("with '" + signs + name + "' the series of the file have more than " +
                   std::to_string(kLongestSeries) + " entities");
  }
  for (std::uint64_t index = vertices_[base].index + 1; index <= last.index; ++index) {
    Vertex vertex = last;
    vertex.index = index;
    vertex.parent = base;
    vertex.complex = vertices_[base].complex;
    base = vertices_.size();
    add(std::move(vertex));
  }
  return {};
}

void MtgReader::add(Vertex vertex) {
  coarsest_ = vertex.scale > 0 ? std::min(coarsest_, vertex.scale) : coarsest_;
  if (vertex.parent != kNoVertex) {
    vertices_[vertex.parent].children.push_back(vertices_.size());
  }
  if (vertex.complex != kNoVertex && vertices_[vertex.complex].firstPart == kNoVertex) {
    vertices_[vertex.complex].firstPart = vertices_.size();
  }
  vertices_.push_back(std::move(vertex));
}

std::string MtgReader::readCode(std::string_view code, std::size_t column) {
  std::size_t base = column > 0 && column - 1 < lastOfColumn_.size() ? lastOfColumn_[column - 1] : kNoVertex;
  if (code.starts_with('^')) {
    base = column < lastOfColumn_.size() ? lastOfColumn_[column] : kNoVertex;
    if (base == kNoVertex) {
      return problem("'^' follows no entity of its column");
    }
    code.remove_prefix(1);
  }
  while (!code.empty()) {
    Vertex vertex;
    vertex.edge = code.front();
    if (vertex.edge != '/' && vertex.edge != '<' && vertex.edge != '+') {
      return problem("expected '/', '<' or '+' before an entity, found '" + std::string(code.substr(0, 20)) +
                     "' (columns are separated by tabs)");
    }
    code.remove_prefix(1);
    const bool isSeries = vertex.edge != '/' && code.starts_with(vertex.edge);
    code.remove_prefix(isSeries ? 1 : 0);
    if (std::string what = readLabel(code, vertex); !what.empty()) {
      return what;
    }
    if (isSeries) {
      if (std::string what = addSeries(vertex, base); !what.empty()) {
        return what;
      }
      continue;
    }
    // in the first column only plants begin without `^`: anything finer goes on with the column, as older files have it
    const bool goesOn = base == kNoVertex && column == 0 && !lastOfColumn_.empty() && lastOfColumn_[0] != kNoVertex;
    if (goesOn && vertex.scale > coarsest_) {
      base = lastOfColumn_[0];
    }
    if (std::string what = join(vertex, base); !what.empty()) {
      return what;
    }
    if (looks_ > kMostLooks) {
      return problem("too many entities are joined to long axes of other scales. Join each entity to its neighbour");
    }
    base = vertices_.size();
    add(std::move(vertex));
  }
  lastOfColumn_.resize(column + 1, kNoVertex);
  lastOfColumn_[column] = base;
  return {};
}

std::string MtgReader::readFeatures(const std::vector<std::string_view>& columns, Vertex& vertex) {
  // a short line has few of them
  const std::size_t given = columns.size() > featureColumn_ ? columns.size() - featureColumn_ : 0;
  vertex.numbers.resize(std::max(vertex.numbers.size(), std::min(given, features_.size())), kUnknown);
  if (hasText_) {
    vertex.text = std::string();
  }
  for (std::size_t i = 0; i < std::min(given, features_.size()); ++i) {
    const std::string_view value = columns[featureColumn_ + i];
    if (features_[i] == "Text") {
      vertex.text = unescaped(value);
    } else if (isNumeric_[features_[i]] && !isMissing(value)) {
      double number = 0.0;
      const char* const begin = value.data() + (value.starts_with('+') ? 1 : 0);
      const auto [end, error] = std::from_chars(begin, value.data() + value.size(), number);
      if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(number)) {
        return problem("expected a number in the column '" + features_[i] + "', found '" +
                       std::string(value.substr(0, 40)) + "'. Write it with a decimal point, or leave the cell empty");
      }
      vertex.numbers[i] = number;
    }
  }
  return {};
}

std::string MtgReader::readGraphLine(std::string_view line) {
  const std::vector<std::string_view> columns = columnsOf(line);
  if (!hasHeader_) {
    // ENTITY-CODE, then the features in the columns that their values have
    hasHeader_ = true;
    for (std::size_t i = 1; i < columns.size(); ++i) {
      if (featureColumn_ == kNoVertex && !columns[i].empty()) {
        featureColumn_ = i;
      }
      if (featureColumn_ != kNoVertex) {
        features_.emplace_back(columns[i]);
        hasText_ = hasText_ || features_.back() == "Text";
      }
    }
    return features_.size() <= kMostFeatures
               ? std::string()
               : problem("there are " + std::to_string(features_.size()) + " features, and at most " +
                         std::to_string(kMostFeatures) + " are read");
  }
  std::size_t column = 0;
  while (column < columns.size() && columns[column].empty()) {
    ++column;
  }
  if (column >= columns.size() || column >= featureColumn_) {
    return problem("there is no entity on this line");
  }
  // the last entity of its column, observed once more
  if (columns[column] == "*") {
    if (column >= lastOfColumn_.size() || lastOfColumn_[column] == kNoVertex) {
      return problem("'*' follows no entity of its column");
    }
    return readFeatures(columns, vertices_[lastOfColumn_[column]]);
  }
  const std::size_t before = vertices_.size();
  if (std::string what = readCode(columns[column], column); !what.empty()) {
    return what;
  }
  return vertices_.size() > before ? readFeatures(columns, vertices_.back()) : std::string();
}

std::string MtgReader::readLine(std::string_view line) {
  const std::string_view content = trimmed(line);
  const std::vector<std::string_view> words = wordsOf(content);
  const auto begins = [&](std::string_view name) {
    return content.starts_with(name) && trimmed(content.substr(name.size())).starts_with(':');
  };
  if (begins("CODE")) {
    return words.back() == "FORM-A" || words.back() == ":FORM-A"
               ? std::string()
               : problem("only the form FORM-A is read, not '" + std::string(words.back()) + "'");
  }
  constexpr std::pair<std::string_view, Section> kSections[] = {{"CLASSES", Section::Classes},
                                                                {"DESCRIPTION", Section::Description},
                                                                {"FEATURES", Section::Features},
                                                                {"MTG", Section::Graph}};
  for (const auto& [name, section] : kSections) {
    if (begins(name)) {
      section_ = section;
      hasHeader_ = false;
      return {};
    }
  }
  if (section_ == Section::Graph) {
    return readGraphLine(line);
  }
  if (!hasHeader_) {
    hasHeader_ = true;
    return section_ == Section::None ? problem("expected 'CODE:', 'CLASSES:', 'FEATURES:' or 'MTG:'") : std::string();
  }
  if (section_ == Section::Classes && words.size() >= 2) {
    int scale = 0;
    const auto [end, error] = std::from_chars(words[1].data(), words[1].data() + words[1].size(), scale);
    if (error != std::errc() || end != words[1].data() + words[1].size()) {
      return problem("the scale of class '" + std::string(words[0]) + "' is not a whole number");
    }
    scales_[std::string(words[0])] = scale;
  } else if (section_ == Section::Features && words.size() >= 2) {
    isNumeric_[std::string(words[0])] = words[1] == "REAL" || words[1] == "INT";
  }
  return {};
}

std::variant<MtgStrings, std::string> MtgReader::read() {
  while (!text_.empty()) {
    const std::size_t end = text_.find('\n');
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    ++line_;
    const std::string_view whole = trimmed(line);
    promisesEnd_ = promisesEnd_ || whole == kMtgPromise;
    hasEnd_ = whole.empty() ? hasEnd_ : whole == kMtgEnd;
    line = line.substr(0, line.find('#'));
    if (trimmed(line).empty()) {
      continue;
    }
    if (std::string what = readLine(line); !what.empty()) {
      return what;
    }
  }
  if (vertices_.empty()) {
    return problem("the file has no entities: it is no MTG, or ends before its section MTG");
  }
  if (promisesEnd_ && !hasEnd_) {
    return problem("the file was cut: its last line is not '# end', as its head says. Get a complete copy");
  }
  chooseParameters();
  return strings();
}

}  // namespace espalier::turtle::mtg

namespace espalier::turtle {

std::variant<MtgStrings, std::string> readMtg(std::string_view text) {
  return mtg::MtgReader(text).read();
}

}  // namespace espalier::turtle
