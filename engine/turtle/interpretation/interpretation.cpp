#include "engine/turtle/interpretation/interpretation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "engine/core/buffer.h"
#include "engine/core/number_text.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::ModuleTypeId;

namespace {

using Role = InterpretationTables::Role;

constexpr std::uint64_t kPollInterval = 65'536;      // modules between two looks at `cancelled`
constexpr std::uint64_t kSmallestReserved = 10'000;  // modules; a shorter string's output grows fast enough
constexpr std::uint64_t kFirstForecast = 16;         // part of the string after which the output is forecast
constexpr double kForecastMargin = 1.0625;
constexpr double kMostForecast = 4.0;                                        // times what is there
constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();  // no module has this index

/// Makes room for `count` more, in huge pages. Grows at least by half, so that many plants do not copy one another
/// again and again. Returns whether there was none.
template <typename List>
bool reserveMore(List& list, std::size_t count) {
  if (count <= list.capacity() - list.size()) {
    return false;
  }
  list.reserve(std::max(list.size() + count, list.capacity() + list.capacity() / 2));
  core::adviseHugePages(list.data() + list.size(), (list.capacity() - list.size()) * sizeof(*list.data()));
  return true;
}

}  // namespace

std::int32_t wholeNumber(double value) {
  return std::abs(value) < 2e9 ? static_cast<std::int32_t>(value) : 0;
}

Interpretation::Interpretation(const Subject& subject, const InterpretationOutput& output)
    : program_(subject.program),
      elementary_(subject.program.compatibility),
      view_(subject.program.view),
      tables_(subject.tables),
      reported_(subject.reported),
      derivation_(subject.derivation),
      plantState_(subject.plantState),
      plant_(subject.plant),
      coordinates_(subject.placement.position, subject.placement.frame),
      output_(output),
      drawing_(output.scene, subject.program.view, subject.plant),
      turns_(elementary_),
      isDisplaced_(subject.program.view.displacement != core::Vec3{}),
      isEnvironmentPass_(output.queries != nullptr),
      skipsAttributes_(isEnvironmentPass_ && isCompatible()) {
  // queries are filled in while the walk reads: the memory stays in its place from here on
  if (output.fillsQueries) {
    static_cast<void>(plantState_.string.mutableParameters());
  }
  const PlantPlacement& placement = subject.placement;
  state_.position = coordinates_.toWorldPoint(view_.initialPosition);
  state_.frame = placement.frame;
  if (view_.initialHeading != core::Vec3{0.0, 1.0, 0.0}) {
    state_.frame.heading = coordinates_.toWorldDirection(view_.initialHeading);
    state_.frame.up = transported(placement.frame.up, placement.frame.heading, state_.frame.heading);
    state_.frame.left = core::cross(state_.frame.heading, state_.frame.up);
  }
  state_.otherFrame = state_.frame;
  state_.previousHeading = state_.frame.heading;
  state_.previousUp = state_.frame.up;
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
  reserveOutput();
  walkAll();
  segments_.touch = {};
  records_.touch = {};
  derivation_.endInterpretation(plantState_);
  drawing_.finish();
}

void Interpretation::runAround(std::span<const BranchPart> branches, std::span<BranchStart> starts,
                               std::vector<std::string>& warnings) {
  branches_ = branches;
  start_ = starts.data();
  warnings_ = &warnings;
  derivation_.beginInterpretation(plantState_);
  walkAll();
  derivation_.endInterpretation(plantState_);
}

bool Interpretation::runBranch(const BranchPart& branch, const BranchStart& start, std::vector<std::string>& warnings) {
  warnings_ = &warnings;
  state_ = start.state;
  Scene* const scene = output_.scene;
  if (scene != nullptr) {
    scene->segments.push_back(start.parent);
    scene->cylinders.emplace_back();
    state_.segment = state_.segment == kNoParent ? kNoParent : 0;
    state_.cylinder = state_.cylinder == kNoParent ? kNoParent : 0;
  }
  std::uint64_t module = branch.firstModule;
  std::uint64_t offset = branch.firstOffset;
  walk(module, branch.endModule, offset);
  return !drawing_.hasOpenShape() && (scene == nullptr || scene->cylinders.front().points.empty());
}

