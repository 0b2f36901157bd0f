/// A component with the Basic Model Interface as an environment of plants: this header makes a plug-in of it.
///
///     #include <heat.hxx>
///     #include "clients/bmi/bmi_plugin.h"
///
///     ESPALIER_BMI_ENVIRONMENT(std::make_unique<Heat>, .name = "heat", .configuration = "heat.cfg",
///                              .output = "plate_surface__temperature", .axes = "xz")
///
///     c++ -std=c++20 -shared -fPIC -I PREFIX/include/espalier plugin.cpp -o libheat.so
///     espalier derive MODEL.l --environment ./libheat.so
///
/// In each step the component gets the sum of the queries' first parameters at each node in its variable `demand`,
/// makes one update, and a query is answered the value of `output` at its place. The interface has no function that
/// saves a state. So the state of this environment is the demand of all updates, and going back begins a new component
/// and makes its updates again: a component that computes the same from the same input comes back with the same bits.
/// Links nothing of Espalier.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "clients/bmi/bmi.hxx"
#include "clients/bmi/bmi_raster.h"
#include "environment/plugin.h"

namespace espalier::bmi {

/// How a component answers plants.
struct ComponentSettings {
  std::string name;           // of the environment
  std::string configuration;  // the file that Initialize gets; an entry's member `configurationFile` replaces it
  std::string output;         // the variable that answers
  std::string demand = "";    // the variable that gets what the queries send; empty: none
  std::string axes = "xyz";   // of the world that the axes of the grid follow, from the fastest on
  std::string summary = "A component with the Basic Model Interface.";
};

/// Makes a component; what it returns owns it.
using ComponentFactory = std::function<std::shared_ptr<::bmi::Bmi>()>;

/// One component that runs for one simulation.
class Component {
 public:
  Component(ComponentFactory make, ComponentSettings settings)
      : make_(std::move(make)), settings_(std::move(settings)) {}
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;
  ~Component() { end(); }

  /// Goes to the initial state.
  void open() {
    if (model_ == nullptr || !demands_.empty() || !isWhole_) {
      demands_.clear();
      rebuild();
    }
  }

  /// Answers the queries of a step: demand, update, values. After a failure the state is as before.
  void step(const espalier_queries& queries, espalier_replies& replies) {
    std::vector<std::size_t> nodes(queries.count);
    std::vector<Amount> demand;
    std::vector<double> sums(settings_.demand.empty() ? 0 : raster_.size());
    for (std::size_t i = 0; i < queries.count; ++i) {
      nodes[i] = raster_.nodeAt(queries.position + 3 * i);
      const std::uint64_t first = queries.parameter_offset[i];
      if (!sums.empty() && queries.parameter_offset[i + 1] > first) {
        sums[nodes[i]] += queries.parameters[first];
      }
    }
    for (std::size_t node = 0; node < sums.size(); ++node) {
      if (sums[node] != 0.0) {
        demand.push_back({node, sums[node]});
      }
    }
    update(demand);
    const std::vector<double> values = readVariable(*model_, settings_.output);
    for (std::size_t i = 0; i < queries.count; ++i) {
      const std::uint64_t first = queries.parameter_offset[i];
      if (queries.parameter_offset[i + 1] > first) {
        replies.values[first] = values.at(nodes[i]);
        replies.is_set[first] = 1;
      }
    }
    demands_.push_back(std::move(demand));
    isWhole_ = true;
  }

  /// A step without queries.
  void tick() {
    update({});
    demands_.emplace_back();
    isWhole_ = true;
  }

  /// The demand of all updates: their number, then for each the number of nodes, and node and amount of each.
  [[nodiscard]] std::string state() const {
    std::string bytes;
    append(bytes, demands_.size());
    for (const std::vector<Amount>& demand : demands_) {
      append(bytes, demand.size());
      for (const Amount& amount : demand) {
        append(bytes, amount.node);
        append(bytes, amount.value);
      }
    }
    return bytes;
  }

