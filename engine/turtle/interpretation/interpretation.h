#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/turtle/interpretation/branch_parts.h"
#include "engine/turtle/interpretation/drawing.h"
#include "engine/turtle/interpretation/interpretation_tables.h"
#include "engine/turtle/interpretation/interpreter.h"
#include "engine/turtle/interpretation/record_chain.h"
#include "engine/turtle/plant_coordinates.h"
#include "engine/turtle/turtle_motion.h"
#include "engine/turtle/turtle_state.h"

namespace espalier::turtle {

/// One interpretation of one plant's string: the working state of Interpreter::interpret. Its functions are in
/// interpretation.cpp (the walk over the string), interpretation_commands.cpp (the turtle table) and
/// interpretation_queries.cpp (query and communication modules).
class Interpretation {
 public:
  /// The plant to interpret. Everything must outlive the Interpretation.
  struct Subject {
    const language::Program& program;
    const InterpretationTables& tables;
    std::set<std::string>& reported;
    derivation::Derivation& derivation;
    derivation::PlantState& plantState;
    std::uint32_t plant;
    const PlantPlacement& placement;
  };

  /// The amount of output so far.
  struct OutputMark {
    std::size_t queries = 0;
    std::size_t changes = 0;
    std::size_t warnings = 0;
  };

  /// The state at the start of a branch that is interpreted apart.
  struct BranchStart {
    bool isReached = false;      // false: a cut or a failure came before
    bool isWithinShape = false;  // a polygon or a cylinder of `{` began before it and has not ended
    TurtleState state;
    Segment parent;   // the line that the branch grows from, if it has one
    OutputMark mark;  // output of the walk around it so far
    SceneMark drawn;
  };

  /// The uses that a stretch of the string makes of branches and records from before it.
  struct StretchNotes {
    std::size_t lowest = 0;            // of the open branches, those from here on were opened within the stretch
    std::vector<TurtleState> closed;   // those that it closes, the innermost first
    std::vector<std::uint32_t> outer;  // records before it that its own grow from; kOuterRecord + i is the i-th
  };

  /// The turtle as far as a query tells it.
  struct QueryPlace {
    core::Vec3 position;
    core::Frame frame;
    double width = 1.0;
    double scale = 1.0;
  };

  Interpretation(const Subject& subject, const InterpretationOutput& output);

  /// The whole string.
  void run();
  /// The string without these branches, which are skipped from the module behind `[` up to `]`. Their starts are noted
  /// in `starts` (branches.size()), warnings in `warnings`.
  void runAround(std::span<const BranchPart> branches, std::span<BranchStart> starts,
                 std::vector<std::string>& warnings);
  /// One of these branches. Line 0 of what it draws is the line that it grows from, and cylinder 0 stands for the one
  /// that is open there. Returns whether it left that alone and closed what it began. Nothing may be recorded: it would
  /// have no parent.
  [[nodiscard]] bool runBranch(const BranchPart& branch, const BranchStart& start, std::vector<std::string>& warnings);

  /// The string in pieces, from its first module on, for a caller that may already have the records of some pieces:
  /// `begin` before the first piece, `end` after the last.
  void begin();
  void end();
  /// Interprets a module with those that belong to it, and moves behind them. Returns whether the result is independent
  /// of the modules behind it.
  [[nodiscard]] bool walkOne(std::uint64_t& module, std::uint64_t& offset);
  [[nodiscard]] TurtleState& state() { return state_; }
  [[nodiscard]] const TurtleState& state() const { return state_; }
  /// The turtle's states at the open brackets, the outermost first.
  [[nodiscard]] std::vector<TurtleState>& openBranches() { return stack_; }
  [[nodiscard]] const std::vector<TurtleState>& openBranches() const { return stack_; }
  /// Puts a query of the string, whose E(x) is `module` with parameters at `offset`, as if the turtle came to it here.
  /// The caller sets the turtle's state afterwards.
  void askAgain(std::uint64_t module, std::uint64_t offset, const QueryPlace& place);
  /// walkOne notes closed branches here; null: nowhere.
  void noteIn(StretchNotes* notes) { notes_ = notes; }

  /// Gives a warning unless it was given before.
  void warnOnce(std::string text);

 private:
  /// The modules being interpreted: the string itself or the image of one of its modules.
  struct Sequence {
    const core::ModuleTypeId* types = nullptr;
    const double* parameters = nullptr;
    std::uint64_t count = 0;
    bool isImage = false;
  };
  /// Parameters of one module.
  struct Arguments {
    const double* values = nullptr;
    std::uint16_t count = 0;
    [[nodiscard]] double valueOr(std::size_t k, double otherwise) const { return k < count ? values[k] : otherwise; }
  };
  struct ScaleFrame {
    double scale = 1.0;
    double width = 1.0;
  };