void Interpretation::begin() {
  derivation_.beginInterpretation(plantState_);
}

void Interpretation::end() {
  derivation_.endInterpretation(plantState_);
}

bool Interpretation::walkOne(std::uint64_t& module, std::uint64_t& offset) {
  wasCut_ = false;
  walk(module, module + 1, offset);
  if (wasCut_) {
    return false;
  }
  // a symbol that takes the next ones with it: `@`, `~`, `?`, and a possible second of three
  const auto* types = plantState_.string.types().data();
  const auto takesMore = [&](std::uint64_t i) {
    const TurtleCommand command = tables_.commandOf[types[i]];
    return command == TurtleCommand::At || command == TurtleCommand::Surface || command == TurtleCommand::Query;
  };
  return !takesMore(module - 1) && (module < 2 || !takesMore(module - 2));
}

void Interpretation::walkAll() {
  std::uint64_t module = 0;
  std::uint64_t offset = 0;
  walk(module, plantState_.string.size(), offset);
}

void Interpretation::reserveOutput() {
  // queries are collected into the same memory in every step
  if (plantState_.string.size() < kSmallestReserved || (output_.scene == nullptr && output_.records == nullptr)) {
    return;
  }
  if (tables_.hasImages || tables_.hasCut) {
    // the string does not tell the count: the walk so far will
    segments_.first = output_.scene == nullptr ? 0 : output_.scene->segments.size();
    records_.first = output_.records == nullptr ? 0 : output_.records->size();
    nextForecast_ = plantState_.string.size() / kFirstForecast;
    return;
  }
  std::size_t segments = 0;
  std::size_t records = 0;
  for (const ModuleTypeId type : plantState_.string.types()) {
    const std::uint8_t adds = tables_.adds[type];
    segments += adds & InterpretationTables::kSegment;
    records += (adds & InterpretationTables::kRecord) / InterpretationTables::kRecord;
  }
  if (output_.scene != nullptr && reserveMore(output_.scene->segments, segments)) {
    touchNext(output_.scene->segments, segments, segments_.touch);
  }
  if (output_.records != nullptr && reserveMore(*output_.records, records)) {
    touchNext(*output_.records, records, records_.touch);
  }
}

// makes room for the output that the rest of the string will add, if it is like the modules before `i`
void Interpretation::forecastOutput(std::uint64_t i) {
  const auto forecast = [&](auto& list, Forecast& of) {
    // the rest may be bare, as the last modules were, or as most have been
    const double lately = static_cast<double>(list.size() - of.last) / static_cast<double>(kPollInterval);
    const double always = static_cast<double>(list.size() - of.first) / static_cast<double>(i);
    const double wanted =
        std::min(lately, always) * static_cast<double>(plantState_.string.size() - i) * kForecastMargin;
    const auto most = static_cast<double>(list.size() - of.first);  // as much as there is: it is forecast again soon
    try {
      of.touch = {};
      static_cast<void>(reserveMore(list, static_cast<std::size_t>(std::min(wanted, kMostForecast * most))));
      touchNext(list, static_cast<std::size_t>(std::min(wanted, most)), of.touch);
    } catch (const std::bad_alloc&) {
      // it was a guess: the lines that come may still find room
    }
  };
  if (output_.scene != nullptr) {
    forecast(output_.scene->segments, segments_);
  }
  if (output_.records != nullptr) {
    forecast(*output_.records, records_);
  }
  nextForecast_ = 2 * i;
}

// lets another thread touch the memory of the next items of a list
template <typename List>
void Interpretation::touchNext(List& list, std::size_t count, std::jthread& touch) {
  if (derivation_.options().threads > 1) {
    touch = core::populatePagesFromEnd(list.data() + list.size(), count * sizeof(*list.data()));
  }
}