  /// Goes to a state.
  void setState(const char* bytes, std::size_t size) {
    const std::string now = state();
    if (isWhole_ && now.size() == size && std::memcmp(now.data(), bytes, size) == 0) {
      return;
    }
    const char* at = bytes;
    const char* const last = bytes + size;
    std::vector<std::vector<Amount>> wanted(takeCount(at, last, 8));
    for (std::vector<Amount>& demand : wanted) {
      demand.resize(takeCount(at, last, 16));
      for (Amount& amount : demand) {
        amount.node = take<std::uint64_t>(at, last);
        amount.value = take<double>(at, last);
      }
    }
    if (at != last) {
      throw std::runtime_error("the state has bytes left over: it is of another environment.");
    }
    demands_ = std::move(wanted);
    rebuild();
  }

 private:
  struct Amount {
    std::uint64_t node = 0;
    double value = 0.0;
  };

  /// A new component that makes all updates again. After a failure the next update tries it once more.
  void rebuild() {
    end();
    isWhole_ = false;
    model_ = make_();
    model_->Initialize(settings_.configuration);
    raster_ = Raster(*model_, settings_.output, settings_.axes);
    checkSize(settings_.output);
    if (!settings_.demand.empty()) {
      checkSize(settings_.demand);
    }
    for (const std::vector<Amount>& demand : demands_) {
      apply(demand);
    }
    isWhole_ = true;
  }

  void checkSize(const std::string& name) {
    const std::size_t count = variableSize(*model_, name);
    if (count != raster_.size()) {
      throw std::runtime_error("the variable '" + name + "' has " + std::to_string(count) +
                               " values, and the grid of '" + settings_.output + "' has " +
                               std::to_string(raster_.size()) + " nodes: both must be as many.");
    }
  }

  /// An update after the last one. The component is whole again when the caller has noted it.
  void update(const std::vector<Amount>& demand) {
    if (!isWhole_) {
      rebuild();
    }
    isWhole_ = false;
    apply(demand);
  }

  void apply(const std::vector<Amount>& demand) {
    if (!settings_.demand.empty()) {
      std::vector<double> amounts(raster_.size());
      for (const Amount& amount : demand) {
        amounts.at(static_cast<std::size_t>(amount.node)) = amount.value;
      }
      writeVariable(*model_, settings_.demand, amounts);
    }
    model_->Update();
  }

  void end() {
    if (const auto ended = std::exchange(model_, nullptr)) {
      try {
        ended->Finalize();
      } catch (...) {
        // it has nothing more to answer
      }
    }
  }

  template <typename Value>
  static void append(std::string& bytes, Value value) {
    const auto eight = static_cast<std::conditional_t<std::is_floating_point_v<Value>, double, std::uint64_t>>(value);
    bytes.append(reinterpret_cast<const char*>(&eight), sizeof(eight));
  }

  template <typename Value>
  static Value take(const char*& at, const char* last) {
    Value value{};
    if (static_cast<std::size_t>(last - at) < sizeof(value)) {
      throw std::runtime_error("the state ends too early: it is of another environment.");
    }
    std::memcpy(&value, at, sizeof(value));
    at += sizeof(value);
    return value;
  }

  /// A number of parts of at least so many bytes each.
  static std::size_t takeCount(const char*& at, const char* last, std::size_t bytes) {
    const auto count = take<std::uint64_t>(at, last);
    if (count > static_cast<std::size_t>(last - at) / bytes) {
      throw std::runtime_error("the state ends too early: it is of another environment.");
    }
    return static_cast<std::size_t>(count);
  }

  ComponentFactory make_;
  ComponentSettings settings_;
  std::shared_ptr<::bmi::Bmi> model_;
  Raster raster_;
  std::vector<std::vector<Amount>> demands_;  // of each update
  bool isWhole_ = false;                      // the component is where demands_ says
};

/// The table of a plug-in for components of one kind. It lives as long as the library.
class ComponentPlugin {
 public:
  /// Initializes and finalizes a component at once, to learn the units; without its configuration the units are 1.
  ComponentPlugin(ComponentFactory make, ComponentSettings settings)
      : make_(std::move(make)), settings_(std::move(settings)) {
    try {
      const std::shared_ptr<::bmi::Bmi> model = make_();
      model->Initialize(settings_.configuration);
      outputUnit_ = unitOf(*model, settings_.output);
      demandUnit_ = settings_.demand.empty() ? "1" : unitOf(*model, settings_.demand);
      model->Finalize();
    } catch (...) {
      // create() says what is wrong
    }
    outputs_ = {settings_.output.c_str(), outputUnit_.c_str()};
    inputs_ = {settings_.demand.c_str(), demandUnit_.c_str()};
  }

