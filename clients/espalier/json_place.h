#pragma once

#include <string>
#include <string_view>

namespace espalier::command {

/// ":LINE:COLUMN" of the member that a path such as `plants[0].turn` names in a JSON text; of the object around it when
/// the text lacks the member. Empty: the text is not one JSON value. O(text).
[[nodiscard]] std::string jsonPlace(std::string_view text, std::string_view path);

/// The same for an error about the object at `path`: the place of the first member that the message has in quotes, as
/// in "environment process 'honda': 'radius' must be …"; of the object when it quotes none.
[[nodiscard]] std::string jsonPlaceOfMessage(std::string_view text, const std::string& path, std::string_view message);

}  // namespace espalier::command
