#include "engine/turtle/interpretation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/number_text.h"

namespace espalier::turtle {

using core::ModuleTypeId;

namespace {

constexpr std::uint64_t kPollInterval = 65'536;  // modules between two looks at `cancelled`

}  // namespace

std::int32_t wholeNumber(double value) {
  return std::abs(value) < 2e9 ? static_cast<std::int32_t>(value) : 0;
}

Interpretation::Interpretation(Tables tables, derivation::Derivation& derivation, derivation::PlantState& plantState,
                               std::uint32_t plant, const PlantPlacement& placement, const InterpretationOutput& output)
    : program_(tables.program),
      view_(tables.program.view),
      commandOf_(tables.commandOf),
      mayExpand_(tables.mayExpand),
      reported_(tables.reported),
      derivation_(derivation),
      plantState_(plantState),
      plant_(plant),
      coordinates_(placement.position, placement.frame),
      output_(output),
      drawing_(output.scene, tables.program.view, plant),
      isEnvironmentPass_(output.queries != nullptr),
      skipsAttributes_(isEnvironmentPass_ && isCompatible()) {
  state_.position = placement.position;
  state_.frame = placement.frame;
  state_.previousHeading = placement.frame.heading;
  state_.previousUp = placement.frame.up;
  state_.width = view_.initialLineWidth;
  state_.scale = view_.initialScale;
  state_.colour = view_.initialColour;
  state_.backColour = view_.initialBackColour;
  state_.contourSides = view_.contourSides;
  state_.oldElasticity = view_.oldTropism.initialElasticity;
  for (std::size_t i = 0; i < std::min(view_.movements.size(), kMaximumMovements); ++i) {
    state_.elasticity[i] = view_.movements[i].elasticity;
  }
}

void Interpretation::run() {
  derivation_.beginInterpretation(plantState_);
  walkString();
  derivation_.endInterpretation(plantState_);
  drawing_.finish();
}

void Interpretation::walkString() {
  const Sequence string{plantState_.string.types().data(), plantState_.string.mutableParameters().data(),
                        plantState_.string.size(), false};
  const std::atomic<bool>* cancelled = derivation_.options().cancelled;
  std::uint64_t nextPoll = 0;
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < string.count;) {
    if (i >= nextPoll) {
      nextPoll = i + kPollInterval;
      if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) {
        fail(core::SimulationErrorCode::Cancelled, "the step was cancelled");
      }
    }
    module_ = i;
    drawing_.setModule(i);
    isTouched_ = false;
    // a `$` belongs to the L-system around the call that it ends
    if (string.types[i] == program_.subSystemEnd) {
      leaveInstance();
    }
    // the homomorphism's image stands for the module, otherwise the module itself
    std::uint64_t consumed = 0;
    if (mayExpand_[string.types[i]]) {
      image_.clear();
      const std::uint32_t instance = instances_.empty() ? 0 : instances_.back();
      consumed = derivation_.expand(plantState_, instance, i, offset, image_);
    }
    if (consumed > 0) {
      walkImage();
    } else {
      consumed = execute(string, i, offset);
    }
    std::uint64_t lastOffset = offset;
    for (std::uint64_t k = 0; k < consumed; ++k) {
      const ModuleTypeId type = string.types[i + k];
      lastOffset = offset;
      offset += program_.arity[type];
      if (isCall(type)) {
        instances_.push_back(++instanceCount_);
      } else if (k > 0 && type == program_.subSystemEnd) {
        leaveInstance();
      }
    }
    i += consumed;
    if (isTouched_ && output_.records != nullptr) {
      record(i - 1, lastOffset);
    }
    if (output_.onModule) {
      output_.onModule(stateAfter(i - 1, lastOffset));
    }
    if (isCut_) {
      const std::uint64_t end = endOfCut(i);
      for (; i < end; ++i) {
        offset += program_.arity[string.types[i]];
      }
      isCut_ = false;
    }
  }
}

void Interpretation::walkImage() {
  const Sequence image{image_.types().data(), image_.mutableParameters().data(), image_.size(), true};
  std::uint64_t offset = 0;
  for (std::uint64_t i = 0; i < image.count;) {
    const std::uint64_t consumed = execute(image, i, offset);
    for (std::uint64_t k = 0; k < consumed; ++k) {
      offset += program_.arity[image.types[i + k]];
    }
    i += consumed;
  }
  // a cut made by a homomorphism is ignored
  isCut_ = false;
}