void Interpretation::walk(std::uint64_t& module, std::uint64_t end, std::uint64_t& firstOffset) {
  const Sequence string{plantState_.string.types().data(), plantState_.string.parameters().data(),
                        plantState_.string.size(), false};
  const std::uint16_t* arity = program_.arity.data();
  const std::uint8_t* isSkipped = tables_.isSkipped.data();
  const bool isWatched = static_cast<bool>(output_.onModule);
  const std::atomic<bool>* cancelled = derivation_.options().cancelled;
  std::uint64_t nextPoll = module;
  std::uint64_t offset = firstOffset;
  std::uint64_t nextBranch = branches_.empty() ? kNever : branches_.front().firstModule;
  std::uint64_t i = module;
  while (i < end) {
    if (i >= nextPoll) {
      nextPoll = i + kPollInterval;
      if (nextForecast_ != kNever) {
        if (i >= nextForecast_ && i > 0) {
          forecastOutput(i);
        }
        segments_.last = output_.scene == nullptr ? 0 : output_.scene->segments.size();
        records_.last = output_.records == nullptr ? 0 : output_.records->size();
      }
      if ((cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) || core::isWorkStopped()) {
        module_ = i;
        fail(core::SimulationErrorCode::Cancelled, "the step was cancelled");
      }
    }
    if (i >= nextBranch) {
      skipBranch(i, offset);
      nextBranch = branches_.empty() ? kNever : branches_.front().firstModule;
      continue;
    }
    const ModuleTypeId first = string.types[i];
    if (isSkipped[first] != 0 && !isWatched) {
      offset += arity[first];
      ++i;
      continue;
    }
    module_ = i;
    drawing_.setModule(i);
    isTouched_ = false;
    // a `$` belongs to the L-system around the call that it ends
    if (first == program_.subSystemEnd) {
      leaveInstance();
    }
    // the homomorphism's image stands for the module, otherwise the module itself
    std::uint64_t consumed = 0;
    if (tables_.mayExpand[first] != 0) {
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
      offset += arity[type];
      if (tables_.roleOf[type] == Role::Call) {
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
      output_.onModule(stateAfter(i - 1, lastOffset), i - consumed);
    }
    if (isCut_) {
      skipCut(i, offset);
      isCut_ = false;
      wasCut_ = true;
    }
  }
  module = i;
  firstOffset = offset;
}

void Interpretation::skipBranch(std::uint64_t& module, std::uint64_t& offset) {
  const BranchPart& branch = branches_.front();
  // a cut may have led beyond it
  if (module == branch.firstModule) {
    *start_ = {.isReached = true,
               .isWithinShape = drawing_.hasOpenShape(),
               .state = state_,
               .parent = {},
               .mark = mark(),
               .drawn = {}};
    if (output_.scene != nullptr) {
      start_->drawn = SceneMark(*output_.scene);
      start_->parent = state_.segment == kNoParent ? Segment{} : output_.scene->segments[state_.segment];
    }
    module = branch.endModule;
    offset = branch.endOffset;
  }
  branches_ = branches_.subspan(1);
  ++start_;
}

Interpretation::OutputMark Interpretation::mark() const {
  OutputMark result;
  result.queries = output_.queries == nullptr ? 0 : output_.queries->size();
  result.changes = output_.changes == nullptr ? 0 : output_.changes->size();
  result.warnings = warnings_ == nullptr ? 0 : warnings_->size();
  return result;
}

void Interpretation::walkImage() {
  const Sequence image{image_.types().data(), image_.parameters().data(), image_.size(), true};
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
  const TurtleCommand command = tables_.commandOf[type];
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
    const bool isForeign = isAddition(command) && isCompatible();
    if (command != TurtleCommand::None && !isForeign) {
      performAt(command, {sequence.parameters + nextOffset, arity});
      return 2;
    }
  }
  // unknown: the symbols behind it are interpreted on their own
  const std::vector<std::string>& reported = program_.reportedCommands;
  if (std::find(reported.begin(), reported.end(), name) == reported.end()) {
    warnOnce("the turtle has no command '@" + name + "': the symbols after the '@' are interpreted on their own");
  }
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
    const files::Surface& surface = view_.surfaces[k];
    if (surface.id != id) {
      continue;
    }
    checkOrgan(factor * state_.scale);
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
      checkOrgan(factor * state_.scale);
      TurtleState place = state_;
      place.position = place.position + coordinates_.toWorldDirection(view_.displacement);
      drawing_.surface(place, static_cast<std::uint32_t>(k), true, factor * state_.scale);
      isTouched_ = true;
      return 2;
    }
  }
  // a surface without a file draws nothing and the turtle stays; the compiler has said so
  return 2;
}

