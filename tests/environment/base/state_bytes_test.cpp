#include "environment/base/state_bytes.h"

#include <gtest/gtest.h>

namespace espalier::environment::state_bytes_test {
namespace {

TEST(StateBytes, ReadBackWhatWasWritten) {
  StateWriter writer;
  writer.integer(7);
  writer.number(-0.1);
  writer.text("abc");
  const std::string bytes = writer.take();
  StateReader reader(bytes);
  EXPECT_EQ(reader.integer(), 7U);
  EXPECT_EQ(reader.number(), -0.1);
  EXPECT_EQ(reader.text(), "abc");
  EXPECT_TRUE(reader.isComplete());
}

TEST(StateBytes, CutOffStateIsNoticed) {
  StateWriter writer;
  writer.text("abc");
  const std::string bytes = writer.take();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    StateReader reader(std::string_view(bytes).substr(0, size));
    EXPECT_EQ(reader.text(), "");
    EXPECT_FALSE(reader.isIntact()) << size;
  }
}

}  // namespace
}  // namespace espalier::environment::state_bytes_test