std::uint64_t Interpretation::execute(const Sequence& sequence, std::uint64_t i, std::uint64_t offset) {
  const ModuleTypeId type = sequence.types[i];
  const Arguments arguments{sequence.parameters + offset, program_.arity[type]};
  const auto command = static_cast<TurtleCommand>(commandOf_[type]);
  switch (command) {
    case TurtleCommand::None:
      return 1;
    case TurtleCommand::OpenBranch:
      openBranch();
      return 1;
    case TurtleCommand::CloseBranch:
      closeBranch();
      return 1;
    case TurtleCommand::At:
      return executeAt(sequence, i, offset);
    case TurtleCommand::Surface:
      return executeSurface(sequence, i, offset);
    case TurtleCommand::Query:
      if (arguments.count > 0) {
        enterScale(arguments);
        return 1;
      }
      return executeQuery(sequence, i, offset);
    case TurtleCommand::SubSystemEnd:
      leaveScale();
      return 1;
    case TurtleCommand::Cut:
      isCut_ = !view_.interpretsPastCut;
      return 1;
    case TurtleCommand::LegacyPosition:
      fillLegacyPosition(sequence, offset, arguments.count);
      return 1;
    default:
      perform(command, arguments);
      return 1;
  }
}

std::uint64_t Interpretation::executeAt(const Sequence& sequence, std::uint64_t i, std::uint64_t offset) {
  const std::uint64_t next = i + 1;
  std::string name;
  if (next < sequence.count) {
    const ModuleTypeId type = sequence.types[next];
    const std::uint64_t nextOffset = offset + program_.arity[sequence.types[i]];
    const char first = characterOf(type);
    const std::uint16_t arity = program_.arity[type];
    name = program_.nameOf(type);
    // three symbols: the parameters are those of the last
    if (arity == 0 && takesSecondSymbol(first) && next + 1 < sequence.count) {
      const ModuleTypeId secondType = sequence.types[next + 1];
      const char second = characterOf(secondType);
      const TurtleCommand command = second != '\0' ? commandAfterAt(first, second) : TurtleCommand::None;
      if (command != TurtleCommand::None) {
        performAt(command, {sequence.parameters + nextOffset, program_.arity[secondType]});
        return 3;
      }
      name += program_.nameOf(secondType);
    }
    const bool isWhole = !(arity == 0 && takesSecondSymbol(first));
    const TurtleCommand command = first != '\0' && isWhole ? commandAfterAt(first, '\0') : TurtleCommand::None;
    if (command != TurtleCommand::None) {
      performAt(command, {sequence.parameters + nextOffset, arity});
      return 2;
    }
  }
  // unknown: what follows is interpreted on its own
  warnOnce("the turtle knows no '@" + name + "'; the symbols after the '@' are interpreted on their own");
  return 1;
}

std::uint64_t Interpretation::executeSurface(const Sequence& sequence, std::uint64_t i, std::uint64_t offset) {
  const std::uint64_t next = i + 1;
  if (next >= sequence.count) {
    return 1;
  }
  const ModuleTypeId type = sequence.types[next];
  const char id = characterOf(type);
  if (id == '\0' || type == program_.openBranch || type == program_.closeBranch) {
    return 1;
  }
  const std::uint64_t nextOffset = offset + program_.arity[sequence.types[i]];
  const Arguments arguments{sequence.parameters + nextOffset, program_.arity[type]};
  // fewer than three parameters: the first scales all directions
  const double a = arguments.valueOr(0, 1.0);
  const core::Vec3 factor =
      arguments.count >= 3 ? core::Vec3{a, arguments.values[1], arguments.values[2]} : core::Vec3{a, a, a};
  for (std::size_t k = 0; k < view_.surfaces.size(); ++k) {
    const language::Surface& surface = view_.surfaces[k];
    if (surface.id != id) {
      continue;
    }
    drawing_.surface(state_, static_cast<std::uint32_t>(k), false, factor * state_.scale);
    // the end point is scaled by the first parameter alone
    const core::Vec3 end = surface.endPoint * (a * state_.scale);
    state_.position =
        state_.position + end.x * state_.frame.left + end.y * state_.frame.heading + end.z * state_.frame.up;
    checkPosition();
    isTouched_ = true;
    return 2;
  }
  for (std::size_t k = 0; k < view_.triangleSurfaces.size(); ++k) {
    if (view_.triangleSurfaces[k].id == id) {
      drawing_.surface(state_, static_cast<std::uint32_t>(k), true, factor * state_.scale);
      isTouched_ = true;
      return 2;
    }
  }
  // a surface without a file draws nothing and the turtle stays
  warnOnce(std::string("the surface '~") + id + "' is not defined in the view file and is not drawn");
  return 2;
}

