#include "server/remote/translation/translate_environment.h"

#include <algorithm>
#include <cstring>

#include "engine/core/message_text.h"
#include "server/remote/translation/translate_geometry.h"

namespace espalier::server {
namespace {

static_assert(sizeof(core::Vec3) == 3 * sizeof(double), "columns of vectors are columns of numbers");

std::span<const double> numbersOf(const std::vector<core::Vec3>& vectors, std::size_t count, bool isNeeded) {
  return isNeeded && vectors.size() == count && count > 0
             ? std::span<const double>(reinterpret_cast<const double*>(vectors.data()), 3 * count)
             : std::span<const double>();
}

std::span<const double> numbersOf(const std::vector<double>& numbers, std::size_t count, bool isNeeded) {
  return isNeeded && numbers.size() == count ? std::span<const double>(numbers) : std::span<const double>();
}

std::vector<core::Vec3> vectorsOf(std::span<const double> numbers, std::size_t count, bool isNeeded) {
  std::vector<core::Vec3> vectors(isNeeded || !numbers.empty() ? count : 0);
  if (!numbers.empty()) {
    std::memcpy(static_cast<void*>(vectors.data()), numbers.data(), numbers.size_bytes());
  }
  return vectors;
}

std::vector<double> numbersFor(std::span<const double> numbers, std::size_t count, bool isNeeded) {
  return numbers.empty() ? std::vector<double>(isNeeded ? count : 0, 1.0)
                         : std::vector<double>(numbers.begin(), numbers.end());
}

/// The columns that had to be converted for the wire.
struct ConvertedQueries {
  std::vector<std::uint32_t> symbol, following;
};

}  // namespace

protocol::EnvironmentStepParams toStepParams(const std::string& simulation, const turtle::QueryBatch& queries,
                                             const protocol::NeedsRecord& needs,
                                             const std::vector<std::string>& symbols) {
  const std::size_t count = queries.size();
  protocol::EnvironmentStepParams params;
  params.simulation = simulation;
  params.step = queries.step;
  params.iteration = queries.iteration;
  params.timeDays = queries.timeDays;
  protocol::QueryColumns& columns = params.queries;
  columns.count = count;
  columns.plant = queries.plant;
  if (queries.module.size() == count) {
    columns.module = queries.module;
  }
  const bool hasTransient =
      queries.isTransient.size() == count &&
      std::find(queries.isTransient.begin(), queries.isTransient.end(), 1) != queries.isTransient.end();
  if (hasTransient) {
    columns.isTransient = queries.isTransient;
  }

  // the names of the context, and names that it does not have: of unknown symbols and of pairs (~x, @x)
  columns.symbols = symbols;
  const auto ownName = [&columns, &symbols](const std::string& name) {
    const auto begin = columns.symbols.begin() + static_cast<std::ptrdiff_t>(symbols.size());
    const auto found = std::find(begin, columns.symbols.end(), name);
    const auto id = static_cast<std::uint32_t>(found - columns.symbols.begin());
    if (found == columns.symbols.end()) {
      columns.symbols.push_back(name);
    }
    return id;
  };
  auto converted = std::make_shared<ConvertedQueries>();
  if (queries.symbol.size() == count) {
    converted->symbol.reserve(count);
    for (const core::SymbolId symbol : queries.symbol) {
      converted->symbol.push_back(symbol < symbols.size() ? symbol : ownName("?"));
    }
  } else {
    converted->symbol.assign(count, ownName("E"));
  }
  columns.symbol = converted->symbol;
  columns.offset = queries.parameterOffset;
  columns.parameters = queries.parameters;
  columns.position = numbersOf(queries.position, count, needs.position);
  columns.heading = numbersOf(queries.heading, count, needs.heading);
  columns.left = numbersOf(queries.left, count, needs.left);
  columns.up = numbersOf(queries.up, count, needs.up);
  columns.width = numbersOf(queries.width, count, needs.width);
  columns.scale = numbersOf(queries.scale, count, needs.scale);
  if (needs.following && queries.following.size() == count && count > 0) {
    converted->following.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      const core::SymbolId symbol = queries.following[i];
      const char pair = queries.followingPair.empty() ? '\0' : queries.followingPair[i];
      if (symbol == core::kNoSymbol) {
        converted->following.push_back(protocol::QueryColumns::kNoSymbol);
      } else if (symbol >= symbols.size()) {
        converted->following.push_back(ownName("?"));
      } else {
        converted->following.push_back(pair == '\0' ? symbol : ownName(pair + symbols[symbol]));
      }
    }
    columns.following = converted->following;
    columns.followingOffset = queries.followingOffset;
    columns.followingParameters = queries.followingParameters;
  }
  columns.owner = std::move(converted);
  return params;
}

