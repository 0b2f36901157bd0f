#include "environment/plugin_process.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "engine/turtle/scene/geometry.h"

namespace espalier::environment {

namespace {

using turtle::EnvironmentError;

// the interface hands vectors on as three doubles
static_assert(sizeof(core::Vec3) == 3 * sizeof(double));
static_assert(sizeof(core::SymbolId) == sizeof(uint16_t) && core::kNoSymbol == ESPALIER_NO_SYMBOL);

/// Room for a plug-in's message.
using Message = std::array<char, 1024>;

std::string textOf(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

std::string textOf(Message& message) {
  message.back() = '\0';
  return message.front() == '\0' ? std::string("it did not say why") : std::string(message.data());
}

static_assert(ESPALIER_CYLINDER == static_cast<int>(turtle::GeometryKind::Cylinder) &&
              ESPALIER_POLYGON == static_cast<int>(turtle::GeometryKind::Polygon) &&
              ESPALIER_SURFACE == static_cast<int>(turtle::GeometryKind::Surface) &&
              ESPALIER_PATCH == static_cast<int>(turtle::GeometryKind::Patch) &&
              ESPALIER_BALL == static_cast<int>(turtle::GeometryKind::Ball));
static_assert(sizeof(turtle::GeometryKind) == sizeof(uint8_t) &&
              sizeof(std::array<std::uint32_t, 3>) == 3 * sizeof(uint32_t));

const double* numbersOf(const std::vector<core::Vec3>& vectors) {
  return vectors.empty() ? nullptr : &vectors.front().x;
}

std::vector<turtle::EnvironmentVariable> variablesOf(const espalier_variable* variables, std::uint32_t count) {
  std::vector<turtle::EnvironmentVariable> list;
  for (std::uint32_t i = 0; variables != nullptr && i < count; ++i) {
    list.push_back({textOf(variables[i].name), textOf(variables[i].unit), {}});
  }
  return list;
}

espalier_sources sourcesOf(const turtle::GeometrySources& sources) {
  return {.count = sources.size(),
          .plant = sources.plant.data(),
          .module = sources.module.data(),
          .symbol = sources.symbol.data(),
          .colour = sources.colour.data(),
          .branch_order = sources.branchOrder.data()};
}

espalier_geometry geometryOf(const turtle::Geometry& geometry) {
  return {.segments = sourcesOf(geometry.segments),
          .start = numbersOf(geometry.start),
          .end = numbersOf(geometry.end),
          .start_width = geometry.startWidth.data(),
          .end_width = geometry.endWidth.data(),
          .are_widths_pixels = geometry.areWidthsPixels ? 1U : 0U,
          .reserved = 0,
          .organs = sourcesOf(geometry.organs),
          // a byte each
          .kind = reinterpret_cast<const uint8_t*>(geometry.kind.data()),
          .vertex_offset = geometry.vertexOffset.data(),
          .triangle_offset = geometry.triangleOffset.data(),
          .vertices = numbersOf(geometry.vertices),
          .triangles = geometry.triangles.empty() ? nullptr : geometry.triangles.front().data()};
}

class PluginProcess final : public turtle::EnvironmentProcess {
 public:
  PluginProcess(const espalier_plugin& plugin, std::shared_ptr<void> library, void* instance)
      : library_(std::move(library)), plugin_(&plugin), instance_(instance), name_(textOf(plugin.name)) {}
  PluginProcess(const PluginProcess&) = delete;
  PluginProcess& operator=(const PluginProcess&) = delete;
  ~PluginProcess() override { plugin_->destroy(instance_); }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const auto needs = [this](int flag) { return (plugin_->needs & static_cast<std::uint32_t>(flag)) != 0; };
    turtle::EnvironmentDescription description;
    description.name = name_;
    description.summary = textOf(plugin_->summary);
    description.needs = {.position = needs(ESPALIER_NEEDS_POSITION),
                         .heading = needs(ESPALIER_NEEDS_HEADING),
                         .left = needs(ESPALIER_NEEDS_LEFT),
                         .up = needs(ESPALIER_NEEDS_UP),
                         .width = needs(ESPALIER_NEEDS_WIDTH),
                         .scale = needs(ESPALIER_NEEDS_SCALE),
                         .parameters = true,
                         .following = needs(ESPALIER_NEEDS_FOLLOWING),
                         .geometry = needs(ESPALIER_NEEDS_GEOMETRY)};
    description.inputs = variablesOf(plugin_->inputs, plugin_->input_count);
    description.outputs = variablesOf(plugin_->outputs, plugin_->output_count);
    description.isStateful = plugin_->is_stateful != 0;
    return description;
  }

  [[nodiscard]] std::optional<EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    if (plugin_->open == nullptr) {
      return std::nullopt;
    }
    std::vector<const char*> symbols;
    for (const std::string& symbol : context.symbols) {
      symbols.push_back(symbol.c_str());
    }
    const turtle::World& world = context.world;
    const espalier_context told{.seed = context.seed,
                                .plant_count = context.plantCount,
                                .symbol_count = static_cast<std::uint32_t>(symbols.size()),
                                .symbols = symbols.data(),
                                .simulation = context.simulation.c_str(),
                                .length_unit = world.lengthUnit.c_str(),
                                .up = {world.up.x, world.up.y, world.up.z},
                                .north = {world.north.x, world.north.y, world.north.z},
                                .step_duration_days = world.stepDurationDays};
    Message message{};
    return failureOf(plugin_->open(instance_, &told, message.data(), message.size()), message, "open");
  }

