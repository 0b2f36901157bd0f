#include "environment/base/loaded_library.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/core/simulation_error.h"

namespace espalier::environment::loaded_library_test {
namespace {

std::string failureOf(const LoadedLibrary& library, const char* function) {
  try {
    static_cast<void>(library.find(function));
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().code, core::SimulationErrorCode::EnvironmentFailed);
    return failure.error().message;
  }
  return "";
}

TEST(LoadedLibrary, FindsFunctionsOfALibraryOfTheSystem) {
  const LoadedLibrary library("libm.so.6", "libc6");
  const auto floor = reinterpret_cast<double (*)(double)>(library.find("floor"));
  EXPECT_EQ(floor(2.75), 2.0);
  EXPECT_EQ(library.find("floor"), reinterpret_cast<void*>(floor));
}

TEST(LoadedLibrary, SaysWhichLibraryIsMissingAndWhatToInstall) {
  const std::string message = failureOf(LoadedLibrary("libmissing.so.7", "libmissing7"), "cbrt");
  EXPECT_NE(message.find("The library libmissing.so.7 cannot be loaded ("), std::string::npos) << message;
  EXPECT_NE(message.find("No such file"), std::string::npos) << message;
  EXPECT_NE(message.find("Install libmissing7 (Debian)."), std::string::npos) << message;
}

TEST(LoadedLibrary, SaysWhichFunctionIsMissing) {
  const std::string message = failureOf(LoadedLibrary("libm.so.6", "libc6"), "cube_root");
  EXPECT_NE(message.find("cube_root"), std::string::npos) << message;
}

}  // namespace
}  // namespace espalier::environment::loaded_library_test
