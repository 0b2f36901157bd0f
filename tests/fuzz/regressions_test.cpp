#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>
#include <set>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/view/view_file.h"
#include "tests/fuzz/bundle.h"
#include "tests/fuzz/model_bundles.h"
#include "tests/fuzz/pieces.h"
#include "tests/fuzz/run_files.h"
#include "tests/fuzz/targets.h"
#include "tests/support/places.h"

namespace espalier::fuzz::regressions_test {
namespace {

// a finding ends the test program or throws
TEST(FuzzRegressions, EveryFormerFindingIsAnsweredNow) {
  for (const NamedTarget& target : kTargets) {
    const std::filesystem::path folder = std::filesystem::path(sourceFolder()) / "tests/fuzz/regressions" / target.name;
    if (!std::filesystem::exists(folder)) {
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      SCOPED_TRACE(entry.path().string());
      EXPECT_NO_THROW(target.run(contentOf(entry.path())));
    }
  }
}

// the seeds of the fuzzer of messages are right, and stay right through every way of writing them
TEST(FuzzRegressions, SeedsOfMessagesCrossTheWireUnchanged) {
  std::size_t count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(sourceFolder()) / "tests/fuzz/seeds/messages")) {
    SCOPED_TRACE(entry.path().string());
    const std::string bytes = contentOf(entry.path());
    EXPECT_NO_THROW(fuzzMessages(bytes));
    // one byte wrong anywhere is an answer, not a finding
    const std::size_t stride = std::max<std::size_t>(3, bytes.size() / 300);
    for (std::size_t i = 0; i < bytes.size(); i += stride) {
      std::string changed = bytes;
      changed[i] = static_cast<char>(changed[i] ^ (1 << (i % 8)));
      EXPECT_NO_THROW(fuzzMessages(changed)) << "byte " << i;
    }
    ++count;
  }
  EXPECT_GT(count, 5U);
}

/// The file with one byte of one of its pieces changed; the model, which is most of it, stays.
std::string withChangedByte(Pieces pieces, std::mt19937& random) {
  std::string& bytes = pieces.pieces[1 + random() % (pieces.pieces.size() - 1)].bytes;
  if (!bytes.empty()) {
    bytes[random() % bytes.size()] ^= static_cast<char>(1U << (random() % 8U));
  }
  return joinPieces(pieces);
}

void expectRunFilesAreAnswered(const RunFiles& files, const std::string& model, std::mt19937& random) {
  const auto snapshot = cutIntoPieces(files.snapshot);
  const auto trace = cutIntoPieces(files.trace);
  ASSERT_TRUE(snapshot && trace);
  EXPECT_EQ(joinPieces(*snapshot), files.snapshot);
  EXPECT_EQ(joinPieces(*trace), files.trace);
  EXPECT_NO_THROW(fuzzSnapshot(files.snapshot));
  EXPECT_NO_THROW(fuzzTrace(files.trace));
  EXPECT_NO_THROW(fuzzString(files.string + "\n" + bundleHead("model.l") + model));
  for (int round = 0; round < 10; ++round) {
    EXPECT_NO_THROW(fuzzSnapshot(withChangedByte(*snapshot, random))) << "round " << round;
  }
}

// the seeds of the fuzzers of stored runs: the files of a run of every small model here
TEST(FuzzRegressions, SnapshotsAndTracesWithAChangedByteAreAnswered) {
  std::mt19937 random(1);
  int runs = 0;
  for (const char* models : {"tests/conformance/cases", "clients/gallery"}) {
    for (const ModelBundle& bundle : modelBundles(std::filesystem::path(sourceFolder()) / models)) {
      for (const core::Compatibility mode : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
        SCOPED_TRACE(bundle.name);
        if (const auto files = bundle.text.empty() ? std::nullopt : runFilesOf(bundle.text, mode)) {
          expectRunFilesAreAnswered(*files, bundle.text, random);
          ++runs;
        }
      }
    }
  }
  EXPECT_GT(runs, 300);
}

TEST(FuzzRegressions, TargetsAcceptTextsWithoutMeaning) {
  for (const NamedTarget& target : kTargets) {
    SCOPED_TRACE(std::string(target.name));
    for (const std::string& text :
         {std::string(), std::string("\0\xff(", 3), std::string(2000, '('), std::string("Lsystem: 1")}) {
      EXPECT_NO_THROW(target.run(text));
    }
  }
}

std::string repeated(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) {
    result += text;
  }
  return result;
}

