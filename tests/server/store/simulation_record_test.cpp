#include "server/store/simulation_record.h"

#include <gtest/gtest.h>

namespace espalier::server::simulation_record_test {
namespace {

TEST(SimulationRecord, ReadsWhatItWrote) {
  SimulationRecord record;
  record.id = "sim-1";
  record.seed = 1ULL << 53U;
  record.hasSeed = true;
  record.create.name = "bush \"1\"";
  record.create.environmentJson = R"([{"type":"honda","radius":0.5}])";
  record.create.derivationLength = 12;
  record.create.plants.emplace_back().position = {1.0, 2.0, 3.0};
  record.create.maximumModules = 1000;
  for (const protocol::SavePolicy save :
       {protocol::SavePolicy{true, 1}, protocol::SavePolicy{true, 10}, protocol::SavePolicy{true, 0}}) {
    record.create.save = save;
    const auto read = toRecord("sim-1", toText(record));
    ASSERT_TRUE(read.has_value()) << read.error();
    const auto& again = *read;
    EXPECT_EQ(again.id, "sim-1");
    EXPECT_EQ(again.seed, 1ULL << 53U);
    EXPECT_TRUE(again.hasSeed);
    EXPECT_EQ(again.create.name, record.create.name);
    EXPECT_EQ(again.create.derivationLength, 12U);
    EXPECT_EQ(again.create.plants.at(0).position[2], 3.0);
    EXPECT_EQ(again.create.maximumModules, 1000U);
    EXPECT_EQ(again.create.save.every, save.every);
    EXPECT_EQ(again.create.environmentTypes, std::vector<std::string>{"honda"});
  }
}

TEST(SimulationRecord, SaysWhatIsWrong) {
  for (const char* text : {"rubbish", "{}"}) {
    const auto read = toRecord("sim-1", text);
    ASSERT_FALSE(read.has_value()) << text;
    EXPECT_NE(read.error(), "") << text;
  }
}

}  // namespace
}  // namespace espalier::server::simulation_record_test
