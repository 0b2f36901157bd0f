#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// How one turtle item travels as text: a printf format with up to three conversions %f %F %e %E %g %G, with flags,
/// width and precision, and any text around them. Text before the first conversion is skipped by the reader.
class TurtleFormat {
 public:
  /// Reads a format. A format without a conversion, or with another conversion than the above, is an error in one
  /// sentence. Conversions after the first `maximumCount` are dropped, because no reader takes them.
  [[nodiscard]] static tl::expected<TurtleFormat, std::string> parse(std::string_view format, std::size_t maximumCount);

  /// The number that arrives when `value` is sent as number `k` of the item; 0 when the format has no such conversion.
  /// The sender prints a 32-bit float, and the receiver reads one.
  [[nodiscard]] double exchanged(std::size_t k, double value) const;
  /// The same for the three coordinates.
  [[nodiscard]] core::Vec3 exchanged(const core::Vec3& vector) const;
  [[nodiscard]] std::size_t conversionCount() const { return conversions_.size(); }

 private:
  std::vector<std::string> conversions_;  // "%.4f", one each
};

/// The turtle items that an `.e` file sends. An absent item is not sent and arrives as zeros.
struct TurtleFormats {
  std::optional<TurtleFormat> position;
  std::optional<TurtleFormat> heading;
  std::optional<TurtleFormat> left;
  std::optional<TurtleFormat> up;
  std::optional<TurtleFormat> width;
  std::optional<TurtleFormat> scale;
  bool isFollowingSent = true;  // the module after the communication module, with its parameters
};

/// A process behind the text coupling of cpfg, as in the compatible modes: turtle items go through their formats,
/// parameters and replies through %g, all of them through 32-bit floats, and time passes only in steps with queries
/// (tick() does nothing). State, name and errors are those of the process inside. O(numbers exchanged) besides the
/// process.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeTextCoupling(
    std::unique_ptr<turtle::EnvironmentProcess> process, TurtleFormats formats);

}  // namespace espalier::environment
