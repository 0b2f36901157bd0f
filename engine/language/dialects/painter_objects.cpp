#include "engine/language/dialects/painter_objects.h"

#include <array>
#include <vector>

#include "engine/language/dialects/textbook/textbook_modules.h"

namespace espalier::language {
namespace {

constexpr std::string_view kObject = "object ";
constexpr std::string_view kVector = "vector";

// colours: bark, leaf, fruit; 0 is the page
constexpr int kBark = 1;
constexpr int kLeaf = 2;
constexpr int kFruit = 3;

TextPiece behindSeparator(const TextPiece& piece) {
  const TextPiece rest = piece.trimmed();
  return rest.text.starts_with(':') || rest.text.starts_with('=') ? rest.from(1).trimmed() : rest;
}

}  // namespace

bool isPainterStatement(std::string_view statement) {
  const std::string small = lowered(statement.substr(0, kObject.size()));
  const bool isVector = small.starts_with(kVector) && statement.find_first_of(":=") != std::string_view::npos;
  return small == kObject || isVector;
}

bool PainterObjects::reads(const TextPiece& statement) {
  if (!isActive_ || !isPainterStatement(statement.text)) {
    return false;
  }
  if (lowered(statement.text.substr(0, kObject.size())) == kObject) {
    readObject(statement.from(kObject.size()).trimmed(), statement.offset);
  } else {
    readVector(behindSeparator(statement.from(kVector.size())));
  }
  return true;
}

void PainterObjects::readObject(const TextPiece& value, std::size_t offset) {
  const char symbol = value.empty() ? '\0' : value.text.front();
  const TextPiece file = value.empty() ? value : behindSeparator(value.from(1));
  if ((symbol != 'p' && symbol != 'o') || file.empty()) {
    report_.error(offset, kObject.size() + value.text.size(), "expected 'p' or 'o' and a file while reading 'object'",
                  "write 'object p: leaf.obj 0.5', the number is its size");
    return;
  }
  const std::size_t blank = file.text.find(' ');
  const auto scale = blank == std::string_view::npos ? std::optional(1.0) : textbookNumber(file.text.substr(blank));
  if (!scale || !(*scale > 0.0)) {
    report_.error(file.offset, file.text.size(), "expected a size above 0 behind the file of an object",
                  "write 'object p: leaf.obj 0.5'");
    return;
  }
  (symbol == 'p' ? leaf_ : fruit_) = std::string(file.text.substr(0, blank)) + " " + cpfgNumber(*scale);
}

void PainterObjects::readVector(const TextPiece& value) {
  std::array<double, 3> numbers{};
  std::size_t count = 0;
  std::string plain(value.text);
  std::replace_if(
      plain.begin(), plain.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  for (std::size_t at = plain.find_first_not_of(' '); at != std::string::npos; at = plain.find_first_not_of(' ', at)) {
    const std::size_t end = std::min(plain.find(' ', at), plain.size());
    const auto number = textbookNumber(std::string_view(plain).substr(at, end - at));
    if (!number || count == numbers.size()) {
      count = 0;
      break;
    }
    numbers[count++] = *number;
    at = end;
  }
  if (count != numbers.size()) {
    report_.error(value.offset, value.text.size(), "expected three numbers while reading 'vector'",
                  "write 'vector: 0, -0.1, 0': everything drawn moves by it");
    return;
  }
  vector_ = core::Vec3{numbers[0], numbers[1], numbers[2]};
}

void PainterObjects::addDrawing(const std::set<char>& plainSymbols, CpfgModel& model) const {
  const auto draw = [&](const std::string& production) { model.drawing.emplace_back(production, 0); };
  const std::string green = "[;(" + std::to_string(kLeaf) + ")";
  const std::string red = "[;(" + std::to_string(kFruit) + ")";
  if (leaf_.empty()) {
    // a rhomb along the heading, 1.7 long
    draw("p --> " + green + "{.+(30)f-(60)f-(120)f}]");
    draw("p(x) --> " + green + "{.+(30)f(x)-(60)f(x)-(120)f(x)}]");
  } else {
    draw("p --> " + green + "~p]");
    draw("p(x) --> " + green + "~p(x)]");
    model.viewCommands.emplace_back("surface: p " + leaf_);
  }
  if (fruit_.empty()) {
    draw("o --> " + red + "@O(0.5)]");
    draw("o(x) --> " + red + "@O(x)]");
  } else {
    draw("o --> " + red + "~o]");
    draw("o(x) --> " + red + "~o(x)]");
    model.viewCommands.emplace_back("surface: o " + fruit_);
  }
  draw("F(d,s) --> !(s)F(d)");
  silence(plainSymbols, "FfGg+-&^/\\|", model);
  if (vector_) {
    model.viewCommands.emplace_back("displacement: " + cpfgNumber(vector_->x) + "," + cpfgNumber(vector_->y) + "," +
                                    cpfgNumber(vector_->z));
    model.lost.emplace_back("the constant vector that moves everything drawn");
  }
  model.colour = kBark;
  model.palette[0] = {250, 248, 242};
  model.palette[kBark] = {110, 78, 52};
  model.palette[kLeaf] = {86, 142, 66};
  model.palette[kFruit] = {196, 48, 40};
  model.viewCommands.emplace_back("initial line width: 0.12 s");
}

}  // namespace espalier::language
