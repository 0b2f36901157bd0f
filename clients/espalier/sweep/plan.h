#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "clients/espalier/result.h"

namespace espalier::command {

/// How the values of a parameter are spread in a design.
struct Distribution {
  enum class Kind : std::uint8_t {
    None,      // the table gives the values
    Uniform,   // first to second
    Log,       // first to second, the logarithm is uniform; both above 0
    Normal,    // mean `first`, standard deviation `second`
    Integer,   // whole numbers from first to second, equally probable
    Discrete,  // one of `values`, equally probable
  };
  Kind kind = Kind::None;
  double first = 0.0;
  double second = 0.0;
  std::vector<double> values{};

  /// The quantile of a probability in (0, 1).
  [[nodiscard]] double quantile(double probability) const;
};

/// A number that differs from run to run.
struct SweepParameter {
  enum class Kind : std::uint8_t {
    Unknown,      // found by its name: a #define, else a variable; a name that begins with `/` is of the environment
    Define,       // a macro of the preprocessor: every set of values is a Program of its own
    Variable,     // a variable of the main L-system: replaces what Start assigns
    Environment,  // a JSON pointer into the list of environments
  };
  std::string name;
  Kind kind = Kind::Unknown;
  std::string target;  // name of the macro or variable, or the pointer
  Distribution distribution{};
};

/// Which runs a plan asks for.
struct Design {
  enum class Kind : std::uint8_t { Single, Table, Rows, Grid, Random, LatinHypercube, Sobol, Saltelli, Morris };
  Kind kind = Kind::Single;              // one run; its parameters have no values
  std::string file;                      // of a Table, as the plan writes it
  std::uint64_t count = 0;               // points; of Morris trajectories
  std::uint64_t levels = 4;              // of Morris and, for parameters with a range, of a grid
  std::uint64_t seed = 1;                // of the random numbers of the design
  std::optional<std::uint64_t> shift{};  // Sobol, Saltelli: seed of a random digital shift
  std::vector<std::vector<std::pair<std::string, double>>> rows{};  // of Rows
};

/// A number, or several, taken from a plant.
struct MeasureDefinition {
  enum class Kind : std::uint8_t {
    Count,  // modules of a type
    Sum,    // of an expression over modules of a type
    Mean,   // and so on; of no module they have no value
    Minimum,
    Maximum,
    Deviation,  // standard deviation with n - 1
    Quantile,   // with linear interpolation between order statistics (type 7 of Hyndman & Fan 1996)
    Variable,   // value of a variable of the main L-system
    Plant,      // of the shape that the turtle draws (shape_measures.h)
    Profile,    // of the same in bins
    Mtg,        // of the branching (tree_measures.h)
  };
  std::string name;
  Kind kind = Kind::Count;
  std::string of;          // modules: `*`, `A` or `A(l,w)`
  std::string expression;  // over the names in `of`
  std::string where;       // condition over the same names; empty: every module
  double probability = 0.5;
  std::string what;  // name of the variable, of the measure of shape or branching, or the quantity of a profile
  bool isAlongRadius = false;            // Profile: by the distance from the vertical axis, else by height
  std::uint64_t bins = 10;               // Profile
  double to = 0.0;                       // Profile: upper end of the last bin
  std::optional<std::uint64_t> order{};  // Mtg: of this branching order only
  std::vector<std::uint64_t> steps{};    // empty: the last step
  [[nodiscard]] std::size_t width() const { return kind == Kind::Profile ? bins : 1; }
};

/// Files to be kept of every k-th run.
struct KeptFile {
  std::string name;  // as an argument of `run -o`
  std::uint64_t every = 1;
};

/// The plan that `espalier sweep` reads from a PLAN.json. docs/sweeps.md describes it for users; planSchema() is its
/// JSON Schema.
struct Plan {
  std::string text;  // the JSON in one form, whatever its layout: two plans with equal texts ask for the same
  std::string model;
  std::string object, view, dialect, compatibility;
  std::string environment;   // a name or a file as of --environment; or JSON text that begins with `{` or `[`; empty:
                             // the model's own
  std::string world;         // a file as of --world; or JSON text that begins with `{`; empty: the model folder's own
  std::string stepDuration;  // as of --step-duration; empty: that of the world
  std::optional<std::uint64_t> steps;
  std::uint64_t seed = 1;
  bool isAnswered = false;  // measures see the answers of the environment to the last string
  std::vector<std::pair<std::string, std::string>> defines;  // the same in all runs
  std::vector<std::string> limits;                           // NAME=NUMBER
  std::vector<SweepParameter> parameters;
  Design design;
  std::uint64_t replicates = 1;
  std::uint64_t firstSeed = 1;
  bool haveCommonSeeds = true;  // replicate r has the same seed in every set of parameters
  std::vector<MeasureDefinition> measures;
  std::vector<KeptFile> files;
};

/// Reads a plan. The problem has a line for each mistake: the member, the mistake, and the nearest right name.
[[nodiscard]] Result<Plan> readPlan(std::string_view json);

/// JSON Schema (draft 2020-12) of a plan.
[[nodiscard]] std::string_view planSchema();

}  // namespace espalier::command
