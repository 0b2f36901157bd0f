#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

bool isLetter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/// The first letter of the next word, passed with the rest of the word; 0 when none is next.
char takeKey(files::TextCursor& line) {
  line.skip(kNumberSeparators);
  const char key = isLetter(line.peek()) ? line.peek() : '\0';
  while (isLetter(line.peek())) {
    line.setPosition(line.position() + 1);
  }
  return key;
}

/// The numbers that a light's letter takes; 0: the letter is unknown.
int argumentCount(char key) {
  switch (key) {
    case 'O':
    case 'V':
    case 'A':
    case 'D':
    case 'S':
    case 'T':
      return 3;
    case 'P':
      return 5;
    default:
      return 0;
  }
}

void setPart(files::Light& light, char key, const std::array<double, 5>& n) {
  const core::Vec3 three{n[0], n[1], n[2]};
  switch (key) {
    case 'O':
    case 'V':
      light.isDirectional = key == 'V';
      light.place = three;
      return;
    case 'A':
      light.ambient = three;
      return;
    case 'D':
      light.diffuse = three;
      return;
    case 'S':
      light.specular = three;
      return;
    case 'T':
      light.attenuation = three;
      return;
    default:
      light.spotDirection = three;
      light.spotExponent = n[3];
      light.spotCutoffDegrees = n[4];
      return;
  }
}

}  // namespace

void readLight(ViewCommandContext& context) {
  const core::SourceRange range = context.lexer.commandRange();
  files::Light light;
  files::TextCursor line = context.lexer.line();
  for (line.skip(kNumberSeparators); !line.atEnd(); line.skip(kNumberSeparators)) {
    const std::string found = line.found();
    const char key = takeKey(line);
    const int count = argumentCount(key);
    if (count == 0) {
      context.report.warn(range, "the light is dropped: expected O, V, A, D, S, P or T, found " + found,
                          "write it as 'V: 1,2,2 D: 1,1,1'");
      return;
    }
    std::array<double, 5> numbers{};
    for (int i = 0; i < count; ++i) {
      line.skip(kNumberSeparators);
      const std::optional<double> number = line.number();
      if (!number) {
        context.report.warn(range, "the light is dropped: expected " + std::to_string(count) + " numbers after '" +
                                       key + "', found " + line.found());
        return;
      }
      numbers[static_cast<std::size_t>(i)] = *number;
    }
    setPart(light, key, numbers);
  }
  if (light.isDirectional && !(core::length(light.place) > 0.0)) {
    context.report.warn(range, "the light is dropped: its direction has no length");
    return;
  }
  context.settings().lights.push_back(light);
}

}  // namespace espalier::language
