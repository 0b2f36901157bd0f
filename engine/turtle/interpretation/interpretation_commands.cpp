#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/tropism.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr double kLargestWidth = 1e300;
constexpr double kSmallestBend = 1e-12;
constexpr double kStepLength = 1.0;  // of F without a parameter

std::int32_t wrappedColour(std::int64_t colour) {
  return static_cast<std::int32_t>(((colour % 256) + 256) % 256);
}

// among the colours 1 to 255; one step down from 0 is 255, as from 1
std::int32_t cycledColour(std::int64_t colour, std::int64_t change) {
  constexpr std::int64_t kCount = 255;
  const std::int64_t index = (change < 0 ? std::max<std::int64_t>(colour, 1) : colour) - 1 + change;
  return static_cast<std::int32_t>((index % kCount + kCount) % kCount + 1);
}

}  // namespace

double Interpretation::angleRadians(const Arguments& arguments) const {
  return arguments.valueOr(0, view_.angleIncrementDegrees * state_.angleFactor) * kRadiansPerDegree;
}

void Interpretation::perform(TurtleCommand command, const Arguments& arguments) {
  switch (command) {
    case TurtleCommand::DrawVertex:
      advance(arguments, true, true);
      return;
    case TurtleCommand::Draw:
      advance(arguments, true, false);
      return;
    case TurtleCommand::MoveVertex:
      advance(arguments, false, true);
      return;
    case TurtleCommand::Move:
      advance(arguments, false, false);
      return;
    case TurtleCommand::TurnLeft:
      turnLeft(state_.frame, turns_.turnBy(angleRadians(arguments)));
      return;
    case TurtleCommand::TurnRight:
      turnLeft(state_.frame, turns_.turnBy(-angleRadians(arguments)));
      return;
    case TurtleCommand::PitchDown:
      pitchDown(state_.frame, turns_.turnBy(angleRadians(arguments)));
      return;
    case TurtleCommand::PitchUp:
      pitchDown(state_.frame, turns_.turnBy(-angleRadians(arguments)));
      return;
    case TurtleCommand::RollRight:
      rollRight(state_.frame, turns_.turnBy(angleRadians(arguments)));
      return;
    case TurtleCommand::RollLeft:
      rollRight(state_.frame, turns_.turnBy(-angleRadians(arguments)));
      return;
    case TurtleCommand::TurnAround:
      turnAround(state_.frame);
      return;
    case TurtleCommand::ColourUp:
      changeColour(arguments, 1, false);
      return;
    case TurtleCommand::ColourDown:
      changeColour(arguments, -1, false);
      return;
    case TurtleCommand::WidthUp:
      changeWidth(arguments, 1.0);
      return;
    case TurtleCommand::WidthDown:
      changeWidth(arguments, -1.0);
      return;
    case TurtleCommand::PolygonBegin:
      if (arguments.count > 0) {
        checkOrgan({state_.width, 0.0, 0.0});
        drawing_.beginCylinder(state_, wholeNumber(arguments.values[0]), wholeNumber(arguments.valueOr(1, 0.0)));
      } else {
        drawing_.beginPolygon(state_);
      }
      return;
    case TurtleCommand::Vertex:
      drawing_.vertex(state_, wholeNumber(arguments.valueOr(0, 0.0)));
      return;
    case TurtleCommand::PolygonEnd:
      drawing_.endPolygon();
      isTouched_ = true;
      return;
    case TurtleCommand::Elasticity:
      if (view_.oldTropism.isActive) {
        state_.oldElasticity =
            arguments.count > 0 ? arguments.values[0] : state_.oldElasticity + view_.oldTropism.elasticityIncrement;
      }
      return;
    default:
      return;
  }
}

