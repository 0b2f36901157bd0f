#include "clients/espalier/reference_switches.h"

#include <algorithm>
#include <array>

namespace espalier::command {
namespace {

struct Switch {
  std::string_view name;
  bool takesNumber;  // digits may follow without a blank
  std::string_view advice;
};

constexpr std::string_view kOutput = "write -o and a file name: its suffix chooses the format, as in -o plant.png";
constexpr std::string_view kWindow = "leave it out, there is no window; --size 800x600 is the size of a picture";
constexpr std::string_view kNoEffect = "leave it out, it has no effect here";

constexpr std::array kSwitches = {
    Switch{"-m", true, "leave it out: the colour map is the .map file beside the model, or that of a model folder"},
    Switch{"-M", true, "leave it out: the materials are the .mat file beside the model, or that of a model folder"},
    Switch{"-e", false, "write --environment FILE.e"},
    Switch{"-g", false, "write --compat cpfg-batch, and -o for the output"},
    Switch{"-homo", false, "leave it out: strings are written before homomorphism"},
    Switch{"-c", true, "leave it out: colours are numbered as in a model folder"},
    Switch{"-s", true, kNoEffect},
    Switch{"-rmode", false, kNoEffect},
    Switch{"-v", false, kNoEffect},
    Switch{"-V", false, kNoEffect},
    Switch{"-d", false, kNoEffect},
    Switch{"-str", false, "write -o FILE.string"},
    Switch{"-strb", false, "write -o FILE.string"},
    Switch{"-ps", false, "write -o FILE.ps"},
    Switch{"-obj", false, "write -o FILE.obj"},
    Switch{"-rgb", false, kOutput},
    Switch{"-ras", false, kOutput},
    Switch{"-tga", false, kOutput},
    Switch{"-ray", false, kOutput},
    Switch{"-gls", false, kOutput},
    Switch{"-vv", false, kOutput},
    Switch{"-w", false, kWindow},
    Switch{"-wr", false, kWindow},
    Switch{"-wp", false, kWindow},
    Switch{"-wpr", false, kWindow},
    Switch{"-wt", false, kWindow},
    Switch{"-wnb", false, kWindow},
    Switch{"-wnm", false, kWindow},
    Switch{"-P", false, "leave it out: the preprocessor is built in"},
    Switch{"-mb", false, kWindow},
};

}  // namespace

std::string adviceForReferenceSwitch(std::string_view word) {
  const std::size_t end = std::min(word.find_first_of("0123456789"), word.size());
  const std::string_view name = word.substr(0, end);
  const bool isNumbered = end < word.size();
  if (isNumbered && word.find_first_not_of("0123456789", end) != std::string_view::npos) {
    return {};
  }
  const auto found = std::ranges::find_if(
      kSwitches, [&](const Switch& known) { return known.name == name && (known.takesNumber || !isNumbered); });
  return found == kSwitches.end() ? std::string()
                                  : "'" + std::string(word) + "' is a switch of cpfg: " + std::string(found->advice);
}

std::string adviceForCompanion(std::string_view word) {
  const auto give = [&](std::string_view option) {
    return "give '" + std::string(word) + "' with its option: " + std::string(option) + " " + std::string(word);
  };
  if (word.starts_with('-')) {
    return {};
  }
  if (word.ends_with(".v")) {
    return give("--view");
  }
  if (word.ends_with(".e")) {
    return give("--environment");
  }
  if (word.ends_with(".map") || word.ends_with(".mat")) {
    return "'" + std::string(word) + "' is not named: the file beside the model with the model's name is used";
  }
  return {};
}

}  // namespace espalier::command