std::uint64_t Interpretation::endOfCut(std::uint64_t i) {
  const auto types = plantState_.string.types();
  std::uint64_t branches = 0;
  std::uint64_t systems = 0;
  const bool isInSystem = !instances_.empty();
  for (; i < types.size(); ++i) {
    if (types[i] == program_.openBranch) {
      ++branches;
    } else if (types[i] == program_.closeBranch) {
      if (branches == 0) {
        return i;
      }
      --branches;
    } else if (types[i] == program_.subSystemEnd) {
      if (systems == 0 && isInSystem) {
        return i;
      }
      systems -= systems > 0 ? 1U : 0U;
    } else if (isCall(types[i])) {
      // the numbering of sub-L-system calls goes on
      ++systems;
      ++instanceCount_;
    }
  }
  return i;
}

void Interpretation::openBranch() {
  if (stack_.size() >= derivation_.options().limits.maximumTurtleStack) {
    fail(core::SimulationErrorCode::LimitExceeded,
         "more than " + std::to_string(derivation_.options().limits.maximumTurtleStack) +
             " brackets are open, the limit maximumTurtleStack. Raise the limit if the model is meant to do this");
  }
  stack_.push_back(state_);
  ++state_.branchOrder;
}

void Interpretation::closeBranch() {
  if (stack_.empty()) {
    return;
  }
  state_ = stack_.back();
  stack_.pop_back();
}

bool Interpretation::isCall(ModuleTypeId type) const {
  return static_cast<TurtleCommand>(commandOf_[type]) == TurtleCommand::Query && program_.arity[type] > 0;
}

void Interpretation::leaveInstance() {
  if (!instances_.empty()) {
    instances_.pop_back();
  }
}

void Interpretation::enterScale(const Arguments& arguments) {
  scales_.push_back({state_.scale, state_.width});
  const double factor = arguments.valueOr(1, 1.0);
  state_.scale *= factor;
  state_.width *= factor;
}

void Interpretation::leaveScale() {
  if (!scales_.empty()) {
    state_.scale = scales_.back().scale;
    state_.width = scales_.back().width;
    scales_.pop_back();
  }
}

TurtleRecord Interpretation::stateAfter(std::uint64_t module, std::uint64_t offset) const {
  const ModuleTypeId type = plantState_.string.types()[module];
  const auto parameters = plantState_.string.parameters().subspan(offset, program_.arity[type]);
  return {.plant = plant_,
          .module = module,
          .symbol = program_.symbolOf[type],
          .position = state_.position,
          .frame = state_.frame,
          .width = state_.width,
          .colour = state_.colour,
          .branchOrder = state_.branchOrder,
          .parent = kNoParent,
          .parameters = {parameters.begin(), parameters.end()}};
}

void Interpretation::record(std::uint64_t module, std::uint64_t offset) {
  const auto index = static_cast<std::uint32_t>(output_.records->size());
  output_.records->push_back(stateAfter(module, offset));
  output_.records->back().parent = state_.record;
  state_.record = index;
}

void Interpretation::warnOnce(std::string text) {
  const core::MessageSink& messages = derivation_.options().messages;
  if (messages && reported_.size() < core::DiagnosticList::kLimit && reported_.insert(text).second) {
    messages(core::MessageKind::Warning, text);
  }
}

void Interpretation::fail(core::SimulationErrorCode code, const std::string& what) const {
  const std::uint64_t step = plantState_.step + 1;
  core::SimulationError error;
  error.code = code;
  error.step = step;
  error.plant = plant_;
  error.message = "step " + std::to_string(step) + ", plant " + std::to_string(plant_);
  if (module_ < plantState_.string.size()) {
    error.module = module_;
    error.message += ", module " + std::to_string(module_) + " ('" +
                     std::string(program_.nameOf(plantState_.string.types()[module_])) + "')";
  }
  error.message += ": " + what + ".";
  throw core::SimulationFailure(std::move(error));
}

void Interpretation::checkPosition() const {
  if (std::isfinite(state_.position.x + state_.position.y + state_.position.z)) {
    return;
  }
  std::string text;
  core::appendNumber(text, state_.position.x, core::NumberStyle::Shortest);
  text += ", ";
  core::appendNumber(text, state_.position.y, core::NumberStyle::Shortest);
  text += ", ";
  core::appendNumber(text, state_.position.z, core::NumberStyle::Shortest);
  fail(core::SimulationErrorCode::NonFinite,
       "the turtle's position became (" + text + ") while interpreting. Bound the lengths and scales of the model");
}

}  // namespace espalier::turtle
