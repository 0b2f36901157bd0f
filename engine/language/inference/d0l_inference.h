#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/language/inference/step_strings.h"

namespace espalier::language {

/// One production for each symbol of StepStrings::names: its successor, or nothing where the symbol occurs in the last
/// string only, which says nothing about it.
struct D0lSystem {
  std::vector<std::optional<std::vector<std::uint16_t>>> successors;

  bool operator==(const D0lSystem&) const = default;
};

enum class InferenceOutcome : std::uint8_t {
  One,        // exactly one system gives the strings
  Several,    // at least two do
  None,       // none does
  Undecided,  // the search was given up; `systems` may hold one that was found, others may exist
};

struct InferenceOptions {
  bool isBracketed = true;               // '[' and ']' are replaced by themselves, successors are balanced
  std::vector<std::uint16_t> constants;  // further symbols that are replaced by themselves
  bool mayErase = true;                  // successors may be empty
  std::size_t systemLimit = 8;           // the search ends when so many are found (at least 2)
  std::function<bool()> mayContinue;     // asked often; false gives the search up. Empty: never
};

struct Inference {
  InferenceOutcome outcome = InferenceOutcome::Undecided;
  // at most systemLimit; those first in which turtle symbols stay as they are, then those that erase least, then the
  // shortest
  std::vector<D0lSystem> systems;
  bool hasAll = false;          // no further system exists
  std::size_t firstMisfit = 0;  // of None: the first string that no system makes together with those before it
};

/// Finds the D0L-systems that derive each string from the one before: the inference problem of L-systems (Rozenberg &
/// Salomaa 1980, "The mathematical theory of L systems", II.3).
///
/// A system is determined by the lengths of its successors, because they say which part of the next string each symbol
/// became. The lengths solve the linear equations "occurrences times lengths is the next length", one a step; what
/// these leave open is searched from both ends of the strings inwards, with intervals for the lengths and a production
/// fixed as soon as its length is known. Exact: One and None are proofs. Exponential in the number of symbols at worst,
/// hence `mayContinue`.
[[nodiscard]] Inference inferD0l(const StepStrings& steps, const InferenceOptions& options);

/// The string after one step of a system; nothing when it has a symbol without a production.
[[nodiscard]] std::optional<std::vector<std::uint16_t>> deriveOnce(const D0lSystem& system,
                                                                   std::span<const std::uint16_t> string);

}  // namespace espalier::language
