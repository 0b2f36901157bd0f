#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>

#include "engine/files/images/image_file.h"
#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

constexpr std::string_view kTextureSeparators = " \t\r:";
constexpr std::size_t kMostTextures = 20;
constexpr std::array<std::string_view, 6> kMinifications{"n", "l", "mnn", "mln", "mnl", "mll"};

std::string_view nextWord(files::TextCursor& line) {
  line.skip(kTextureSeparators);
  const std::size_t begin = line.position();
  while (!line.atEnd() && kTextureSeparators.find(line.peek()) == std::string_view::npos) {
    line.setPosition(line.position() + 1);
  }
  return line.textBetween(begin, line.position());
}

bool setMinification(files::Texture& texture, std::string_view value) {
  const auto* const found = std::ranges::find(kMinifications, value == "m" ? "mll" : value);
  if (found == kMinifications.end()) {
    return false;
  }
  texture.minification = *found;
  return true;
}

bool setUse(files::Texture& texture, char value) {
  const std::size_t index = std::string_view("mdb").find(value);
  if (index != std::string_view::npos) {
    texture.use = static_cast<files::Texture::Use>(index);
  }
  return index != std::string_view::npos;
}

/// A texture from the words of its line: the key is the first letter of a word, its value the next word.
tl::expected<files::Texture, std::string> readTextureLine(files::TextCursor line) {
  files::Texture texture;
  for (std::string_view key = nextWord(line); !key.empty(); key = nextWord(line)) {
    if (key.front() == 'S') {
      texture.isPerSurface = true;
      continue;
    }
    if (std::string_view("FHLER").find(key.front()) == std::string_view::npos) {
      return tl::unexpected("expected F, H, L, E, S or R, found '" + std::string(key.substr(0, 40)) + "'");
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
        files::TextCursor number(value);
        texture.ratio = number.number().value_or(0.0);
        isGood = texture.ratio > 0.0;
        break;
      }
      default:
        break;
    }
    if (!isGood) {
      return tl::unexpected("'" + value.substr(0, 40) + "' is not a value of " + std::string(1, key.front()));
    }
  }
  if (texture.file.empty()) {
    return tl::unexpected<std::string>("it names no file (F)");
  }
  return texture;
}

}  // namespace

void readTexture(ViewCommandContext& context) {
  const core::SourceRange range = context.lexer.commandRange();
  std::vector<files::Texture>& textures = context.settings().textures;
  const std::string name = "texture " + std::to_string(textures.size() + 1);
  const auto line = readTextureLine(context.lexer.line());
  if (textures.size() >= kMostTextures) {
    return context.report.warn(range, "a view file has at most 20 textures; this one is ignored");
  }
  files::Texture texture = line.value_or(files::Texture{});
  if (!line) {
    context.report.warn(range, name + " is dropped: " + line.error(),
                        "write it as 'texture: F bark.png H l L m E m R 2'");
  } else if (std::optional<files::SourceMap::File> file =
                 openBytes(context, range, texture.file, "surfaces with it are plain")) {
    auto image = files::readImageFile(file->name, file->text);
    if (!image) {
      context.report.warn(range, "the picture '" + file->name + "' of " + name + " cannot be used: " + image.error() +
                                     "; surfaces with it are plain");
    } else if (image->pixels.size() / 4 > context.remainingTexturePixels) {
      context.report.warn(range, "the pictures of the view file have more than " +
                                     std::to_string(files::kMostImagePixels) + " pixels: '" + file->name +
                                     "' is not used; surfaces with it are plain");
    } else {
      context.remainingTexturePixels -= image->pixels.size() / 4;
      texture.bytes = std::make_shared<const std::string>(std::move(file->text));
      texture.image = std::make_shared<const files::Image>(std::move(*image));
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