void Interpretation::advance(const Arguments& arguments, bool draws, bool addsVertex) {
  // bend, move, draw, and bend again by the old tropism
  if (!view_.movements.empty()) {
    applyMovements(state_, view_.movements, elementary_);
  }
  const Vec3 start = state_.position;
  state_.position = start + (arguments.valueOr(0, kStepLength) * state_.scale) * state_.frame.heading;
  if (draws && isDisplaced_) {
    state_.position = state_.position + coordinates_.toWorldDirection(view_.displacement);
  }
  checkPosition();
  isTouched_ = true;
  if (draws) {
    drawing_.line(state_, start);
    if (output_.scene != nullptr) {
      checkCount(output_.scene->segments.size());
    }
    rememberFrame(state_);
  }
  if (addsVertex) {
    drawing_.vertex(state_);
  }
  if (view_.oldTropism.isActive) {
    applyOldTropism(state_, view_.oldTropism, elementary_);
  }
}

void Interpretation::changeColour(const Arguments& arguments, int sign, bool isBack) {
  if (skipsAttributes_) {
    return;
  }
  std::int32_t& colour = isBack ? state_.backColour : state_.colour;
  const int increment = isBack ? view_.backColourIncrement : view_.colourIncrement;
  colour = wrappedColour(arguments.count > 0 ? std::int64_t{wholeNumber(arguments.values[0])}
                                             : std::int64_t{colour} + std::int64_t{sign} * increment);
}

void Interpretation::performAddition(TurtleCommand command, const Arguments& arguments) {
  switch (command) {
    case TurtleCommand::ExchangeFrames:
      std::swap(state_.frame, state_.otherFrame);
      return;
    case TurtleCommand::ScaleAngle:
      state_.angleFactor *= arguments.valueOr(0, 1.0);
      return;
    case TurtleCommand::ScaleWidth:
      state_.width = std::clamp(state_.width * arguments.valueOr(0, 1.0), kSmallestWidth, kLargestWidth);
      return;
    case TurtleCommand::CycleColour:
      state_.colour = cycledColour(state_.colour, wholeNumber(arguments.valueOr(0, 1.0)));
      return;
    case TurtleCommand::TurnInPlane: {
      const Vec3 axis = coordinates_.toWorldDirection({0.0, 0.0, 1.0});
      const double angle = angleRadians(arguments);
      const auto turned = [&](const Vec3& v) {
        return core::cos(angle) * v + core::sin(angle) * core::cross(axis, v) +
               ((1.0 - core::cos(angle)) * core::dot(axis, v)) * axis;
      };
      state_.frame = {turned(state_.frame.heading), turned(state_.frame.left), turned(state_.frame.up)};
      return;
    }
    case TurtleCommand::BendDown: {
      const Vec3 down = coordinates_.toWorldDirection({0.0, -1.0, 0.0});
      const double angle = arguments.valueOr(0, 0.0) * core::length(core::cross(state_.frame.heading, down));
      const Vec3 across = down - core::dot(down, state_.frame.heading) * state_.frame.heading;
      if (core::length(across) > kSmallestBend) {
        const Vec3 heading =
            core::normalised(core::cos(angle) * state_.frame.heading + core::sin(angle) * core::normalised(across));
        state_.frame.up = transported(state_.frame.up, state_.frame.heading, heading);
        state_.frame.heading = heading;
        state_.frame.left = core::cross(heading, state_.frame.up);
      }
      return;
    }
    default:
      return;
  }
}

void Interpretation::changeWidth(const Arguments& arguments, double sign) {
  if (skipsAttributes_) {
    return;
  }
  const double width = arguments.count > 0 ? arguments.values[0] * state_.scale
                                           : state_.width + sign * view_.lineWidthIncrement * state_.scale;
  state_.width = width > kSmallestWidth ? width : kSmallestWidth;
  if (std::isinf(width)) {
    fail(core::SimulationErrorCode::NonFinite, "the line width became infinite. Bound the widths of the model");
  }
}

void Interpretation::setTexture(std::int32_t texture) {
  state_.texture = texture;
  if (texture < 0 || static_cast<std::size_t>(texture) > view_.textures.size()) {
    warnOnce("there is no texture " + std::to_string(texture) + " for '@Tx' in the view file; parts with it are plain");
  }
}

