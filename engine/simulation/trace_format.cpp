#include "engine/simulation/trace_format.h"

#include "engine/core/hash.h"
#include "engine/simulation/byte_reader.h"
#include "engine/simulation/byte_writer.h"

namespace espalier::simulation {
namespace {

std::uint32_t folded(std::uint64_t hash) {
  return static_cast<std::uint32_t>(hash ^ (hash >> 32U));
}

void write(ByteWriter& writer, const std::vector<core::Vec3>& vectors) {
  writer.number64(vectors.size());
  for (const core::Vec3& v : vectors) {
    writer.real(v.x);
    writer.real(v.y);
    writer.real(v.z);
  }
}

std::vector<core::Vec3> readVectors(ByteReader& reader) {
  std::vector<core::Vec3> vectors(reader.count(24));
  for (core::Vec3& v : vectors) {
    v.x = reader.real();
    v.y = reader.real();
    v.z = reader.real();
  }
  return vectors;
}

template <typename T>
void writeIntegers(ByteWriter& writer, const std::vector<T>& numbers) {
  writer.number64(numbers.size());
  for (const T number : numbers) {
    if constexpr (sizeof(T) == 1) {
      writer.byte(number);
    } else if constexpr (sizeof(T) == 2) {
      writer.number16(number);
    } else if constexpr (sizeof(T) == 4) {
      writer.number32(number);
    } else {
      writer.number64(number);
    }
  }
}

template <typename T>
std::vector<T> readIntegers(ByteReader& reader) {
  std::vector<T> numbers(reader.count(sizeof(T)));
  for (T& number : numbers) {
    if constexpr (sizeof(T) == 1) {
      number = reader.byte();
    } else if constexpr (sizeof(T) == 2) {
      number = reader.number16();
    } else if constexpr (sizeof(T) == 4) {
      number = reader.number32();
    } else {
      number = reader.number64();
    }
  }
  return numbers;
}

void write(ByteWriter& writer, const std::vector<turtle::EnvironmentVariable>& variables) {
  writer.number64(variables.size());
  for (const turtle::EnvironmentVariable& variable : variables) {
    writer.text(variable.name);
    writer.text(variable.unit);
    writer.text(variable.type);
  }
}

std::vector<turtle::EnvironmentVariable> readVariables(ByteReader& reader) {
  std::vector<turtle::EnvironmentVariable> variables(reader.count(24));
  for (turtle::EnvironmentVariable& variable : variables) {
    variable.name = reader.text();
    variable.unit = reader.text();
    variable.type = reader.text();
  }
  return variables;
}

constexpr std::array<bool turtle::EnvironmentNeeds::*, 9> kNeeds{
    &turtle::EnvironmentNeeds::position,   &turtle::EnvironmentNeeds::heading,   &turtle::EnvironmentNeeds::left,
    &turtle::EnvironmentNeeds::up,         &turtle::EnvironmentNeeds::width,     &turtle::EnvironmentNeeds::scale,
    &turtle::EnvironmentNeeds::parameters, &turtle::EnvironmentNeeds::following, &turtle::EnvironmentNeeds::geometry};

void write(ByteWriter& writer, const turtle::World& world) {
  writer.text(world.lengthUnit);
  write(writer, {world.up, world.north});
  writer.real(world.stepDurationDays);
  for (const auto& angle : {world.latitudeDegrees, world.longitudeDegrees}) {
    writer.flag(angle.has_value());
    writer.real(angle.value_or(0.0));
  }
  writer.text(world.start);
}

void readEventWorld(ByteReader& reader, turtle::World& world) {
  world.lengthUnit = reader.text();
  const std::vector<core::Vec3> directions = readVectors(reader);
  if (directions.size() == 2) {
    world.up = directions[0];
    world.north = directions[1];
  }
  world.stepDurationDays = reader.real();
  for (auto* angle : {&world.latitudeDegrees, &world.longitudeDegrees}) {
    const bool isGiven = reader.flag();
    const double value = reader.real();
    *angle = isGiven ? std::optional<double>(value) : std::nullopt;
  }
  world.start = reader.text();
}

bool readStart(ByteReader& reader, TraceEvent& event) {
  event.snapshot = reader.text();
  event.hasEnvironment = reader.flag();
  turtle::EnvironmentDescription& description = event.description;
  description.name = reader.text();
  description.summary = reader.text();
  for (const auto need : kNeeds) {
    description.needs.*need = reader.flag();
  }
  description.inputs = readVariables(reader);
  description.outputs = readVariables(reader);
  description.isStateful = reader.flag();
  event.context.simulation = reader.text();
  event.context.plantCount = reader.number32();
  event.context.symbols.resize(reader.count(8));
  for (std::string& symbol : event.context.symbols) {
    symbol = reader.text();
  }
  event.context.seed = reader.number64();
  readEventWorld(reader, event.context.world);
  return true;
}

/// Offsets that rise from 0 to the number of parameters.
bool areOffsets(const std::vector<std::uint64_t>& offsets, std::size_t count, std::size_t parameterCount) {
  if (offsets.size() != count + 1 || offsets.front() != 0 || offsets.back() != parameterCount) {
    return false;
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (offsets[i] > offsets[i + 1]) {
      return false;
    }
  }
  return true;
}

bool readStep(ByteReader& reader, TraceEvent& event) {
  turtle::QueryBatch& queries = event.queries;
  queries.step = reader.number64();
  queries.iteration = reader.number32();
  queries.timeDays = reader.real();
  queries.plant = readIntegers<std::uint32_t>(reader);
  queries.module = readIntegers<std::uint64_t>(reader);
  queries.symbol = readIntegers<core::SymbolId>(reader);
  queries.isTransient = readIntegers<std::uint8_t>(reader);
  for (auto* column : {&queries.position, &queries.heading, &queries.left, &queries.up}) {
    *column = readVectors(reader);
  }
  queries.width = reader.reals();
  queries.scale = reader.reals();
  queries.parameterOffset = readIntegers<std::uint64_t>(reader);
  queries.parameters = reader.reals();
  queries.following = readIntegers<core::SymbolId>(reader);
  queries.followingOffset = readIntegers<std::uint64_t>(reader);
  queries.followingParameters = reader.reals();
  event.replies.values = reader.reals();
  event.replies.isSet = readIntegers<std::uint8_t>(reader);
  event.replies.surplusCount = reader.number64();
  event.replyChecks = readIntegers<std::uint32_t>(reader);
  event.step = queries.step;

  // columns are whole or empty
  const std::size_t count = queries.size();
  const auto isColumn = [count](std::size_t size) { return size == count || size == 0; };
  return queries.module.size() == count && queries.symbol.size() == count && isColumn(queries.isTransient.size()) &&
         isColumn(queries.position.size()) && isColumn(queries.heading.size()) && isColumn(queries.left.size()) &&
         isColumn(queries.up.size()) && isColumn(queries.width.size()) && isColumn(queries.scale.size()) &&
         areOffsets(queries.parameterOffset, count, queries.parameters.size()) && isColumn(queries.following.size()) &&
         (queries.following.empty() ||
          areOffsets(queries.followingOffset, count, queries.followingParameters.size())) &&
         event.replies.values.size() == queries.parameters.size() &&
         event.replies.isSet.size() == queries.parameters.size() && event.replyChecks.size() == count;
}

}  // namespace

std::string encodeStart(const std::string& snapshot, const turtle::EnvironmentDescription* description,
                        const turtle::EnvironmentContext& context) {
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(TraceEventKind::Start));
  writer.text(snapshot);
  writer.flag(description != nullptr);
  const turtle::EnvironmentDescription none;
  const turtle::EnvironmentDescription& said = description == nullptr ? none : *description;
  writer.text(said.name);
  writer.text(said.summary);
  for (const auto need : kNeeds) {
    writer.flag(said.needs.*need);
  }
  write(writer, said.inputs);
  write(writer, said.outputs);
  writer.flag(said.isStateful);
  writer.text(context.simulation);
  writer.number32(context.plantCount);
  writer.number64(context.symbols.size());
  for (const std::string& symbol : context.symbols) {
    writer.text(symbol);
  }
  writer.number64(context.seed);
  write(writer, context.world);
  return writer.bytes();
}

