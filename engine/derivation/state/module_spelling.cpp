#include "engine/derivation/state/module_spelling.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace espalier::derivation {
namespace {

constexpr std::size_t kMostPairTypes = 63;  // module types for which a table of pairs stays in the nearest cache

}  // namespace

char* NumberTexts::write(char* out, double value) {
  constexpr std::uint64_t kMix = 0x9E3779B97F4A7C15;  // 2^64 over the golden ratio
  const auto bits = std::bit_cast<std::uint64_t>(value);
  Entry& entry = entries_[(bits * kMix) >> (64 - kIndexBits)];
  if (entry.bits == bits) {
    std::memcpy(out, entry.text.data(), entry.text.size());
    return out + entry.size;
  }
  char* const end = core::writeNumber(out, value, style_);
  const auto size = static_cast<std::size_t>(end - out);
  if (size <= entry.text.size()) {
    entry.bits = bits;
    entry.size = static_cast<std::uint8_t>(size);
    std::memcpy(entry.text.data(), out, size);
  }
  return end;
}

ModuleSpelling::ModuleSpelling(const language::Program& program) : program_(&program) {
  bool areBytes = true;
  for (std::size_t type = 0; type < program.arity.size(); ++type) {
    const std::string_view name = program.nameOf(static_cast<core::ModuleTypeId>(type));
    Name spelled{.size = static_cast<std::uint32_t>(name.size()), .arity = program.arity[type]};
    name.copy(spelled.text.data(), kNameBytes);
    if (spelled.arity > 0) {
      if (spelled.size < kNameBytes) {
        spelled.text[spelled.size] = '(';
      }
      ++spelled.size;
    }
    names_.push_back(spelled);
    bytes_.push_back(name.empty() ? '\0' : name.front());
    areBytes = areBytes && (spelled.arity > 0 || name.size() == 1);
    longestName_ = std::max(longestName_, name.size());
  }
  if (!areBytes) {
    bytes_.clear();
  } else if (bytes_.size() <= kMostPairTypes) {
    pairShift_ = static_cast<unsigned>(std::bit_width(bytes_.size()));
    pairs_.resize(bytes_.size() << pairShift_);
    for (std::size_t second = 0; second < bytes_.size(); ++second) {
      for (std::size_t first = 0; first < bytes_.size(); ++first) {
        pairs_[first | (second << pairShift_)] = {bytes_[first], bytes_[second]};
      }
    }
  }
}

char* ModuleSpelling::write(char* out, std::span<const core::ModuleTypeId> types, std::span<const double> parameters,
                            NumberTexts& numbers) const {
  if (parameters.empty() && !bytes_.empty()) {
    return writeBytes(out, types);
  }
  const double* parameter = parameters.data();
  for (const core::ModuleTypeId type : types) {
    out = writeName(out, type);
    const std::uint32_t arity = names_[type].arity;
    if (arity > 0) {
      for (std::uint32_t i = 0; i < arity; ++i) {
        out = numbers.write(out, *parameter++);
        *out++ = ',';
      }
      out[-1] = ')';
    }
  }
  return out;
}

// of modules without parameters whose names are one byte each
char* ModuleSpelling::writeBytes(char* out, std::span<const core::ModuleTypeId> types) const {
  const char* const bytes = bytes_.data();
  const std::array<char, 2>* const pairs = pairs_.data();
  const core::ModuleTypeId* const modules = types.data();
  const std::size_t count = types.size();
  const unsigned shift = pairShift_;
  std::size_t i = 0;
  for (const std::size_t end = pairs_.empty() ? 0 : count - count % 2; i < end; i += 2) {
    std::memcpy(out + i, &pairs[modules[i] | (std::size_t{modules[i + 1]} << shift)], 2);
  }
  for (; i < count; ++i) {
    out[i] = bytes[modules[i]];
  }
  return out + count;
}

// a short name is a copy of fixed length: what is too much is overwritten
char* ModuleSpelling::writeName(char* out, core::ModuleTypeId type) const {
  const Name& name = names_[type];
  if (name.size <= kNameBytes) [[likely]] {
    std::memcpy(out, name.text.data(), kNameBytes);
  } else {
    const std::string_view whole = program_->nameOf(type);
    whole.copy(out, whole.size());
    if (name.arity > 0) {
      out[whole.size()] = '(';
    }
  }
  return out + name.size;
}

}  // namespace espalier::derivation