  [[nodiscard]] std::optional<EnvironmentError> step(const turtle::QueryBatch& queries,
                                                     turtle::ReplyBatch& replies) override {
    const bool seesGeometry =
        queries.geometry != nullptr && (plugin_->needs & static_cast<std::uint32_t>(ESPALIER_NEEDS_GEOMETRY)) != 0;
    const espalier_geometry drawn = seesGeometry ? geometryOf(*queries.geometry) : espalier_geometry{};
    const espalier_queries asked{.step = queries.step,
                                 .iteration = queries.iteration,
                                 .reserved = 0,
                                 .time_days = queries.timeDays,
                                 .count = queries.size(),
                                 .plant = queries.plant.data(),
                                 .module = queries.module.data(),
                                 .symbol = queries.symbol.data(),
                                 .is_transient = queries.isTransient.empty() ? nullptr : queries.isTransient.data(),
                                 .position = numbersOf(queries.position),
                                 .heading = numbersOf(queries.heading),
                                 .left = numbersOf(queries.left),
                                 .up = numbersOf(queries.up),
                                 .width = queries.width.data(),
                                 .scale = queries.scale.data(),
                                 .parameter_offset = queries.parameterOffset.data(),
                                 .parameters = queries.parameters.data(),
                                 .following = queries.following.data(),
                                 .following_offset = queries.followingOffset.data(),
                                 .following_parameters = queries.followingParameters.data(),
                                 .geometry = seesGeometry ? &drawn : nullptr};
    espalier_replies answers{.values = replies.values.data(), .is_set = replies.isSet.data()};
    Message message{};
    if (auto error =
            failureOf(plugin_->step(instance_, &asked, &answers, message.data(), message.size()), message, "step")) {
      return error;
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto isSet = [&](std::uint64_t from, std::uint64_t to) {
        return std::any_of(replies.isSet.begin() + static_cast<std::ptrdiff_t>(from),
                           replies.isSet.begin() + static_cast<std::ptrdiff_t>(to), [](auto set) { return set != 0; });
      };
      replies.answeredCount += isSet(queries.parameterOffset[query], queries.parameterOffset[query + 1]) ? 1 : 0;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<EnvironmentError> tick(std::uint64_t step) override {
    if (plugin_->tick == nullptr) {
      return std::nullopt;
    }
    Message message{};
    return failureOf(plugin_->tick(instance_, step, message.data(), message.size()), message, "tick");
  }

  [[nodiscard]] std::string save() const override {
    if (plugin_->is_stateful == 0) {
      return {};
    }
    std::string state;
    for (std::size_t size = plugin_->save(instance_, nullptr, 0); size != state.size();) {
      state.resize(size);
      size = plugin_->save(instance_, state.data(), state.size());
    }
    return state;
  }

  [[nodiscard]] std::optional<EnvironmentError> restore(std::string_view state) override {
    if (plugin_->is_stateful == 0) {
      return std::nullopt;
    }
    Message message{};
    return failureOf(plugin_->restore(instance_, state.data(), state.size(), message.data(), message.size()), message,
                     "restore");
  }

 private:
  [[nodiscard]] std::optional<EnvironmentError> failureOf(int result, Message& message, const char* during) const {
    if (result == 0) {
      return std::nullopt;
    }
    return EnvironmentError{"environment plug-in '" + name_ + "' failed in " + during + ": " + textOf(message), false};
  }

  std::shared_ptr<void> library_;
  const espalier_plugin* plugin_;
  void* instance_;
  std::string name_;
};

/// The missing part of a table; null when it is complete.
const char* missingIn(const espalier_plugin& plugin) {
  if (plugin.name == nullptr || *plugin.name == '\0') {
    return "a name";
  }
  if (plugin.create == nullptr || plugin.destroy == nullptr || plugin.step == nullptr) {
    return "create, destroy and step";
  }
  if (plugin.is_stateful != 0 && (plugin.save == nullptr || plugin.restore == nullptr)) {
    return "save and restore, which it needs because it has a state";
  }
  return nullptr;
}

}  // namespace

tl::expected<std::unique_ptr<turtle::EnvironmentProcess>, std::string> makePluginProcess(
    const espalier_plugin& plugin, std::shared_ptr<void> library, std::string_view configurationJson) {
  if (plugin.version != ESPALIER_PLUGIN_VERSION) {
    return tl::unexpected("it has version " + std::to_string(plugin.version) +
                          " of the plug-in interface, and this program has version " +
                          std::to_string(ESPALIER_PLUGIN_VERSION) +
                          ": compile it with this program's environment/plugin.h");
  }
  if (plugin.size < sizeof(espalier_plugin)) {
    return tl::unexpected("its table has " + std::to_string(plugin.size) + " bytes instead of " +
                          std::to_string(sizeof(espalier_plugin)) +
                          ": compile it with this program's environment/plugin.h");
  }
  if (const char* missing = missingIn(plugin)) {
    return tl::unexpected("its table lacks " + std::string(missing));
  }
  Message message{};
  const std::string configuration = configurationJson.empty() ? std::string("{}") : std::string(configurationJson);
  void* const instance = plugin.create(configuration.c_str(), message.data(), message.size());
  if (instance == nullptr) {
    return tl::unexpected("'" + std::string(plugin.name) + "' refuses its configuration: " + textOf(message));
  }
  return std::make_unique<PluginProcess>(plugin, std::move(library), instance);
}

}  // namespace espalier::environment
