#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/language/inference/step_strings.h"

namespace espalier::language {

/// One production for each symbol of StepStrings::names: its successor, or nothing when the symbol occurs only in the
/// last string, which does not determine it.
struct D0lSystem {
  std::vector<std::optional<std::vector<std::uint16_t>>> successors;

  bool operator==(const D0lSystem&) const = default;
};

enum class InferenceOutcome : std::uint8_t {
  One,        // exactly one system derives the strings
  Several,    // at least two systems derive them
  None,       // no system derives them
  Undecided,  // the search was stopped; `systems` may hold a system that was found, others may exist
};

struct InferenceOptions {
  bool isBracketed = true;               // '[' and ']' are replaced by themselves, successors are balanced
  std::vector<std::uint16_t> constants;  // further symbols that are replaced by themselves
  bool mayErase = true;                  // successors may be empty
  std::size_t systemLimit = 8;           // the search ends when this number is found (at least 2)
  std::function<bool()> mayContinue;     // called often; false stops the search. Empty: it never stops
};

struct Inference {
  InferenceOutcome outcome = InferenceOutcome::Undecided;
  // at most systemLimit; those first in which turtle symbols stay as they are, then those that erase least, then the
  // shortest
  std::vector<D0lSystem> systems;
  bool hasAll = false;          // no further system exists
  std::size_t firstMisfit = 0;  // of None: the first string that no system derives together with the strings before it
};

/// Finds the D0L-systems that derive each string from the previous one: the inference problem of L-systems (Rozenberg &
/// Salomaa 1980, "The mathematical theory of L systems", II.3).
///
/// The lengths of its successors determine a system, because they show which part of the next string each symbol
/// became. The lengths solve one linear equation for each step: occurrences times lengths is the next length. A search
/// finds the lengths that the equations do not determine: from both ends of the strings inwards, with intervals for the
/// lengths. A production is fixed as soon as its length is known. Exact: One and None are proofs. At worst exponential
/// in the number of symbols, hence `mayContinue`.
[[nodiscard]] Inference inferD0l(const StepStrings& steps, const InferenceOptions& options);

/// The string after one step of a system; nothing when it has a symbol without a production.
[[nodiscard]] std::optional<std::vector<std::uint16_t>> deriveOnce(const D0lSystem& system,
                                                                   std::span<const std::uint16_t> string);

}  // namespace espalier::language
