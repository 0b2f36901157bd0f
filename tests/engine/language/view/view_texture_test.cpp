#include <gtest/gtest.h>

#include <map>
#include <string>

#include "engine/language/view/view_file.h"
#include "tests/engine/language/compile_text.h"

namespace espalier::language::view_texture_test {
namespace {

// one point, blue 3, green 2, red 1
const std::string kPoint = std::string("\0\0\2\0\0\0\0\0\0\0\0\0\1\0\1\0\x18\0", 18) + "\3\2\1";

ViewFileResult read(const std::string& text, core::Compatibility mode = core::Compatibility::Espalier) {
  core::MemoryFileProvider files({{"m/m.v", text}, {"m/a.tga", kPoint}, {"m/b.tga", kPoint}, {"m/bad.png", "?"}});
  return readViewFile("m/m.v", files, mode, {});
}

TEST(ViewTexture, AllWordsOfALineCount) {
  const ViewFileResult result =
      read("texture: F a.tga H l L mnl E d S R 2.5\ntexture: F: b.tga\ntexture: F a.tga L m Efast b\n");
  EXPECT_EQ(briefs(result.diagnostics), Messages{});
  const std::vector<files::Texture>& textures = result.settings.textures;
  ASSERT_EQ(textures.size(), 3U);
  EXPECT_EQ(textures[0].file, "a.tga");
  EXPECT_TRUE(textures[0].isSmoothNear);
  EXPECT_EQ(textures[0].minification, "mnl");
  EXPECT_EQ(textures[0].use, files::Texture::Use::Decal);
  EXPECT_TRUE(textures[0].isPerSurface);
  EXPECT_EQ(textures[0].ratio, 2.5);
  EXPECT_EQ(textures[0].image->pixels, (std::vector<std::uint8_t>{1, 2, 3, 255}));
  EXPECT_EQ(*textures[0].bytes, kPoint);
  EXPECT_FALSE(textures[1].isSmoothNear);
  EXPECT_EQ(textures[1].minification, "n");
  EXPECT_EQ(textures[1].use, files::Texture::Use::Modulate);
  EXPECT_EQ(textures[1].ratio, 1.0);
  EXPECT_EQ(textures[2].minification, "mll");
  EXPECT_EQ(textures[2].use, files::Texture::Use::Blend);
  // snapshots carry the pictures
  EXPECT_EQ(result.sources.size(), 3U);
}

TEST(ViewTexture, AMistakeIsNamedAndTheNumberStaysTaken) {
  const ViewFileResult result = read(
      "texture: F a.tga Q 1\ntexture: H n\ntexture: F a.tga H x\ntexture: F a.tga R 0\n"
      "texture: F none.png\ntexture: F bad.png\ntexture: F b.tga\n");
  const std::string hint = " | write it as 'texture: F bark.png H l L m E m R 2'";
  EXPECT_EQ(briefs(result.diagnostics),
            (Messages{"1:1: warning: texture 1 is dropped: expected F, H, L, E, S or R, found 'Q'" + hint,
                      "2:1: warning: texture 2 is dropped: it names no file (F)" + hint,
                      "3:1: warning: texture 3 is dropped: 'x' is not a value of H" + hint,
                      "4:1: warning: texture 4 is dropped: '0' is not a value of R" + hint,
                      "5:1: warning: the file 'm/none.png' cannot be read; surfaces with it are plain | the file is "
                      "looked for beside the view file",
                      "6:1: warning: the picture 'm/bad.png' of texture 6 cannot be used: the format is unknown; use "
                      "PNG, JPEG, SGI (.rgb), Utah (.rle), PNM or TGA; surfaces with it are plain"}));
  ASSERT_EQ(result.settings.textures.size(), 7U);
  EXPECT_EQ(result.settings.textures[5].image, nullptr);
  EXPECT_NE(result.settings.textures[6].image, nullptr);
  EXPECT_EQ(result.unusable.size(), 6U);
  // in the reference the next texture takes the number
  const ViewFileResult reference = read("texture: F none.png\ntexture: F b.tga\n", core::Compatibility::Cpfg);
  ASSERT_EQ(reference.settings.textures.size(), 1U);
  EXPECT_EQ(reference.settings.textures[0].file, "b.tga");
}

TEST(ViewTexture, ThereAreAtMostTwenty) {
  std::string text;
  for (int i = 0; i < 21; ++i) {
    text += "texture: F a.tga\n";
  }
  const ViewFileResult result = read(text);
  EXPECT_EQ(result.settings.textures.size(), 20U);
  EXPECT_EQ(briefs(result.diagnostics),
            Messages{"21:1: warning: a view file has at most 20 textures; this one is ignored"});
}

}  // namespace
}  // namespace espalier::language::view_texture_test
