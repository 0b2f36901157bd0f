#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "engine/files/image_file.h"
#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

constexpr std::string_view kTextureSeparators = " \t\r:";
constexpr std::size_t kMostTextures = 20;
constexpr std::array<std::string_view, 6> kMinifications{"n", "l", "mnn", "mln", "mnl", "mll"};

/// The words of a line: the key is the first letter of a word, its value the next word.
struct TextureLine {
  Texture texture;
  std::string problem;  // empty: none
};

std::string_view nextWord(TextCursor& line) {
  line.skip(kTextureSeparators);
  const std::size_t begin = line.position();
  while (!line.atEnd() && kTextureSeparators.find(line.peek()) == std::string_view::npos) {
    line.setPosition(line.position() + 1);
  }
  return line.textBetween(begin, line.position());
}

bool setMinification(Texture& texture, std::string_view value) {
  const auto* const found = std::ranges::find(kMinifications, value == "m" ? "mll" : value);
  if (found == kMinifications.end()) {
    return false;
  }
  texture.minification = *found;
  return true;
}

bool setUse(Texture& texture, char value) {
  const std::size_t index = std::string_view("mdb").find(value);
  if (index != std::string_view::npos) {
    texture.use = static_cast<Texture::Use>(index);
  }
  return index != std::string_view::npos;
}

TextureLine readLine(TextCursor line) {
  TextureLine result;
  Texture& texture = result.texture;
  for (std::string_view key = nextWord(line); !key.empty(); key = nextWord(line)) {
    if (key.front() == 'S') {
      texture.isPerSurface = true;
      continue;
    }
    if (std::string_view("FHLER").find(key.front()) == std::string_view::npos) {
      result.problem = "expected F, H, L, E, S or R, found '" + std::string(key.substr(0, 40)) + "'";
      return result;
    }
    const std::string value(nextWord(line));
    bool isGood = !value.empty();
    switch (isGood ? key.front() : '\0') {
      case 'F':
        texture.file = value;
        break;
      case 'H':
        isGood = value[0] == 'n' || value[0] == 'l';
        texture.isSmoothNear = value[0] == 'l';
        break;
      case 'L':
        isGood = setMinification(texture, value);
        break;
      case 'E':
        isGood = setUse(texture, value[0]);
        break;
      case 'R': {
        TextCursor number(value);
        texture.ratio = number.number().value_or(0.0);
        isGood = texture.ratio > 0.0;
        break;
      }
      default:
        break;
    }
    if (!isGood) {
      result.problem = "'" + value.substr(0, 40) + "' is no value of " + std::string(1, key.front());
      return result;
    }
  }
  result.problem = texture.file.empty() ? "it names no file (F)" : "";
  return result;
}

}  // namespace

void readTexture(ViewCommandContext& context) {
  const core::SourceRange range = context.lexer.commandRange();
  std::vector<Texture>& textures = context.settings().textures;
  const std::string name = "texture " + std::to_string(textures.size() + 1);
  auto [texture, problem] = readLine(context.lexer.line());
  if (textures.size() >= kMostTextures) {
    return context.report.warn(range, "a view file has at most 20 textures; this one is ignored");
  }
  if (!problem.empty()) {
    context.report.warn(range, name + " is dropped: " + problem, "write it as 'texture: F bark.png H l L m E m R 2'");
  } else if (std::optional<DataFile> file = openFile(context, range, texture.file, "what wears it is plain")) {
    auto read = readImageFile(file->name(), file->text());
    auto* const image = std::get_if<Image>(&read);
    if (image == nullptr) {
      context.report.warn(range, "the picture '" + file->name() + "' of " + name +
                                     " cannot be used: " + std::get<std::string>(read) + "; what wears it is plain");
    } else if (image->pixels.size() / 4 > context.remainingTexturePixels) {
      context.report.warn(range, "the pictures of the view file have more than " + std::to_string(kMostImagePixels) +
                                     " points: '" + file->name() + "' is not used; what wears it is plain");
    } else {
      context.remainingTexturePixels -= image->pixels.size() / 4;
      texture.bytes = std::make_shared<const std::string>(file->text());
      texture.image = std::make_shared<const Image>(std::move(*image));
    }
  }
  if (texture.image == nullptr) {
    context.addUnusable(UnusableFile::Kind::Texture, static_cast<int>(textures.size()) + 1, range, texture.file);
    if (context.isCompatible()) {
      return;  // the next texture takes its number
    }
  }
  textures.push_back(std::move(texture));
}

}  // namespace espalier::language
