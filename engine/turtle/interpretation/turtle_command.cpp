#include "engine/turtle/interpretation/turtle_command.h"

#include <array>
#include <string_view>

namespace espalier::turtle {

namespace {

struct Entry {
  std::string_view text;
  TurtleCommand command;
  std::uint16_t least = 0;  // numbers of parameters
  std::uint16_t most = 0;
};

constexpr std::array kSingle{
#define ESPALIER_TURTLE_SYMBOL(command, text, least, most, usage, meaning) \
  Entry{text, TurtleCommand::command, least, most},
#include "engine/language/turtle_symbols.def"
};

constexpr std::array kAfterAt{
#define ESPALIER_TURTLE_AFTER_AT(command, text, usage, meaning) Entry{text, TurtleCommand::command},
#include "engine/language/turtle_symbols.def"
};

}  // namespace

TurtleCommand commandOf(char character, std::uint16_t arity) {
  for (const Entry& entry : kSingle) {
    if (entry.text[0] == character && arity >= entry.least && arity <= entry.most) {
      return entry.command;
    }
  }
  return TurtleCommand::None;
}

TurtleCommand commandAfterAt(char first, char second) {
  for (const Entry& entry : kAfterAt) {
    const char entrySecond = entry.text.size() > 1 ? entry.text[1] : '\0';
    if (entry.text[0] == first && entrySecond == second) {
      return entry.command;
    }
  }
  return TurtleCommand::None;
}

bool isAddition(TurtleCommand command) {
  return command >= TurtleCommand::ExchangeFrames && command <= TurtleCommand::BendDown;
}

bool takesSecondSymbol(char first) {
  return std::string_view("PTGmDb").find(first) != std::string_view::npos && first != '\0';
}

}  // namespace espalier::turtle