turtle::QueryBatch toBatch(const protocol::EnvironmentStepParams& params, const turtle::EnvironmentNeeds& needs,
                           std::vector<std::string>& symbols) {
  const protocol::QueryColumns& columns = params.queries;
  const std::size_t count = columns.count;

  // the symbols of the params among those of the simulation
  const std::vector<core::SymbolId> ids = idsOf(columns.symbols, symbols);

  turtle::QueryBatch batch;
  batch.clear();
  batch.step = params.step;
  batch.iteration = params.iteration;
  batch.timeDays = params.timeDays;
  batch.plant.assign(columns.plant.begin(), columns.plant.end());
  if (columns.module.empty()) {
    batch.module.assign(count, 0);
  } else {
    batch.module.assign(columns.module.begin(), columns.module.end());
  }
  if (columns.isTransient.empty()) {
    batch.isTransient.assign(count, 0);
  } else {
    batch.isTransient.assign(columns.isTransient.begin(), columns.isTransient.end());
  }
  batch.symbol.reserve(count);
  for (const std::uint32_t symbol : columns.symbol) {
    batch.symbol.push_back(ids[symbol]);
  }
  batch.parameterOffset.assign(columns.offset.begin(), columns.offset.end());
  batch.parameters.assign(columns.parameters.begin(), columns.parameters.end());
  batch.position = vectorsOf(columns.position, count, needs.position);
  batch.heading = vectorsOf(columns.heading, count, needs.heading);
  batch.left = vectorsOf(columns.left, count, needs.left);
  batch.up = vectorsOf(columns.up, count, needs.up);
  batch.width = numbersFor(columns.width, count, needs.width);
  batch.scale = numbersFor(columns.scale, count, needs.scale);
  if (columns.following.empty()) {
    batch.following.assign(needs.following ? count : 0, core::kNoSymbol);
    batch.followingOffset.assign(count + 1, 0);
  } else {
    // the second character of a pair (~x, @x) is the symbol
    std::vector<char> pairs;
    std::vector<std::string> names;
    for (const std::string& name : columns.symbols) {
      pairs.push_back(name.size() > 1 && (name[0] == '~' || name[0] == '@') ? name[0] : '\0');
      names.push_back(pairs.back() == '\0' ? name : name.substr(1));
    }
    const std::vector<core::SymbolId> followingIds = idsOf(names, symbols);
    for (const std::uint32_t symbol : columns.following) {
      const bool isNone = symbol == protocol::QueryColumns::kNoSymbol;
      batch.following.push_back(isNone ? core::kNoSymbol : followingIds[symbol]);
      batch.followingPair.push_back(isNone ? '\0' : pairs[symbol]);
    }
    batch.followingOffset.assign(columns.followingOffset.begin(), columns.followingOffset.end());
    batch.followingParameters.assign(columns.followingParameters.begin(), columns.followingParameters.end());
  }
  return batch;
}

protocol::ReplyColumns toReplies(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) {
  protocol::ReplyColumns columns;
  columns.notes = replies.notes;
  const std::size_t count = queries.size();
  if (std::find(replies.isSet.begin(), replies.isSet.end(), 0) == replies.isSet.end()) {
    columns.count = count;
    columns.offset = queries.parameterOffset;
    columns.values = replies.values;
    return columns;
  }

  // only values that are set
  struct Storage {
    std::vector<std::uint32_t> id;
    std::vector<std::uint64_t> offset{0};
    std::vector<double> values;
    std::vector<std::uint8_t> isSet;
  };
  auto storage = std::make_shared<Storage>();
  bool hasUnset = false;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t begin = queries.parameterOffset[i];
    std::uint64_t end = queries.parameterOffset[i + 1];
    while (end > begin && replies.isSet[end - 1] == 0) {
      --end;
    }
    if (begin == end) {
      continue;
    }
    storage->id.push_back(static_cast<std::uint32_t>(i));
    for (std::uint64_t k = begin; k < end; ++k) {
      hasUnset = hasUnset || replies.isSet[k] == 0;
      storage->values.push_back(replies.isSet[k] != 0 ? replies.values[k] : 0.0);
      storage->isSet.push_back(replies.isSet[k]);
    }
    storage->offset.push_back(storage->values.size());
  }
  columns.count = storage->id.size();
  columns.id = storage->id;
  columns.offset = storage->offset;
  columns.values = storage->values;
  if (hasUnset) {
    columns.isSet = storage->isSet;
  }
  columns.owner = std::move(storage);
  return columns;
}

void applyReplies(const protocol::ReplyColumns& columns, const turtle::QueryBatch& queries,
                  turtle::ReplyBatch& replies) {
  for (std::size_t i = 0; i < columns.count; ++i) {
    const std::size_t query = columns.id.empty() ? i : columns.id[i];
    bool isAnswered = false;
    for (std::uint64_t k = columns.offset[i]; k < columns.offset[i + 1]; ++k) {
      if (columns.isSet.empty() || columns.isSet[k] != 0) {
        const std::uint64_t surplusBefore = replies.surplusCount;
        replies.set(queries, query, k - columns.offset[i], columns.values[k]);
        isAnswered = isAnswered || replies.surplusCount == surplusBefore;
      }
    }
    replies.answeredCount += isAnswered ? 1 : 0;
  }
  for (std::string note : columns.notes) {
    core::makePrintable(note);
    if (note.find_first_not_of(' ') != std::string::npos) {
      replies.notes.push_back(std::move(note));
    }
  }
}

}  // namespace espalier::server