std::string encodeStep(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) {
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(TraceEventKind::Step));
  writer.number64(queries.step);
  writer.number32(queries.iteration);
  writer.real(queries.timeDays);
  writeIntegers(writer, queries.plant);
  writeIntegers(writer, queries.module);
  writeIntegers(writer, queries.symbol);
  writeIntegers(writer, queries.isTransient);
  for (const auto* column : {&queries.position, &queries.heading, &queries.left, &queries.up}) {
    write(writer, *column);
  }
  writer.reals(queries.width);
  writer.reals(queries.scale);
  writeIntegers(writer, queries.parameterOffset);
  writer.reals(queries.parameters);
  writeIntegers(writer, queries.following);
  writeIntegers(writer, queries.followingOffset);
  writer.reals(queries.followingParameters);
  writer.reals(replies.values);
  writeIntegers(writer, replies.isSet);
  writer.number64(replies.surplusCount);
  writer.number64(queries.size());
  for (std::size_t query = 0; query < queries.size(); ++query) {
    writer.number32(checkOfReply(queries, replies, query));
  }
  return writer.bytes();
}

std::string encodeTick(std::uint64_t step) {
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(TraceEventKind::Tick));
  writer.number64(step);
  return writer.bytes();
}

std::string encodeFailure(std::uint64_t step, std::string_view message) {
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(TraceEventKind::Failure));
  writer.number64(step);
  writer.text(message);
  return writer.bytes();
}