// deeper than any stack would hold if the readers called themselves for every level; fuzzers make no texts of this
// length
TEST(FuzzRegressions, DeepNestingIsRefusedNotFollowed) {
  constexpr int kDepth = 60'000;
  const auto withAxiom = [](const std::string& expression) {
    return "Lsystem: 1\nderivation length: 1\nAxiom: A(" + expression + ")\nA(x) --> A(x+1)\nendlsystem\n";
  };
  const std::string texts[] = {
      withAxiom(repeated("(", kDepth) + "1" + repeated(")", kDepth)),
      withAxiom(repeated("-", kDepth) + "1"),
      withAxiom(repeated("2^", kDepth) + "1"),
      withAxiom(repeated("1+", kDepth) + "1"),
      withAxiom(repeated("1?", kDepth) + "1"),
      withAxiom(repeated("(", kDepth)),
      "Lsystem: 1\nderivation length: 1\nAxiom: " + repeated("[", kDepth) + "F" + repeated("]", kDepth) +
          "\nF --> F\nendlsystem\n",
      "#if " + repeated("(", kDepth) + "1" + repeated(")", kDepth) + "\n#endif\n" + withAxiom("1"),
      "#if " + repeated("!", kDepth) + "1\n#endif\n" + withAxiom("1"),
      repeated("#if 1\n", kDepth / 4) + withAxiom("1") + repeated("#endif\n", kDepth / 4),
      "#define F(x) x\n" + withAxiom(repeated("F(", kDepth / 2) + "1" + repeated(")", kDepth / 2)),
  };
  for (const std::string& text : texts) {
    SCOPED_TRACE(text.substr(0, 80));
    for (const NamedTarget& target : kTargets) {
      EXPECT_NO_THROW(target.run(text));
    }
  }
}

// the seeds of the fuzzers of models and of forests, also with a changed byte
TEST(FuzzSeeds, FilesOfOtherProgramsAndForestsAreAnswered) {
  const std::filesystem::path gallery = std::filesystem::path(sourceFolder()) / "clients/gallery";
  std::mt19937 random(1);
  const auto answered = [&random](Target target, std::string text) {
    EXPECT_NO_THROW(target(text));
    for (int round = 0; round < 5 && !text.empty(); ++round) {
      text[random() % text.size()] ^= static_cast<char>(1U << (random() % 8U));
      EXPECT_NO_THROW(target(text)) << text;
    }
  };
  std::set<std::string_view> found;
  for (const NamedText& model : foreignModels(gallery)) {
    SCOPED_TRACE(model.name);
    core::MemoryFileProvider files;
    files.add("model.l", model.text);
    language::CompileInput input;
    input.modelFile = "model.l";
    const auto translated = language::translateForeign(input, files);
    ASSERT_TRUE(translated);
    found.insert(translated->dialect->name);
    answered(fuzzCompile, model.text);
    answered(fuzzDerivation, model.text);
  }
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(sourceFolder()) / "tests/fuzz/seeds/compile")) {
    SCOPED_TRACE(entry.path().string());
    core::MemoryFileProvider files;
    files.add("model.l", contentOf(entry.path()));
    language::CompileInput input;
    input.modelFile = "model.l";
    EXPECT_TRUE(language::compile(input, files).program != nullptr);
    const auto translated = language::translateForeign(input, files);
    ASSERT_TRUE(translated);
    found.insert(translated->dialect->name);
    answered(fuzzCompile, contentOf(entry.path()));
  }
  // every dialect that the program reads
  for (const language::Dialect& dialect : language::dialects()) {
    EXPECT_TRUE(found.contains(dialect.name)) << dialect.name;
  }
  const std::vector<NamedText> forests = forestBundles(gallery);
  EXPECT_GE(forests.size(), 2U);
  for (const NamedText& forest : forests) {
    SCOPED_TRACE(forest.name);
    answered(fuzzForest, forest.text);
  }
}

// a seed that is refused early teaches a fuzzer nothing
TEST(FuzzSeeds, TheViewFileWithEveryFormatIsReadWithoutAWarning) {
  core::MemoryFileProvider files =
      unbundle(contentOf(std::filesystem::path(sourceFolder()) / "tests/fuzz/seeds/view_file/every-format"), "model.v");
  const language::ViewFileResult result =
      language::readViewFile("model.v", files, core::Compatibility::Espalier, core::Limits{});
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    ADD_FAILURE() << core::formatDiagnostic(diagnostic);
  }
  EXPECT_EQ(result.settings.contours.size(), 2U);
  EXPECT_EQ(result.settings.functions.size(), 2U);
  EXPECT_EQ(result.settings.curves.size(), 2U);
  EXPECT_EQ(result.settings.surfaces.size(), 1U);
}

TEST(Bundle, SplitsATextIntoItsFiles) {
  core::MemoryFileProvider files =
      unbundle("main\n" + bundleHead("a.h") + "one\n" + bundleHead("b") + "two", "model.l");
  EXPECT_EQ(files.read("model.l"), "main\n");
  EXPECT_EQ(files.read("a.h"), "one\n");
  EXPECT_EQ(files.read("b"), "two");
  EXPECT_EQ(unbundle("", "model.l").read("model.l"), "");
}

}  // namespace
}  // namespace espalier::fuzz::regressions_test
