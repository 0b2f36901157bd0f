#include "environment/geometry/box_note.h"

#include <algorithm>
#include <limits>

#include "environment/base/number_text.h"

namespace espalier::environment {
namespace {

bool isClose(double place, double low, double high) {
  const double margin = 0.1 * (high - low);
  return !(high < std::numeric_limits<double>::infinity()) || (place >= low - margin && place <= high + margin);
}

}  // namespace

void noteIfAllAreOutside(std::string_view process, const Bounds& box, const std::string& lengthUnit,
                         const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) {
  const auto isNear = [&](const core::Vec3& place) {
    return isClose(place.x, box.low.x, box.high.x) && isClose(place.y, box.low.y, box.high.y) &&
           isClose(place.z, box.low.z, box.high.z);
  };
  if (queries.size() == 0 || std::any_of(queries.position.begin(), queries.position.end(), isNear)) {
    return;
  }
  std::string extent;
  const auto add = [&](const char* axis, double low, double high) {
    if (high < std::numeric_limits<double>::infinity()) {
      extent += (extent.empty() ? "" : ", ") + (axis + (" from " + numberText(low))) + " to " + numberText(high);
    }
  };
  add("x", box.low.x, box.high.x);
  add("y", box.low.y, box.high.y);
  add("z", box.low.z, box.high.z);
  replies.notes.push_back("environment '" + std::string(process) + "': no query of the step lies in its box (" +
                          extent + " " + lengthUnit +
                          "), so all are answered as outside of it. Move or enlarge the box, or move the plants");
}

}  // namespace espalier::environment
