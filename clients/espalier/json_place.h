#pragma once

#include <string>
#include <string_view>

namespace espalier::command {

/// ":LINE:COLUMN" of the member that a path such as `plants[0].turn` names in a JSON text; of the object around it when
/// the text lacks the member. Empty: the text is not one JSON value. O(text).
[[nodiscard]] std::string jsonPlace(std::string_view text, std::string_view path);

}  // namespace espalier::command