void Interpretation::setRadiusTangents(const Arguments& arguments) {
  // one parameter is a flag; more are an angle to the axis and a length for the start and, if given, for the end
  state_.startRadiusTangent = 0.0;
  state_.endRadiusTangent = 0.0;
  if (arguments.count < 2) {
    state_.hasSmoothRadius = arguments.valueOr(0, 1.0) != 0.0;
    return;
  }
  state_.hasSmoothRadius = true;
  const double startLength = arguments.values[1];
  state_.startRadiusTangent = startLength * elementary_.sin(arguments.values[0] * kRadiansPerDegree);
  state_.endRadiusTangent = arguments.valueOr(3, startLength) *
                            elementary_.sin(arguments.valueOr(2, arguments.values[0]) * kRadiansPerDegree);
}

void Interpretation::changeElasticity(TurtleCommand command, const Arguments& arguments) {
  if (arguments.count == 0) {
    warnOnce("'@Ts', '@Ti' and '@Td' need the number of the tropism or torque: '@Ti(1)'");
    return;
  }
  const std::int32_t id = wholeNumber(arguments.values[0]);
  if (id < 1 || static_cast<std::size_t>(id) > std::min(view_.movements.size(), kMaximumMovements)) {
    warnOnce("the view file has no tropism or torque number " + std::to_string(id) + "; it has " +
             std::to_string(view_.movements.size()));
    return;
  }
  const auto index = static_cast<std::size_t>(id - 1);
  double& elasticity = state_.elasticity[index];
  if (command == TurtleCommand::ElasticitySet) {
    elasticity = arguments.valueOr(1, elasticity);
    return;
  }
  const double change = arguments.valueOr(1, view_.movements[index].elasticityStep);
  elasticity += command == TurtleCommand::ElasticityUp ? change : -change;
}

void Interpretation::addLabel(const Arguments& arguments) {
  // the text is the number of a string of the model
  if (arguments.count == 0 || !(arguments.values[0] >= 0.0) ||
      !(arguments.values[0] < static_cast<double>(program_.strings.size()))) {
    return;
  }
  const auto string = static_cast<std::size_t>(arguments.values[0]);
  drawing_.label(state_, formatLabel(program_.strings[string], {arguments.values + 1, arguments.count - 1U}));
  isTouched_ = true;
}

