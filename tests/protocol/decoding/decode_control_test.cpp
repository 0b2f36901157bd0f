#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "tests/protocol/decoding/problem.h"

namespace espalier::protocol::decode_control_test {
namespace {

Payload params(const std::string& text) {
  return decodeMessage(R"({"jsonrpc":"2.0","id":1,"method":"m","params":)" + text + "}").value().payload;
}

TEST(DecodeControl, NamesThePathOfWhatIsWrong) {
  EXPECT_EQ(problem(decodeStepParams(params(R"({"simulation":"a","steps":0})"))),
            "params.steps: expected a whole number from 1 to 9007199254740992, found 0");
  EXPECT_EQ(problem(decodeStepParams(params(R"({"steps":1})"))), "params.simulation: expected a text, found nothing");
  EXPECT_EQ(problem(decodeStepParams(params(R"({"simulation":"a","steps":1,"until":2})"))),
            "params.steps: give \"steps\" or \"until\", not both");
  EXPECT_EQ(problem(decodeStepParams({})), "params: expected an object, found nothing");
  EXPECT_EQ(problem(decodeCreateParams(params(R"({"model":{"source":"x"},"environment":[{"type":"a"},{"typ":"b"}]})"))),
            "params.environment[1].type: expected a text, found nothing");
  EXPECT_EQ(problem(decodeCreateParams(params(R"({"model":{"source":"x"},"plants":[{"position":[1,2]}]})"))),
            "params.plants[0].position: expected three numbers, found an array");
  EXPECT_EQ(problem(decodeHelloParams(params(R"({"protocol":[1],"roles":["king"]})"))),
            "params.roles[0]: expected \"controller\", \"environment\" or \"viewer\", found \"king\"");
  EXPECT_EQ(problem(decodeGetParams(params(R"({"simulation":"a","what":"all"})"))),
            "params.what: expected one of string, statistics, state-hash, turtle, model, information, checkpoints, "
            "traces, trace, palette, explanation, environment, productions, found \"all\"");
  EXPECT_EQ(problem(decodeGetParams(params(R"({"simulation":"a","what":"explanation"})"))),
            "params.module: expected a whole number from 0 to 9007199254740992, found nothing");
  EXPECT_EQ(problem(decodeEditorParams(params(R"({"message":{}})"))),
            "params.message: expected a text, found an object");
  EXPECT_EQ(problem(decodeReadModelParams(params(R"({"gallery":7})"))), "params.gallery: expected a text, found 7");
  EXPECT_EQ(problem(decodeRestoreParams(params(R"({"simulation":"a","snapshot":"!"})"))),
            "params.snapshot: expected base64, as simulation.save gave it");
}

TEST(DecodeControl, AModelComesFromExactlyOnePlace) {
  const std::string expected =
      "params.model: expected exactly one of \"source\", \"gallery\", \"files\" and \"loaded\"";
  EXPECT_EQ(problem(decodeModelParams(params(R"({"model":{}})"))), expected);
  EXPECT_EQ(problem(decodeModelParams(params(R"({"model":{"source":"a","gallery":"b"}})"))), expected);
  EXPECT_EQ(problem(decodeModelParams(params(R"({"model":{"files":{"a.l":"x"},"main":"b.l"}})"))),
            "params.model.main: 'b.l' is not one of the files");
  // a folder without a main file; bytes come in base64
  const auto folder = decodeModelParams(params(R"({"model":{"files":{"a.l":"x"},"binaryFiles":{"a.map":"AAEC"}}})"));
  EXPECT_EQ(folder.value().model.files.at("a.map"), std::string("\0\1\2", 3));
  EXPECT_EQ(folder.value().model.main, "");
  const auto entry = decodeModelParams(params(R"({"model":{"files":{"a.l":"x"},"main":"a.l:Second"}})"));
  EXPECT_EQ(entry.value().model.main, "a.l:Second");
  EXPECT_EQ(problem(decodeModelParams(params(R"({"model":{"files":{},"binaryFiles":{"a":"!"}}})"))),
            "params.model.binaryFiles.a: expected base64, found \"!\"");
  EXPECT_EQ(decodeModelParams(params(R"({"model":"model-1"})")).value().model.loaded, "model-1");
  EXPECT_EQ(decodeModelParams(params(R"({"source":"x"})")).value().model.source, "x");
}

TEST(DecodeControl, ReadsACompleteCreate) {
  const auto create =
      decodeCreateParams(
          params(
              R"({"model":{"source":"x"},"seed":7.0,"environment":[{"type":"honda","radius":0.5}],"derivationLength":3,
          "plants":[{"position":[1,2,3]}],"parameters":{"R":0.5,"NAME":"x"},"limits":{"modules":10},"save":false,"new":1})"))
          .value();
  EXPECT_EQ(create.seed, 7U);
  EXPECT_EQ(create.environmentTypes, std::vector<std::string>{"honda"});
  EXPECT_EQ(create.environmentJson, R"([{"radius":0.5,"type":"honda"}])");
  EXPECT_EQ(create.derivationLength, 3U);
  EXPECT_EQ(create.plants.at(0).position[2], 3.0);
  EXPECT_EQ(create.maximumModules, 10U);
  EXPECT_FALSE(create.save.isKept);
  EXPECT_EQ(create.model.defines, (std::vector<std::pair<std::string, std::string>>{{"NAME", "x"}, {"R", "0.5"}}));
}

TEST(DecodeControl, SeedsBeyondExactIntegersAreRefused) {
  EXPECT_EQ(problem(decodeResetParams(params(R"({"simulation":"a","seed":9007199254740993})"))),
            "params.seed: expected a whole number from 0 to 9007199254740992, found 9007199254740993");
  EXPECT_EQ(problem(decodeResetParams(params(R"({"simulation":"a","seed":-1})"))),
            "params.seed: expected a whole number from 0 to 9007199254740992, found -1");
}

}  // namespace
}  // namespace espalier::protocol::decode_control_test
