#include "engine/simulation/snapshot_content.h"

#include <algorithm>
#include <array>

#include "engine/core/hash.h"
#include "engine/core/work_meter.h"
#include "engine/simulation/byte_reader.h"
#include "engine/simulation/byte_writer.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/snapshot_check.h"
#include "engine/turtle/weather.h"

namespace espalier::simulation {

using core::Vec3;

namespace {

// a section is its tag, the length of its bytes and the bytes; unknown tags are skipped
enum class Section : std::uint32_t {
  Model = 1,
  Run = 2,
  Types = 3,
  Plant = 4,
  Environment = 5,
  Pending = 6,
  End = 7,
  Files = 8,
  Colours = 9,
  Coupling = 10,
  Forest = 11,
  World = 12
};
constexpr std::size_t kSectionCount = 13;  // tags below it

void writeVector(ByteWriter& writer, const Vec3& v) {
  writer.real(v.x);
  writer.real(v.y);
  writer.real(v.z);
}

Vec3 readVector(ByteReader& reader) {
  Vec3 v;
  v.x = reader.real();
  v.y = reader.real();
  v.z = reader.real();
  return v;
}

void writePairs(ByteWriter& writer, const std::vector<std::pair<std::string, std::string>>& pairs) {
  writer.number64(pairs.size());
  for (const auto& [first, second] : pairs) {
    writer.text(first);
    writer.text(second);
  }
}

std::vector<std::pair<std::string, std::string>> readPairs(ByteReader& reader) {
  std::vector<std::pair<std::string, std::string>> pairs(reader.count(16));
  for (auto& [first, second] : pairs) {
    first = reader.text();
    second = reader.text();
  }
  return pairs;
}

void writeModel(ByteWriter& writer, const SnapshotModel& model, core::Compatibility compatibility) {
  writer.text(model.modelFile);
  writer.text(model.viewFile);
  writer.byte(static_cast<std::uint8_t>(compatibility));
  writePairs(writer, model.defines);
  writePairs(writer, model.sources);
  writer.number64(model.programHash);
}

void readModel(ByteReader& reader, SnapshotModel& model, core::Compatibility& compatibility) {
  model.modelFile = reader.text();
  model.viewFile = reader.text();
  const std::uint8_t mode = reader.byte();
  if (mode > static_cast<std::uint8_t>(core::Compatibility::CpfgBatch)) {
    reader.fail();
  }
  compatibility = static_cast<core::Compatibility>(mode);
  model.defines = readPairs(reader);
  model.sources = readPairs(reader);
  model.programHash = reader.number64();
}

ByteWriter runSection(const SnapshotContent& content) {
  ByteWriter writer;
  writer.text(content.name);
  writer.number64(content.seed);
  writer.flag(content.hasSeed);
  writer.number64(content.derivationLength);
  writer.number64(content.completedSteps);
  writer.text(content.environmentName);
  writer.text(content.environmentOrigin.name);
  writePairs(writer, content.environmentOrigin.files);
  writer.number64(content.members.size());
  for (const Plant& member : content.members) {
    const turtle::PlantPlacement& placement = member.origin.placement;
    writeVector(writer, placement.position);
    writeVector(writer, placement.frame.heading);
    writeVector(writer, placement.frame.left);
    writeVector(writer, placement.frame.up);
  }
  return writer;
}

void readRun(ByteReader& reader, SnapshotContent& content) {
  content.name = reader.text();
  content.seed = reader.number64();
  content.hasSeed = reader.flag();
  content.derivationLength = reader.number64();
  content.completedSteps = reader.number64();
  content.environmentName = reader.text();
  content.environmentOrigin.name = reader.text();
  content.environmentOrigin.files = readPairs(reader);
  content.members.resize(reader.count(96));
  for (Plant& member : content.members) {
    turtle::PlantPlacement& placement = member.origin.placement;
    placement.position = readVector(reader);
    placement.frame.heading = readVector(reader);
    placement.frame.left = readVector(reader);
    placement.frame.up = readVector(reader);
  }
}

template <std::size_t Count>
void writeComponents(ByteWriter& writer, const std::array<double, Count>& components) {
  for (const double component : components) {
    writer.real(component);
  }
}

template <std::size_t Count>
void readComponents(ByteReader& reader, std::array<double, Count>& components) {
  for (double& component : components) {
    component = reader.real();
  }
}

ByteWriter coloursSection(const files::Palette& palette) {
  ByteWriter writer;
  writer.flag(palette.usesMaterials);
  writer.number32(static_cast<std::uint32_t>(palette.base));
  writer.number64(palette.maps.size());
  for (const auto& [block, colours] : palette.maps) {
    writer.number32(static_cast<std::uint32_t>(block));
    for (const files::PaletteColour& colour : colours) {
      writer.byte(colour.red);
      writer.byte(colour.green);
      writer.byte(colour.blue);
    }
  }
  writer.number64(palette.materials.size());
  for (const auto& [block, materials] : palette.materials) {
    writer.number32(static_cast<std::uint32_t>(block));
    for (const files::Material& material : materials) {
      writeComponents(writer, material.ambient);
      writeComponents(writer, material.diffuse);
      writeComponents(writer, material.emission);
      writeComponents(writer, material.specular);
      writer.real(material.opacity);
      writer.real(material.shininess);
    }
  }
  return writer;
}

void readColours(ByteReader& reader, files::Palette& palette) {
  constexpr std::uint64_t kSize = files::Palette::kBlockSize;
  palette.usesMaterials = reader.flag();
  palette.base = static_cast<int>(reader.number32());
  const std::uint64_t mapCount = reader.count(4 + 3 * kSize);
  for (std::uint64_t i = 0; i < mapCount; ++i) {
    auto& colours = palette.maps[static_cast<int>(reader.number32())];
    for (files::PaletteColour& colour : colours) {
      colour.red = reader.byte();
      colour.green = reader.byte();
      colour.blue = reader.byte();
    }
  }
  const std::uint64_t materialCount = reader.count(4 + 14 * 8 * kSize);
  for (std::uint64_t i = 0; i < materialCount; ++i) {
    auto& materials = palette.materials[static_cast<int>(reader.number32())];
    for (files::Material& material : materials) {
      readComponents(reader, material.ambient);
      readComponents(reader, material.diffuse);
      readComponents(reader, material.emission);
      readComponents(reader, material.specular);
      material.opacity = reader.real();
      material.shininess = reader.real();
    }
  }
}

void writeTypes(ByteWriter& writer, const SnapshotModel& model) {
  writer.number64(model.types.size());
  for (const auto& [name, arity] : model.types) {
    writer.text(name);
    writer.number16(arity);
  }
}

void readTypes(ByteReader& reader, SnapshotModel& model) {
  model.types.resize(reader.count(10));
  for (auto& [name, arity] : model.types) {
    name = reader.text();
    arity = reader.number16();
  }
}

/// Whether the run has something that version 1 cannot hold: more than one model and the places of plants.
bool isForest(const SnapshotContent& content) {
  return content.models.size() > 1 || content.seeds != SeedRules() ||
         std::any_of(content.members.begin(), content.members.end(), [](const Plant& member) {
           return member.birthStep != 0 || !member.isAlive() || !member.origin.name.empty() ||
                  member.origin.colourShift != 0;
         });
}

ByteWriter forestSection(const SnapshotContent& content) {
  ByteWriter writer;
  writer.number64(content.models.size() - 1);
  for (std::size_t i = 1; i < content.models.size(); ++i) {
    writeModel(writer, content.models[i], content.compatibility);
    writeTypes(writer, content.models[i]);
  }
  writer.number64(content.members.size());
  for (const Plant& member : content.members) {
    writer.number32(member.origin.model);
    writer.text(member.origin.name);
    writer.number32(static_cast<std::uint32_t>(member.origin.colourShift));
    writer.number64(member.birthStep);
    writer.number64(member.deathStep);
  }
  writer.number64(content.seeds.maximumPlants);
  writer.real(content.seeds.spacing);
  writer.real(content.seeds.ground);
  writer.flag(content.seeds.area.has_value());
  for (const Vec3& corner : content.seeds.area.value_or(std::array<Vec3, 2>{})) {
    writeVector(writer, corner);
  }
  return writer;
}

/// Whether the section fits the plants and models.
bool readForest(ByteReader& reader, SnapshotContent& content) {
  content.models.resize(1 + reader.count(48));
  for (std::size_t i = 1; i < content.models.size(); ++i) {
    core::Compatibility compatibility = content.compatibility;
    readModel(reader, content.models[i], compatibility);
    readTypes(reader, content.models[i]);
  }
  if (reader.count(32) != content.members.size()) {
    return false;
  }
  for (Plant& member : content.members) {
    member.origin.model = reader.number32();
    member.origin.name = reader.text();
    member.origin.colourShift = static_cast<std::int32_t>(reader.number32());
    member.birthStep = reader.number64();
    member.deathStep = reader.number64();
    if (member.origin.model >= content.models.size()) {
      return false;
    }
  }
  content.seeds.maximumPlants = reader.number64();
  content.seeds.spacing = reader.real();
  content.seeds.ground = reader.real();
  const bool hasArea = reader.flag();
  std::array<Vec3, 2> area;
  area[0] = readVector(reader);
  area[1] = readVector(reader);
  content.seeds.area = hasArea ? std::optional(area) : std::nullopt;
  return true;
}

ByteWriter plantSection(const derivation::PlantState& plant) {
  ByteWriter writer;
  writer.number64(plant.step);
  writer.number64(plant.derivationLength);
  writer.flag(plant.isStopped);
  writer.reals(plant.statics);
  writer.number64(plant.instances.size());
  for (const derivation::InstanceState& instance : plant.instances) {
    writer.number32(instance.system);
    writer.flag(instance.hasStarted);
    writer.reals(instance.variables);
    writer.reals(instance.elements);
  }
  writer.number64(plant.random.seed);
  writer.number64(plant.random.mainSeed);
  writer.number64(plant.random.selection.state());
  writer.number64(plant.random.main.state());
  writer.real(plant.random.normalCache);
  writer.real(plant.random.normalCacheFlag);
  writer.number64(plant.string.size());
  for (const core::ModuleTypeId type : plant.string.types()) {
    writer.number16(type);
  }
  writer.reals(plant.string.parameters());
  return writer;
}

derivation::PlantState readPlant(ByteReader& reader) {
  derivation::PlantState plant;
  plant.step = reader.number64();
  plant.derivationLength = reader.number64();
  plant.isStopped = reader.flag();
  plant.statics = reader.reals();
  plant.instances.resize(reader.count(21));
  for (derivation::InstanceState& instance : plant.instances) {
    instance.system = reader.number32();
    instance.hasStarted = reader.flag();
    instance.variables = reader.reals();
    instance.elements = reader.reals();
  }
  plant.random.seed = reader.number64();
  plant.random.mainSeed = reader.number64();
  plant.random.selection.setState(reader.number64());
  plant.random.main.setState(reader.number64());
  plant.random.normalCache = reader.real();
  plant.random.normalCacheFlag = reader.real();
  plant.string.typeBuffer().resize(reader.count(2));
  for (core::ModuleTypeId& type : plant.string.typeBuffer().span()) {
    type = reader.number16();
  }
  plant.string.parameterBuffer().resize(reader.count(8));
  for (double& parameter : plant.string.parameterBuffer().span()) {
    parameter = reader.real();
  }
  return plant;
}

bool hasFiles(const derivation::PlantState& plant) {
  return !plant.files.open.empty() || !plant.files.kept.empty();
}

ByteWriter filesSection(const derivation::FileState& files) {
  ByteWriter writer;
  writer.number64(files.open.size());
  for (const derivation::OpenFile& file : files.open) {
    writer.number32(file.file);
    writer.number16(file.mode.bits());
    writer.number64(file.position);
    writer.flag(file.isOpen);
  }
  writer.number64(files.kept.size());
  for (const derivation::KeptFile& file : files.kept) {
    writer.number32(file.file);
    writer.text(file.text);
  }
  return writer;
}

derivation::FileState readFiles(ByteReader& reader) {
  derivation::FileState files;
  files.open.resize(reader.count(15));
  for (derivation::OpenFile& file : files.open) {
    file.file = reader.number32();
    file.mode = language::FileMode::fromBits(reader.number16());
    file.position = reader.number64();
    file.isOpen = reader.flag();
  }
  files.kept.resize(reader.count(12));
  for (derivation::KeptFile& file : files.kept) {
    file.file = reader.number32();
    file.text = reader.text();
  }
  return files;
}

ByteWriter pendingSection(const SnapshotContent& content) {
  ByteWriter writer;
  writer.flag(content.isAnswered);
  writer.flag(content.hasReplies);
  writer.flag(content.hasTicked);
  writer.reals(content.replies.values);
  writer.number64(content.replies.isSet.size());
  for (const std::uint8_t isSet : content.replies.isSet) {
    writer.byte(isSet);
  }
  writer.number64(content.replies.answeredCount);
  writer.number64(content.replies.surplusCount);
  return writer;
}

void readPending(ByteReader& reader, SnapshotContent& content) {
  content.isAnswered = reader.flag();
  content.hasReplies = reader.flag();
  content.hasTicked = reader.flag();
  content.replies.values = reader.reals();
  content.replies.isSet.resize(reader.count(1));
  for (std::uint8_t& isSet : content.replies.isSet) {
    isSet = reader.byte();
  }
  content.replies.answeredCount = reader.number64();
  content.replies.surplusCount = reader.number64();
}

ByteWriter worldSection(const turtle::World& world) {
  ByteWriter writer;
  writer.text(world.lengthUnit);
  writeVector(writer, world.up);
  writeVector(writer, world.north);
  writer.real(world.stepDurationDays);
  for (const auto& angle : {world.latitudeDegrees, world.longitudeDegrees}) {
    writer.flag(angle.has_value());
    writer.real(angle.value_or(0.0));
  }
  writer.text(world.start);
  writer.real(world.baseTemperature);
  writer.text(world.weather ? world.weather->table() : std::string_view());
  return writer;
}

/// False: there can be no such world.
bool readWorld(ByteReader& reader, turtle::World& world) {
  world.lengthUnit = reader.text();
  world.up = readVector(reader);
  world.north = readVector(reader);
  world.stepDurationDays = reader.real();
  for (auto* angle : {&world.latitudeDegrees, &world.longitudeDegrees}) {
    const bool isKnown = reader.flag();
    const double degrees = reader.real();
    *angle = isKnown ? std::optional(degrees) : std::nullopt;
  }
  world.start = reader.text();
  world.baseTemperature = reader.real();
  std::string table(reader.text());
  if (reader.hasFailed() || turtle::problemOfWorld(world)) {
    return false;
  }
  if (table.empty()) {
    return true;
  }
  auto weather = turtle::Weather::read(std::move(table), world.start);
  if (weather) {
    world.weather = std::make_shared<const turtle::Weather>(std::move(*weather));
  }
  return weather.has_value();
}

// a sink that hashes the bytes that it passes on
class HashingSink {
 public:
  explicit HashingSink(core::ByteSink& sink) : sink_(&sink) {}
  void write(std::string_view bytes) {
    hasher_.bytes(bytes);
    sink_->write(bytes);
  }
  void writeSection(Section tag, const ByteWriter& body) {
    ByteWriter head;
    head.number32(static_cast<std::uint32_t>(tag));
    head.number64(body.bytes().size());
    write(head.bytes());
    write(body.bytes());
  }
  [[nodiscard]] std::uint64_t hash() const { return hasher_.value(); }