void Interpretation::performAt(TurtleCommand command, const Arguments& arguments) {
  switch (command) {
    case TurtleCommand::SetPosition:
      if (arguments.count >= 2) {
        state_.position =
            coordinates_.toWorldPoint({arguments.values[0], arguments.values[1], arguments.valueOr(2, 0.0)});
        checkPosition();
        isTouched_ = true;
      }
      return;
    case TurtleCommand::SetHeading: {
      const Vec3 heading{arguments.valueOr(0, 0.0), arguments.valueOr(1, 0.0), arguments.valueOr(2, 0.0)};
      if (arguments.count >= 6) {
        const Vec3 up{arguments.values[3], arguments.values[4], arguments.values[5]};
        setHeading(state_, coordinates_.toWorldDirection(heading), coordinates_.toWorldDirection(up));
      } else {
        setHeading(state_, coordinates_.toWorldDirection(heading));
      }
      isTouched_ = true;
      return;
    }
    case TurtleCommand::RollToVertical:
      rollToVertical(state_.frame);
      return;
    case TurtleCommand::Sphere:
    case TurtleCommand::ScreenDisc:
    case TurtleCommand::Disc: {
      const Ball::Kind kind = command == TurtleCommand::Sphere       ? Ball::Kind::Sphere
                              : command == TurtleCommand::ScreenDisc ? Ball::Kind::ScreenDisc
                                                                     : Ball::Kind::Disc;
      const double diameter = arguments.count > 0 ? arguments.values[0] * state_.scale : state_.width;
      checkOrgan({diameter, 0.0, 0.0});
      drawing_.ball(state_, kind, diameter);
      isTouched_ = true;
      return;
    }
    case TurtleCommand::SetScale:
      state_.scale = arguments.valueOr(0, state_.scale);
      return;
    case TurtleCommand::ScaleUp:
      state_.scale *= arguments.valueOr(0, view_.scaleMultiplier);
      return;
    case TurtleCommand::ScaleDown: {
      const double divisor = arguments.valueOr(0, view_.scaleMultiplier);
      if (divisor == 0.0) {
        warnOnce("'@Dd(0)' would divide the turtle's scale by 0 and is ignored");
        return;
      }
      state_.scale /= divisor;
      return;
    }
    case TurtleCommand::SetContourSides:
      if (arguments.count > 0) {
        state_.contourSides = std::clamp(wholeNumber(arguments.values[0]), 3, 1000);
      }
      return;
    case TurtleCommand::SetContour:
      state_.contour = wholeNumber(arguments.valueOr(0, 0.0));
      return;
    case TurtleCommand::CylinderStart:
      checkOrgan({state_.width, 0.0, 0.0});
      drawing_.startAxisCylinder(state_);
      return;
    case TurtleCommand::CylinderPoint:
      checkOrgan({state_.width, 0.0, 0.0});
      drawing_.addAxisCylinderPoint(state_, wholeNumber(arguments.valueOr(0, 0.0)));
      isTouched_ = true;
      return;
    case TurtleCommand::CylinderEnd:
      checkOrgan({state_.width, 0.0, 0.0});
      drawing_.endAxisCylinder(state_, wholeNumber(arguments.valueOr(0, 0.0)));
      isTouched_ = true;
      return;
    case TurtleCommand::CylinderTangents:
      state_.startTangent = arguments.valueOr(0, 1.2);
      state_.endTangent = arguments.valueOr(1, state_.startTangent);
      return;
    case TurtleCommand::CylinderRadius:
      setRadiusTangents(arguments);
      return;
    case TurtleCommand::SetTexture:
      setTexture(wholeNumber(arguments.valueOr(0, 0.0)));
      return;
    case TurtleCommand::ElasticitySet:
    case TurtleCommand::ElasticityUp:
    case TurtleCommand::ElasticityDown:
      changeElasticity(command, arguments);
      return;
    case TurtleCommand::KeepTwist:
      rememberFrame(state_);
      return;
    case TurtleCommand::TransportUp:
      transportUp(state_);
      return;
    case TurtleCommand::PatchStart:
      drawing_.startPatch(wholeNumber(arguments.valueOr(0, 0.0)));
      return;
    case TurtleCommand::PatchPoint:
      if (arguments.count >= 3) {
        drawing_.setPatchPoint(state_, wholeNumber(arguments.values[0]), wholeNumber(arguments.values[1]),
                               wholeNumber(arguments.values[2]));
      }
      return;
    case TurtleCommand::PatchDraw:
      drawing_.drawPatch(state_, wholeNumber(arguments.valueOr(0, 0.0)), wholeNumber(arguments.valueOr(1, 5.0)),
                         wholeNumber(arguments.valueOr(2, 5.0)));
      isTouched_ = true;
      return;
    case TurtleCommand::Label:
      addLabel(arguments);
      return;
    case TurtleCommand::SystemCall:
      warnOnce("'@S' would run a command of the operating system: Espalier refuses it");
      return;
    case TurtleCommand::ConditionalCut:
      isCut_ = !view_.interpretsPastCut && arguments.valueOr(0, 0.0) == 1.0;
      return;
    case TurtleCommand::BackColourUp:
      changeColour(arguments, 1, true);
      return;
    case TurtleCommand::BackColourDown:
      changeColour(arguments, -1, true);
      return;
    default:
      performAddition(command, arguments);
      return;
  }
}

}  // namespace espalier::turtle