  /// The table; `create` calls the function below.
  [[nodiscard]] const espalier_plugin* table(void* (*create)(const char*, char*, std::size_t)) {
    table_.version = ESPALIER_PLUGIN_VERSION;
    table_.size = sizeof(espalier_plugin);
    table_.name = settings_.name.c_str();
    table_.summary = settings_.summary.c_str();
    table_.needs = ESPALIER_NEEDS_POSITION;
    table_.is_stateful = 1;
    table_.input_count = settings_.demand.empty() ? 0 : 1;
    table_.inputs = &inputs_;
    table_.output_count = 1;
    table_.outputs = &outputs_;
    table_.create = create;
    table_.destroy = [](void* instance) { delete static_cast<Component*>(instance); };
    table_.open = [](void* instance, const espalier_context*, char* message, std::size_t size) {
      return guarded(message, size, [&] { static_cast<Component*>(instance)->open(); });
    };
    table_.step = [](void* instance, const espalier_queries* queries, espalier_replies* replies, char* message,
                     std::size_t size) {
      return guarded(message, size, [&] { static_cast<Component*>(instance)->step(*queries, *replies); });
    };
    table_.tick = [](void* instance, std::uint64_t, char* message, std::size_t size) {
      return guarded(message, size, [&] { static_cast<Component*>(instance)->tick(); });
    };
    table_.save = [](void* instance, void* buffer, std::size_t capacity) {
      const std::string state = static_cast<Component*>(instance)->state();
      if (capacity >= state.size() && buffer != nullptr) {
        std::memcpy(buffer, state.data(), state.size());
      }
      return state.size();
    };
    table_.restore = [](void* instance, const void* state, std::size_t bytes, char* message, std::size_t size) {
      return guarded(message, size,
                     [&] { static_cast<Component*>(instance)->setState(static_cast<const char*>(state), bytes); });
    };
    return &table_;
  }

  /// A component for a simulation, or null with a message.
  [[nodiscard]] void* create(const char* configuration, char* message, std::size_t size) const {
    void* made = nullptr;
    guarded(message, size, [&] {
      ComponentSettings settings = settings_;
      if (auto file = textMember(configuration, "configurationFile")) {
        settings.configuration = std::move(*file);
      }
      auto component = std::make_unique<Component>(make_, std::move(settings));
      // mistakes in the configuration are reported before a step
      component->open();
      made = component.release();
    });
    return made;
  }

 private:
  static std::string unitOf(::bmi::Bmi& model, const std::string& name) {
    const std::string unit = model.GetVarUnits(name);
    return unit.empty() || unit == "-" ? "1" : unit;
  }

  template <typename Call>
  static int guarded(char* message, std::size_t size, const Call& call) {
    try {
      call();
      return 0;
    } catch (const std::exception& error) {
      say(message, size, error.what());
    } catch (...) {
      say(message, size, "the component threw something that is no std::exception.");
    }
    return 1;
  }

  static void say(char* message, std::size_t size, const std::string& text) {
    if (size > 0) {
      const std::size_t count = std::min(size - 1, text.size());
      std::memcpy(message, text.data(), count);
      message[count] = '\0';
    }
  }

  ComponentFactory make_;
  ComponentSettings settings_;
  std::string outputUnit_ = "1";
  std::string demandUnit_ = "1";
  espalier_variable outputs_{};
  espalier_variable inputs_{};
  espalier_plugin table_{};
};

}  // namespace espalier::bmi

/// Exports the plug-in. `make` is a function that returns a std::unique_ptr or std::shared_ptr to a component, the rest
/// are the members of ComponentSettings.
#define ESPALIER_BMI_ENVIRONMENT(make, ...)                                                          \
  extern "C" const espalier_plugin* espalier_plugin_entry() {                                        \
    /* not of an inline function: such variables are one for all libraries of a program */           \
    static espalier::bmi::ComponentPlugin plugin([] { return std::shared_ptr<::bmi::Bmi>(make()); }, \
                                                 espalier::bmi::ComponentSettings{__VA_ARGS__});     \
    return plugin.table([](const char* configuration, char* message, std::size_t size) {             \
      return plugin.create(configuration, message, size);                                            \
    });                                                                                              \
  }