 private:
  core::ByteSink* sink_;
  core::Hasher hasher_;
};

tl::unexpected<core::SimulationError> refused(std::string message) {
  return tl::unexpected(snapshotError(std::move(message)));
}

tl::unexpected<core::SimulationError> cutOff() {
  return refused("The snapshot is cut off: it ends in the middle of a section. Use a complete copy of the file.");
}

tl::unexpected<core::SimulationError> damaged(const std::string& what) {
  return refused("The snapshot is damaged: " + what + ". Use an intact copy.");
}

/// Whether the last bytes are the checksum of everything before them.
bool hasItsChecksum(std::string_view snapshot) {
  constexpr std::size_t kChecksumBytes = 8;
  if (snapshot.size() < kChecksumBytes) {
    return false;
  }
  core::Hasher hasher;
  hasher.bytes(snapshot.substr(0, snapshot.size() - kChecksumBytes));
  return ByteReader(snapshot.substr(snapshot.size() - kChecksumBytes)).number64() == hasher.value();
}

}  // namespace

core::SimulationError snapshotError(std::string message) {
  core::SimulationError error;
  error.code = core::SimulationErrorCode::Snapshot;
  error.message = std::move(message);
  return error;
}

void writeSnapshot(const SnapshotContent& content, core::ByteSink& sink) {
  HashingSink hashing(sink);
  ByteWriter head;
  head.raw(kSnapshotMagic);
  // an older program can read what has no newer section
  const bool hasWorld = content.world != turtle::World{};
  head.number32(hasWorld ? kSnapshotVersion : isForest(content) ? 2 : 1);
  hashing.write(head.bytes());
  ByteWriter model;
  writeModel(model, content.models.front(), content.compatibility);
  hashing.writeSection(Section::Model, model);
  hashing.writeSection(Section::Run, runSection(content));
  ByteWriter types;
  writeTypes(types, content.models.front());
  hashing.writeSection(Section::Types, types);
  if (isForest(content)) {
    hashing.writeSection(Section::Forest, forestSection(content));
  }
  for (const derivation::PlantState& plant : content.plants) {
    hashing.writeSection(Section::Plant, plantSection(plant));
    if (hasFiles(plant)) {
      hashing.writeSection(Section::Files, filesSection(plant.files));
    }
  }
  ByteWriter environment;
  environment.text(content.environmentState);
  hashing.writeSection(Section::Environment, environment);
  hashing.writeSection(Section::Pending, pendingSection(content));
  if (!content.palette.empty()) {
    hashing.writeSection(Section::Colours, coloursSection(content.palette));
  }
  if (content.coupling.iterations > 1) {
    ByteWriter coupling;
    coupling.number32(content.coupling.iterations);
    coupling.real(content.coupling.tolerance);
    hashing.writeSection(Section::Coupling, coupling);
  }
  if (hasWorld) {
    hashing.writeSection(Section::World, worldSection(content.world));
  }
  hashing.writeSection(Section::End, ByteWriter());
  ByteWriter checksum;
  checksum.number64(hashing.hash());
  sink.write(checksum.bytes());
}

namespace {

/// Reads the sections of a snapshot one after the other. Every section but those of plants and their files comes at
/// most once.
class SectionReader {
 public:
  explicit SectionReader(bool headOnly) : headOnly_(headOnly) {}

