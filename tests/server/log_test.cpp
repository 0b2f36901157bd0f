#include "server/log.h"

#include <gtest/gtest.h>

namespace espalier::server::log_test {
namespace {

TEST(Log, ATextLineBeginsWithWhatItIsAbout) {
  EXPECT_EQ(logText("stopped", {}), "stopped");
  EXPECT_EQ(logText("closed", {.session = "3"}), "session 3: closed");
  EXPECT_EQ(logText("created", {.session = "3", .simulation = "sim-1"}), "session 3, simulation sim-1: created");
  EXPECT_EQ(logText("closed", {.session = "3", .token = "alice"}), "session 3 (alice): closed");
  EXPECT_EQ(logText("loaded", {.simulation = "sim-1"}), "simulation sim-1: loaded");
}

TEST(Log, APeersTextBeginsNoLine) {
  EXPECT_EQ(logText("a\n2026 error b\r", {}), "a 2026 error b ");
  EXPECT_EQ(logText("deleted", {.simulation = "x\n2026 error forged"}), "simulation x 2026 error forged: deleted");
  EXPECT_EQ(logText("\x1b[2J\x1b"
                    "Ea\tb\x7f",
                    {}),
            " [2J Ea b ");
  EXPECT_EQ(logText("a\u0085b\u2028c\u2029d", {}), "a b c d");
  EXPECT_EQ(logText("Kořeny ‘é’ 根", {}), "Kořeny ‘é’ 根");
  EXPECT_EQ(logText("deleted", {.simulation = std::string(1000, 'x')}),
            "simulation " + std::string(64, 'x') + ": deleted");
}

TEST(Log, AJsonLineHasMembers) {
  EXPECT_EQ(logMembers("said \"hi\"\n", {.session = "3", .simulation = "sim-1"}),
            R"("session":"3","simulation":"sim-1","message":"said \"hi\"\n")");
  EXPECT_EQ(logMembers("closed", {.session = "3", .token = "alice"}),
            R"("session":"3","token":"alice","message":"closed")");
  EXPECT_EQ(logMembers("stopped", {}), R"("message":"stopped")");
}

}  // namespace
}  // namespace espalier::server::log_test
