// A server takes a model folder as the command line does.

#include "server/store/model_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "server/remote/disk_files.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::model_store_test {
namespace {

constexpr const char* kModel = "Lsystem: 1\nderivation length: 9\nAxiom: A\nA --> FA\nendlsystem\n";

// 256 times one colour
std::string colourMap(char red, char green, char blue) {
  std::string map;
  for (int i = 0; i < 256; ++i) {
    map += {red, green, blue};
  }
  return map;
}

std::map<std::string, std::string> publishedFolder() {
  return {{"specifications", "p.l\np.v\nignore:\n*\nmodel:\n\tgenerate:\n\t\tcpfg -m p.map p.l other.v p.a -a\n"},
          {"p.l", kModel},
          {"other.v", "angle factor: 4\ninitial line width: 0.5\n"},
          {"p.a", "first frame: 1\nlast frame: 4\nstep: 1\n"},
          {"p.map", colourMap(10, 120, 30)}};
}

class Models : public testing::Test {
 protected:
  CompiledModel compiled(const protocol::ModelParams& params) {
    auto made = models_.compile(params, {});
    if (!made) {
      ADD_FAILURE() << made.error().message;
      return {};
    }
    return *std::move(made);
  }
  Store store_{""};
  ModelStore models_{"", store_};
};

TEST_F(Models, AFolderFromTheWireHasItsViewColoursAndLastFrame) {
  protocol::ModelParams params;
  params.model.files = publishedFolder();
  const CompiledModel model = compiled(params);
  ASSERT_NE(model.result.program, nullptr);
  EXPECT_EQ(model.result.program->view.initialLineWidth, 0.5) << "of the view file that the specifications name";
  EXPECT_EQ(model.palette.colour(7).green, 120);
  EXPECT_EQ(model.lastStep, 4U);
}

TEST_F(Models, AMainFileHasTheFilesOfItsName) {
  protocol::ModelParams params;
  params.model.files = {{"a.l", kModel}, {"a.v", "initial line width: 0.25\n"}, {"a.map", colourMap(1, 2, 3)}};
  params.model.files["a.json"] = R"({"type":"height"})";
  params.model.main = "a.l";
  const CompiledModel model = compiled(params);
  EXPECT_EQ(model.result.program->view.initialLineWidth, 0.25);
  EXPECT_EQ(model.palette.colour(200).blue, 3);
  EXPECT_EQ(model.environmentJson, R"([{"type":"height"}])");
  EXPECT_EQ(model.lastStep, std::nullopt);
}

TEST_F(Models, AFolderWithoutAModelIsRefused) {
  protocol::ModelParams params;
  params.model.files = {{"readme.txt", "nothing"}};
  const auto made = models_.compile(params, {});
  ASSERT_FALSE(made.has_value());
  EXPECT_NE(made.error().message.find("holds no L-system file (.l)"), std::string::npos);
}

TEST_F(Models, MessagesAboutTheGalleryDoNotSayWhereItIs) {
  const TemporaryFolder gallery;
  const std::filesystem::path path = gallery.path();
  std::filesystem::create_directories(path / "broken");
  std::filesystem::create_directories(path / "empty");
  std::ofstream(path / "broken" / "broken.l") << "Lsystem: 1\nAxiom: A(\nendlsystem\n";
  const ModelStore models(gallery.path(), store_);
  protocol::ModelParams params;
  params.model.gallery = "broken";
  const auto made = models.compile(params, {});
  const auto& entries = made.value().result.diagnostics.entries();
  ASSERT_FALSE(entries.empty());
  EXPECT_EQ(entries[0].location.file, "broken/broken.l");
  params.model.gallery = "empty";
  const auto missing = models.compile(params, {});
  ASSERT_FALSE(missing.has_value());
  EXPECT_EQ(missing.error().message,
            "The gallery model 'empty' cannot be used: the folder 'empty' holds no L-system file (.l): give another "
            "folder, or the file itself. model.list names the models of the gallery: NAME/FILE:ENTRY.");
}

}  // namespace
}  // namespace espalier::server::model_store_test