  /// False: the section is wrong by itself or at its place. Tags that are not known are skipped.
  [[nodiscard]] bool read(std::uint32_t tag, ByteReader& section);
  [[nodiscard]] bool hasEnded() const { return hasRead(Section::End); }
  /// Whether every section was there that has to be, and as many plants as the run has.
  [[nodiscard]] bool isWhole() const {
    return hasRead(Section::Model) && hasRead(Section::Run) && hasRead(Section::Types) && hasRead(Section::Pending) &&
           (headOnly_ || content.plants.size() == content.members.size());
  }

  SnapshotContent content;

 private:
  [[nodiscard]] bool hasRead(Section section) const { return isRead_[static_cast<std::size_t>(section)]; }
  [[nodiscard]] bool readState(Section tag, ByteReader& section);

  bool headOnly_;
  std::array<bool, kSectionCount> isRead_{};  // by tag
};

bool SectionReader::read(std::uint32_t tag, ByteReader& section) {
  if (tag >= kSectionCount) {
    return true;
  }
  bool& isRead = isRead_[tag];
  const auto kind = static_cast<Section>(tag);
  if (isRead && kind != Section::Plant && kind != Section::Files) {
    return false;
  }
  isRead = true;
  switch (kind) {
    case Section::Model:
      readModel(section, content.models.front(), content.compatibility);
      break;
    case Section::Run:
      readRun(section, content);
      break;
    case Section::Types:
      readTypes(section, content.models.front());
      break;
    case Section::Colours:
      readColours(section, content.palette);
      break;
    case Section::Coupling:
      content.coupling.iterations = section.number32();
      content.coupling.tolerance = section.real();
      break;
    case Section::World:
      if (!readWorld(section, content.world)) {
        return false;
      }
      break;
    case Section::Forest:
      // further models and what the plants of the run are beside their places
      if (!hasRead(Section::Model) || !hasRead(Section::Run) || !readForest(section, content)) {
        return false;
      }
      break;
    default:
      if (!headOnly_ && !readState(kind, section)) {
        return false;
      }
      break;
  }
  return !section.hasFailed();
}

/// The sections that the head leaves out.
bool SectionReader::readState(Section tag, ByteReader& section) {
  switch (tag) {
    case Section::Plant:
      content.plants.push_back(readPlant(section));
      return true;
    case Section::Files:
      // of the plant before it
      if (content.plants.empty()) {
        return false;
      }
      content.plants.back().files = readFiles(section);
      return true;
    case Section::Environment:
      content.environmentState = section.text();
      return true;
    case Section::Pending:
      readPending(section, content);
      return true;
    default:
      return true;
  }
}

}  // namespace

tl::expected<SnapshotContent, core::SimulationError> readSnapshot(std::string_view snapshot, bool headOnly) {
  // magic and version, before anything else is believed
  if (!snapshot.starts_with(kSnapshotMagic)) {
    const bool isBeginning = !snapshot.empty() && kSnapshotMagic.starts_with(snapshot);
    return isBeginning ? cutOff()
                       : refused("This is not a snapshot: it does not begin with '" + std::string(kSnapshotMagic) +
                                 "'. Snapshots are made with 'espalier run MODEL.l -o NAME.snapshot'.");
  }
  ByteReader reader(snapshot.substr(kSnapshotMagic.size()));
  const std::uint32_t version = reader.number32();
  if (reader.hasFailed()) {
    return cutOff();
  }
  if (version == 0 || version > kSnapshotVersion) {
    return refused("The snapshot has version " + std::to_string(version) + "; this Espalier reads versions 1 to " +
                   std::to_string(kSnapshotVersion) + ". Use the Espalier that made it, or a newer one.");
  }
  // sections until the end; without the right checksum that is the reason for whatever else is wrong
  const bool isIntact = hasItsChecksum(snapshot);
  const auto wrong = [isIntact](const std::string& what) {
    return damaged(isIntact ? what : "its checksum does not agree with its content");
  };
  SectionReader sections(headOnly);
  while (!sections.hasEnded()) {
    core::pollWork();
    const std::uint32_t tag = reader.number32();
    ByteReader section(reader.raw(reader.number64()));
    if (reader.hasFailed()) {
      return cutOff();
    }
    if (!sections.read(tag, section)) {
      return wrong("its section " + std::to_string(tag) + " is too short, comes twice or does not fit those before it");
    }
  }
  static_cast<void>(reader.number64());  // the checksum
  if (reader.hasFailed()) {
    return cutOff();
  }
  if (!isIntact || reader.remaining() != 0 || !sections.isWhole()) {
    return wrong("sections are missing, or bytes follow the last one");
  }
  if (const std::string problem = problemOfRun(sections.content); !problem.empty()) {
    return damaged(problem);
  }
  return std::move(sections.content);
}

}  // namespace espalier::simulation
