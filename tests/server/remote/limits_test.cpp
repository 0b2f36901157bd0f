#include "server/remote/limits.h"

#include <gtest/gtest.h>

#include <set>

namespace espalier::server::limits_test {
namespace {

TEST(Limits, EachHasANameOfItsOwnAndIsSetByIt) {
  std::set<std::string_view> names;
  for (const LimitEntry& entry : limitEntries()) {
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    ServerLimits limits;
    EXPECT_GE(entry.get(limits), entry.minimum) << entry.name;
    EXPECT_EQ(setLimit(limits, entry.name, entry.minimum), std::nullopt);
    EXPECT_EQ(entry.get(limits), entry.minimum) << entry.name;
    EXPECT_EQ(setLimit(limits, entry.name, entry.maximum), std::nullopt);
    EXPECT_EQ(entry.get(limits), entry.maximum) << entry.name;
    // no other limit has changed
    ServerLimits back;
    entry.set(limits, entry.get(back));
    for (const LimitEntry& other : limitEntries()) {
      EXPECT_EQ(other.get(limits), other.get(back)) << entry.name << " changed " << other.name;
    }
  }
}

TEST(Limits, AMessageNamesALimitAsTheOptionDoes) {
  const auto named = [](std::string_view message) {
    const LimitEntry* entry = limitNamedIn(message);
    return entry == nullptr ? std::string_view() : entry->name;
  };
  EXPECT_EQ(named("the string has more than 9 modules (limit modules). The simulation stays at step 3."), "modules");
  EXPECT_EQ(named("more than 2 brackets are open, the limit turtleStack. Raise the limit if"), "turtleStack");
  EXPECT_EQ(named("a limit of time: the limit loopIterations"), "loopIterations");
  EXPECT_EQ(named("a limit of the modules"), "");
  EXPECT_EQ(named("the limit"), "");
}

TEST(Limits, AValueOutOfRangeIsRefusedWithTheRange) {
  ServerLimits limits;
  EXPECT_EQ(setLimit(limits, "sessions=0").value_or(""),
            "the limit sessions (peers at a time that have said hello) must be from 1 to 4294967295, not 0.");
  EXPECT_EQ(setLimit(limits, "sessions=4294967296").value_or(""),
            "the limit sessions (peers at a time that have said hello) must be from 1 to 4294967295, not 4294967296.");
  EXPECT_EQ(setLimit(limits, "callSeconds=0"), std::nullopt);
  EXPECT_EQ(limits.callSeconds, 0U);
}

TEST(Limits, WhatIsNoLimitIsRefusedWithAnExampleOrTheNearestName) {
  ServerLimits limits;
  for (const std::string_view text :
       {"sessions", "sessions=", "sessions=-1", "sessions=1e3", "sessions=99999999999999999999"}) {
    EXPECT_EQ(setLimit(limits, text).value_or(""),
              "'" + std::string(text) +
                  "' is not a limit; write NAME=NUMBER with a whole number, for example modules=1000000.");
  }
  EXPECT_EQ(setLimit(limits, "session=3").value_or("").substr(0, 58),
            "there is no limit 'session'. Did you mean 'sessions'? Avai");
}

}  // namespace
}  // namespace espalier::server::limits_test
