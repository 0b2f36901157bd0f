/// The parts of a BMI component for an environment: the grid of a variable, and its values as doubles. Header only.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clients/bmi/bmi.hxx"

namespace espalier::bmi {

/// Calls `visit` with a value of the C++ type of a variable. Throws for a type that has no numbers.
template <typename Visit>
void withType(::bmi::Bmi& model, const std::string& name, const Visit& visit) {
  std::string type = model.GetVarType(name);
  const auto is = [&type](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), type) != names.end();
  };
  if (is({"double", "float64", "double precision", "real*8"})) {
    visit(double{});
  } else if (is({"float", "float32", "real", "real*4"})) {
    visit(float{});
  } else if (is({"int", "int32", "integer"})) {
    visit(std::int32_t{});
  } else if (is({"long", "int64", "long long"})) {
    visit(std::int64_t{});
  } else {
    throw std::runtime_error("the variable '" + name + "' has the type " + type +
                             ": an environment needs double, float, int or long.");
  }
}

/// The number of values of a variable.
inline std::size_t variableSize(::bmi::Bmi& model, const std::string& name) {
  const int bytes = model.GetVarNbytes(name);
  const int one = model.GetVarItemsize(name);
  if (one <= 0 || bytes < one) {
    throw std::runtime_error("the variable '" + name + "' has " + std::to_string(bytes) + " bytes, and a value has " +
                             std::to_string(one) + ".");
  }
  return static_cast<std::size_t>(bytes / one);
}

inline std::vector<double> readVariable(::bmi::Bmi& model, const std::string& name) {
  std::vector<double> values(variableSize(model, name));
  withType(model, name, [&](auto zero) {
    std::vector<decltype(zero)> own(values.size());
    model.GetValue(name, own.data());
    std::transform(own.begin(), own.end(), values.begin(), [](auto value) { return static_cast<double>(value); });
  });
  return values;
}

inline void writeVariable(::bmi::Bmi& model, const std::string& name, const std::vector<double>& values) {
  withType(model, name, [&](auto zero) {
    std::vector<decltype(zero)> own(values.size());
    std::transform(values.begin(), values.end(), own.begin(),
                   [](double value) { return static_cast<decltype(zero)>(value); });
    model.SetValue(name, own.data());
  });
}

/// The grid of a variable: `scalar`, `uniform_rectilinear` or `rectilinear`. BMI lists axes from the slowest to the
/// fastest: z, y, x, or y, x.
class Raster {
 public:
  Raster() = default;
  Raster(::bmi::Bmi& model, const std::string& name, const std::string& axes) {
    const int grid = model.GetVarGrid(name);
    const std::string type = model.GetGridType(grid);
    const int rank = type == "scalar" ? 0 : model.GetGridRank(grid);
    if (type != "scalar" && type != "uniform_rectilinear" && type != "rectilinear") {
      throw std::runtime_error("'" + name + "' is on a grid of the type " + type +
                               ": an environment needs scalar, uniform_rectilinear or rectilinear.");
    }
    if (rank < 0 || rank > 3 || (rank == 0 && type != "scalar")) {
      throw std::runtime_error("'" + name + "' has " + std::to_string(rank) +
                               " dimensions: an environment needs one to three.");
    }
    const auto count = static_cast<std::size_t>(rank);
    if (axes.size() < count || axes.find_first_not_of("xyz") != std::string::npos) {
      throw std::runtime_error("'" + name + "' has " + std::to_string(rank) +
                               " dimensions: name as many axes of x, y and z.");
    }
    axes_.resize(count);
    std::vector<int> shape(count);
    std::vector<double> spacing(count);
    std::vector<double> origin(count);
    if (count > 0) {
      model.GetGridShape(grid, shape.data());
      if (type == "uniform_rectilinear") {
        model.GetGridSpacing(grid, spacing.data());
        model.GetGridOrigin(grid, origin.data());
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      if (shape[i] < 1) {
        throw std::runtime_error("the grid of '" + name + "' has " + std::to_string(shape[i]) +
                                 " nodes along an axis.");
      }
      Axis& axis = axes_[i];
      const std::size_t fromFastest = count - 1 - i;
      axis.of = static_cast<std::size_t>(axes[fromFastest] - 'x');
      axis.count = static_cast<std::size_t>(shape[i]);
      axis.spacing = spacing[i];
      axis.origin = origin[i];
      if (type == "rectilinear") {
        axis.places.resize(axis.count);
        fromFastest == 0   ? model.GetGridX(grid, axis.places.data())
        : fromFastest == 1 ? model.GetGridY(grid, axis.places.data())
                           : model.GetGridZ(grid, axis.places.data());
      }
      size_ *= axis.count;
    }
  }

  /// The number of nodes.
  [[nodiscard]] std::size_t size() const { return size_; }

  /// The nearest node to a place (x, y, z), at the border for places outside.
  [[nodiscard]] std::size_t nodeAt(const double* place) const {
    std::size_t found = 0;
    for (const Axis& axis : axes_) {
      found = found * axis.count + axis.nodeAt(place[axis.of]);
    }
    return found;
  }

 private:
  struct Axis {
    std::size_t of = 0;  // the world's axis: 0, 1, 2
    std::size_t count = 1;
    double spacing = 1.0;
    double origin = 0.0;
    std::vector<double> places;  // of the nodes (count), rising or falling; empty: uniform

    [[nodiscard]] std::size_t nodeAt(double coordinate) const {
      if (places.empty()) {
        const double node = std::nearbyint((coordinate - origin) / spacing);
        return node > 0.0 ? static_cast<std::size_t>(std::min(node, static_cast<double>(count - 1))) : 0;
      }
      const auto nearest = std::min_element(places.begin(), places.end(), [coordinate](double one, double other) {
        return std::abs(one - coordinate) < std::abs(other - coordinate);
      });
      return static_cast<std::size_t>(nearest - places.begin());
    }
  };

  std::vector<Axis> axes_;  // from the slowest on
  std::size_t size_ = 1;
};

/// The text of a member of a JSON object, which the program has checked; nothing without the member. Throws when it is
/// no text, or a text with control characters.
inline std::optional<std::string> textMember(std::string_view json, std::string_view member) {
  int depth = 0;
  std::optional<std::string> text;
  std::string before;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char letter = json[i];
    if (letter == '"') {
      std::string read;
      bool isPlain = true;
      for (++i; i < json.size() && json[i] != '"'; ++i) {
        if (json[i] == '\\' && ++i < json.size()) {
          isPlain = isPlain && (json[i] == '"' || json[i] == '\\' || json[i] == '/');
        }
        read += i < json.size() ? json[i] : ' ';
      }
      if (depth == 1 && before == member) {
        if (!isPlain) {
          throw std::runtime_error("'" + std::string(member) + "' must not have control characters or \\u.");
        }
        return read;
      }
      text = std::move(read);
    } else if (letter == '{' || letter == '[') {
      ++depth;
      before.clear();
    } else if (letter == '}' || letter == ']') {
      --depth;
    } else if (letter == ':' && depth == 1 && text) {
      before = *std::exchange(text, std::nullopt);
    } else if (letter == ',') {
      before.clear();
    } else if (depth == 1 && before == member && std::isspace(static_cast<unsigned char>(letter)) == 0) {
      throw std::runtime_error("'" + std::string(member) + "' is a text: the name of a file.");
    }
  }
  return std::nullopt;
}

}  // namespace espalier::bmi
