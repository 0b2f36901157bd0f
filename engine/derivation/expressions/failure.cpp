#include "engine/derivation/expressions/failure.h"

#include <cmath>

#include "engine/core/message_text.h"

namespace espalier::derivation {

void fail(const language::Program& program, const FailurePlace& place, core::SimulationErrorCode code,
          const std::string& what, core::SourceRange range) {
  core::SimulationError error;
  error.code = code;
  error.step = place.step;
  error.plant = place.plant;
  if (range.begin < range.end) {
    error.location = program.sourceMap.locate(range);
  }
  std::string where;
  if (!error.location.file.empty()) {
    where = core::placeText(error.location);
  }

  std::string message = "step " + std::to_string(place.step) + ", plant " + std::to_string(place.plant);
  if (place.hasModule) {
    error.module = place.module;
    message += ", module " + std::to_string(place.module) + " ('" + std::string(program.nameOf(place.type)) + "'";
    message += where.empty() ? ")" : ", " + where + ")";
  } else if (!where.empty()) {
    message += " (" + where + ")";
  }
  message += ": " + what + ".";
  if (place.step > 0) {
    message += " The simulation stays at step " + std::to_string(place.step - 1) + ".";
  }
  error.message = std::move(message);
  throw core::SimulationFailure(std::move(error));
}

std::string sourceText(const language::Program& program, core::SourceRange range) {
  std::string text;
  bool isAfterBlank = true;
  for (std::size_t i = range.begin; i < range.end && i < program.text.size(); ++i) {
    const char c = program.text[i];
    const bool isBlank = c == ' ' || c == '\t' || c == '\n' || c == '\r';
    if (!isBlank) {
      text.push_back(c);
    } else if (!isAfterBlank) {
      text.push_back(' ');
    }
    isAfterBlank = isBlank;
  }
  while (!text.empty() && text.back() == ' ') {
    text.pop_back();
  }
  return text;
}

const char* nonFiniteName(double value) {
  return std::isnan(value) ? "NaN" : "infinite";
}

}  // namespace espalier::derivation