  // the walk
  void reserveOutput();
  void forecastOutput(std::uint64_t i);
  template <typename List>
  void touchNext(List& list, std::size_t count, std::jthread& touch);
  void walk(std::uint64_t& module, std::uint64_t end, std::uint64_t& offset);
  void walkAll();
  void walkImage();
  [[nodiscard]] std::uint64_t execute(const Sequence& sequence, std::uint64_t i, std::uint64_t offset);
  [[nodiscard]] std::uint64_t executeAt(const Sequence& sequence, std::uint64_t i, std::uint64_t offset);
  [[nodiscard]] std::uint64_t executeSurface(const Sequence& sequence, std::uint64_t i, std::uint64_t offset);
  void skipCut(std::uint64_t& module, std::uint64_t& offset);
  void skipBranch(std::uint64_t& module, std::uint64_t& offset);
  [[nodiscard]] OutputMark mark() const;
  void openBranch();
  void closeBranch();
  void noteClosing();
  void leaveInstance();
  void enterScale(const Arguments& arguments);
  void leaveScale();
  [[nodiscard]] TurtleRecord stateAfter(std::uint64_t module, std::uint64_t offset) const;
  void record(std::uint64_t module, std::uint64_t offset);

  // the turtle table
  void perform(TurtleCommand command, const Arguments& arguments);
  void performAt(TurtleCommand command, const Arguments& arguments);
  void performAddition(TurtleCommand command, const Arguments& arguments);
  void advance(const Arguments& arguments, bool draws, bool addsVertex);
  void changeColour(const Arguments& arguments, int sign, bool isBack);
  void changeWidth(const Arguments& arguments, double sign);
  void changeElasticity(TurtleCommand command, const Arguments& arguments);
  void setRadiusTangents(const Arguments& arguments);
  void setTexture(std::int32_t texture);
  void addLabel(const Arguments& arguments);
  [[nodiscard]] double angleRadians(const Arguments& arguments) const;

  // query and communication modules
  [[nodiscard]] std::uint64_t executeQuery(const Sequence& sequence, std::uint64_t i, std::uint64_t offset);
  [[nodiscard]] bool fillQuery(char character, const Sequence& sequence, std::uint64_t offset, std::uint16_t arity);
  void fill(const Sequence& sequence, std::uint64_t offset, std::uint16_t arity, std::span<const double> values);
  void communicate(const Sequence& sequence, std::uint64_t i, std::uint64_t offset);
  void fillLegacyPosition(const Sequence& sequence, std::uint64_t offset, std::uint16_t arity);

  [[noreturn]] void fail(core::SimulationErrorCode code, const std::string& what) const;
  void checkPosition() const {
    if (!std::isfinite(state_.position.x + state_.position.y + state_.position.z)) [[unlikely]] {
      failPosition();
    }
  }
  [[noreturn]] void failPosition() const;
  void checkCount(std::size_t count) const;
  /// Checks an organ before it is drawn: the turtle's directions and the organ's size must be finite.
  void checkOrgan(const core::Vec3& size) const;
  [[nodiscard]] bool isCompatible() const { return program_.compatibility != core::Compatibility::Espalier; }
  [[nodiscard]] char characterOf(core::ModuleTypeId type) const {
    return program_.symbols[program_.symbolOf[type]].character();
  }

  const language::Program& program_;
  core::Elementary elementary_;
  const files::ViewSettings& view_;
  const InterpretationTables& tables_;
  std::set<std::string>& reported_;
  derivation::Derivation& derivation_;
  derivation::PlantState& plantState_;
  std::uint32_t plant_;
  PlantCoordinates coordinates_;
  const InterpretationOutput& output_;
  Drawing drawing_;

  /// Memory for a list of the output.
  struct Forecast {
    std::size_t first = 0;  // how many there were at the beginning
    std::size_t last = 0;   // and at the last look
    std::jthread touch;     // touches it
  };
  Forecast segments_;
  Forecast records_;
  /// The module before which the output is forecast next; the largest number: never.
  std::uint64_t nextForecast_ = std::numeric_limits<std::uint64_t>::max();

  std::span<const BranchPart> branches_;          // still to be skipped, in order
  BranchStart* start_ = nullptr;                  // of the first of them
  std::vector<std::string>* warnings_ = nullptr;  // null: warnings are given at once

  StretchNotes* notes_ = nullptr;  // of walkOne

  TurtleState state_;
  TurnCache turns_;
  std::vector<TurtleState> stack_;        // states at the open brackets
  std::vector<ScaleFrame> scales_;        // before each open `?(id)`
  std::vector<std::uint32_t> instances_;  // sub-L-system instance at each open `?(id)` of the string
  std::uint32_t instanceCount_ = 0;       // `?(id)` of the string so far
  std::uint64_t module_ = 0;              // index in the string of the module being interpreted
  bool isTouched_ = false;                // the module moved the turtle, drew or is a query
  bool isCut_ = false;                    // the rest of the branch is not interpreted
  bool wasCut_ = false;                   // since walkOne began
  bool isDisplaced_ = false;              // each drawn step is moved by the view's displacement
  bool isEnvironmentPass_ = false;
  bool skipsAttributes_ = false;  // width and colour are not executed: compatible environment pass
  derivation::ModuleString image_;
};

/// An integer parameter: truncated; 0 when an int cannot hold it.
[[nodiscard]] std::int32_t wholeNumber(double value);

}  // namespace espalier::turtle
