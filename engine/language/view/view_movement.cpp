#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

constexpr std::size_t kReferenceMovements = 10;

/// Reads `count` numbers; false when there are fewer.
bool readNumbers(files::TextCursor& line, double* numbers, int count) {
  for (int i = 0; i < count; ++i) {
    line.skip(kNumberSeparators);
    const std::optional<double> number = line.number();
    if (!number) {
      return false;
    }
    numbers[i] = *number;
  }
  return true;
}

}  // namespace

void readMovement(ViewCommandContext& context, files::Movement::Kind kind) {
  const std::string name = kind == files::Movement::Kind::Tropism ? "tropism" : "torque";
  const core::SourceRange range = context.lexer.commandRange();
  const auto drop = [&](const std::string& message, const std::string& hint = {}) {
    context.report.warn(range, "the " + name + " is dropped: " + message, hint);
  };
  files::Movement movement;
  movement.kind = kind;
  std::optional<core::Vec3> given;
  double intensity = 0.0;
  bool hasIntensity = false;
  files::TextCursor line = context.lexer.line();
  for (line.skip(kNumberSeparators); !line.atEnd(); line.skip(kNumberSeparators)) {
    const std::string found = line.found();
    const char key = line.peek();
    // the key is the first letter of a word; its numbers may follow without a blank
    while (!line.atEnd() &&
           ((line.peek() >= 'A' && line.peek() <= 'Z') || (line.peek() >= 'a' && line.peek() <= 'z'))) {
      line.setPosition(line.position() + 1);
    }
    std::array<double, 3> numbers{};
    const int count = key == 'T' ? 3 : 1;
    if (std::string_view("TAIES").find(key) == std::string_view::npos) {
      return drop("expected T, A, I, E or S, found " + found, "write it as 'T: 0,1,0 A: 0 I: 1 E: 0.2 S: 0'");
    }
    if (!readNumbers(line, numbers.data(), count)) {
      return drop("expected " + std::string(count == 3 ? "three numbers" : "a number") + " after '" + key +
                  "', found " + line.found());
    }
    switch (key) {
      case 'T':
        given = core::Vec3{numbers[0], numbers[1], numbers[2]};
        hasIntensity = false;  // an intensity before the direction is lost
        break;
      case 'A':
        movement.angleDegrees = numbers[0];
        break;
      case 'I':
        intensity = numbers[0];
        hasIntensity = true;
        break;
      case 'E':
        movement.elasticity = numbers[0];
        break;
      default:
        movement.elasticityStep = numbers[0];
        break;
    }
  }
  if (!given) {
    return drop("it has no direction", "begin with 'T: x,y,z'");
  }
  const double length = core::length(*given);
  if (!(length > 0.0) || (hasIntensity && intensity == 0.0)) {
    return drop(length > 0.0 ? "its intensity is 0" : "its direction has no length");
  }
  // the reference scales the given direction, not its unit vector, and never lengthens it
  const double factor = hasIntensity ? std::clamp(intensity / length, -1.0, 1.0) : 1.0 / length;
  movement.direction = *given * factor;
  if (context.isCompatible() && context.settings().movements.size() >= kReferenceMovements) {
    return drop("the reference program has at most 10 movements");
  }
  context.settings().movements.push_back(movement);
}

}  // namespace espalier::language