void Interpretation::skipCut(std::uint64_t& module, std::uint64_t& offset) {
  const ModuleTypeId* types = plantState_.string.types().data();
  const std::uint64_t size = plantState_.string.size();
  const Role* roleOf = tables_.roleOf.data();
  const std::uint16_t* arity = program_.arity.data();
  std::uint64_t branches = 0;
  std::uint64_t systems = 0;
  const bool isInSystem = !instances_.empty();
  std::uint64_t i = module;
  std::uint64_t next = offset;
  for (; i < size; ++i) {
    const ModuleTypeId type = types[i];
    const Role role = roleOf[type];
    if (role != Role::None) {
      if ((role == Role::CloseBranch && branches == 0) || (role == Role::SystemEnd && systems == 0 && isInSystem)) {
        break;
      }
      if (role == Role::OpenBranch) {
        ++branches;
      } else if (role == Role::CloseBranch) {
        --branches;
      } else if (role == Role::SystemEnd) {
        systems -= systems > 0 ? 1U : 0U;
      } else {
        // the numbering of sub-L-system calls goes on
        ++systems;
        ++instanceCount_;
      }
    }
    next += arity[type];
  }
  module = i;
  offset = next;
}

void Interpretation::openBranch() {
  if (state_.branchOrder >= derivation_.options().limits.maximumTurtleStack) {
    fail(core::SimulationErrorCode::LimitExceeded,
         "more than " + std::to_string(derivation_.options().limits.maximumTurtleStack) +
             " brackets are open, the limit turtleStack. Raise the limit if the model is meant to do this");
  }
  stack_.push_back(state_);
  ++state_.branchOrder;
}

void Interpretation::closeBranch() {
  if (stack_.empty()) {
    return;
  }
  if (notes_ != nullptr) {
    noteClosing();
  }
  state_ = stack_.back();
  stack_.pop_back();
}

void Interpretation::noteClosing() {
  StretchNotes& notes = *notes_;
  if (stack_.size() > notes.lowest) {
    return;
  }
  // records that grow from there name the record by its place in the notes
  TurtleState& state = stack_.back();
  notes.lowest = stack_.size() - 1;
  notes.closed.push_back(state);
  notes.outer.push_back(state.record);
  if (state.record != kNoParent) {
    state.record = kOuterRecord + static_cast<std::uint32_t>(notes.outer.size() - 1);
  }
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
  checkCount(output_.records->size());
  output_.records->push_back(stateAfter(module, offset));
  output_.records->back().parent = state_.record;
  state_.record = index;
}

void Interpretation::warnOnce(std::string text) {
  if (warnings_ != nullptr) {
    warnings_->push_back(std::move(text));
    return;
  }
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

void Interpretation::checkCount(std::size_t count) const {
  if (count >= kNoParent) [[unlikely]] {
    fail(core::SimulationErrorCode::LimitExceeded,
         "there are more lines or turtle records than their parents can be numbered with, " +
             std::to_string(kNoParent) + ". Draw fewer plants or fewer modules");
  }
}

void Interpretation::failPosition() const {
  std::string text;
  core::appendNumber(text, state_.position.x, core::NumberStyle::Shortest);
  text += ", ";
  core::appendNumber(text, state_.position.y, core::NumberStyle::Shortest);
  text += ", ";
  core::appendNumber(text, state_.position.z, core::NumberStyle::Shortest);
  fail(core::SimulationErrorCode::NonFinite,
       "the turtle's position became (" + text + ") while interpreting. Bound the lengths and scales of the model");
}

void Interpretation::checkOrgan(const core::Vec3& size) const {
  const auto isFinite = [](const core::Vec3& v) { return std::isfinite(v.x + v.y + v.z); };
  if (isFinite(size) && isFinite(state_.frame.heading) && isFinite(state_.frame.left) && isFinite(state_.frame.up)) {
    return;
  }
  fail(core::SimulationErrorCode::NonFinite,
       std::string("the ") + (isFinite(size) ? "direction" : "size") +
           " of what it draws is not finite. Bound the angles and scales of the model");
}

}  // namespace espalier::turtle
