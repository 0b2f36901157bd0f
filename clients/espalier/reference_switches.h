#pragma once

#include <string>
#include <string_view>

namespace espalier::command {

/// What to write in the place of a switch of cpfg's command line, such as `-m2` or `-rmode`, which the commands of this
/// program do not have. Empty: the word is none.
[[nodiscard]] std::string adviceForReferenceSwitch(std::string_view word);

/// The option for a file of a model that was given as a word of its own, such as `tree.v`. Empty: none.
[[nodiscard]] std::string adviceForCompanion(std::string_view word);

}  // namespace espalier::command
