#include "engine/core/check.h"

#include <gtest/gtest.h>

#include <string>

namespace espalier::core::check_test {
namespace {

TEST(Check, SaysExpressionPlaceAndValues) {
  try {
    const int count = 3;
    ESPALIER_CHECK_VALUES(count == 4, "count = " + std::to_string(count));
    FAIL() << "must throw";
  } catch (const InternalError& error) {
    EXPECT_EQ(std::string(error.what()),
              "internal error: 'count == 4' does not hold at tests/engine/core/check_test.cpp:13 (count = 3)");
  }
}

TEST(Check, PassesSilently) {
  EXPECT_NO_THROW(ESPALIER_CHECK(1 + 1 == 2));
}

}  // namespace
}  // namespace espalier::core::check_test
