#include "server/running/environment_builder.h"

#include <gtest/gtest.h>

namespace espalier::server::environment_builder_test {
namespace {

TEST(ReadableEnvironment, HasProcessesOfTheServerAsTheyWereGiven) {
  EXPECT_EQ(readableEnvironment(R"([{"type":"honda","radius":0.5},{"type":"light","name":"sun"}])"),
            R"([{"type":"honda","radius":0.5},{"type":"light","name":"sun"}])");
}

TEST(ReadableEnvironment, KeepsAddressesAndCommandsToItself) {
  EXPECT_EQ(readableEnvironment(R"([{"type":"tcp","address":"10.0.0.7:4000","key":"secret"},
                                    {"type":"stdio","name":"soil","command":"./soil --password x"},
                                    {"type":"offered","name":"mylight","token":"secret"}])"),
            R"([{"type":"tcp"},{"type":"stdio","name":"soil"},{"type":"offered","name":"mylight"}])");
}

TEST(ReadableEnvironment, IsAnEmptyListWithoutEnvironment) {
  EXPECT_EQ(readableEnvironment(""), "[]");
}

}  // namespace
}  // namespace espalier::server::environment_builder_test