std::string encodeComplete(const Simulation& simulation) {
  ByteWriter writer;
  writer.byte(static_cast<std::uint8_t>(TraceEventKind::Complete));
  writer.number64(simulation.completedSteps());
  writer.number64(simulation.plantsHash());
  writer.number64(simulation.plantCount());
  for (std::size_t plant = 0; plant < simulation.plantCount(); ++plant) {
    writeIntegers(writer, pieceHashesOf(simulation.program(plant), simulation.string(plant)));
  }
  return writer.bytes();
}

bool decodeEvent(std::string_view content, TraceEvent& event) {
  ByteReader reader(content);
  const std::uint8_t kind = reader.byte();
  if (kind < static_cast<std::uint8_t>(TraceEventKind::Start) ||
      kind > static_cast<std::uint8_t>(TraceEventKind::Complete)) {
    return false;
  }
  event.kind = static_cast<TraceEventKind>(kind);
  bool isRight = true;
  switch (event.kind) {
    case TraceEventKind::Start:
      isRight = readStart(reader, event);
      break;
    case TraceEventKind::Step:
      isRight = readStep(reader, event);
      break;
    case TraceEventKind::Tick:
      event.step = reader.number64();
      break;
    case TraceEventKind::Failure:
      event.step = reader.number64();
      event.message = reader.text();
      break;
    case TraceEventKind::Complete:
      event.step = reader.number64();
      event.hash = reader.number64();
      event.pieceHashes.resize(reader.count(8));
      for (auto& hashes : event.pieceHashes) {
        hashes = readIntegers<std::uint32_t>(reader);
      }
      break;
  }
  return isRight && !reader.hasFailed() && reader.remaining() == 0;
}

std::uint32_t checkOfReply(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies, std::size_t query) {
  core::Hasher hasher;
  for (std::uint64_t k = queries.parameterOffset[query]; k < queries.parameterOffset[query + 1]; ++k) {
    hasher.integer(replies.isSet[k]);
    hasher.number(replies.values[k]);
  }
  return folded(hasher.value());
}

std::vector<std::uint32_t> pieceHashesOf(const language::Program& program, const derivation::ModuleString& string) {
  std::vector<std::uint32_t> hashes;
  const auto types = string.types();
  const auto parameters = string.parameters();
  std::size_t parameter = 0;
  core::Hasher hasher;
  for (std::size_t module = 0; module < types.size(); ++module) {
    hasher.integer(types[module]);
    const std::size_t end = parameter + program.arity[types[module]];
    for (; parameter < end; ++parameter) {
      hasher.number(parameters[parameter]);
    }
    if ((module + 1) % kTracePieceModules == 0 || module + 1 == types.size()) {
      hashes.push_back(folded(hasher.value()));
      hasher = core::Hasher();
    }
  }
  return hashes;
}

}  // namespace espalier::simulation
