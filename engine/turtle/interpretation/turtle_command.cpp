#include "engine/turtle/interpretation/turtle_command.h"

#include <array>
#include <string_view>

namespace espalier::turtle {

namespace {

struct Entry {
  std::string_view text;
  TurtleCommand command;
};

constexpr std::array kSingle = {
    Entry{"F", TurtleCommand::DrawVertex}, Entry{"G", TurtleCommand::Draw},
    Entry{"f", TurtleCommand::MoveVertex}, Entry{"g", TurtleCommand::Move},
    Entry{"+", TurtleCommand::TurnLeft},   Entry{"-", TurtleCommand::TurnRight},
    Entry{"&", TurtleCommand::PitchDown},  Entry{"^", TurtleCommand::PitchUp},
    Entry{"/", TurtleCommand::RollRight},  Entry{"\\", TurtleCommand::RollLeft},
    Entry{"|", TurtleCommand::TurnAround}, Entry{";", TurtleCommand::ColourUp},
    Entry{",", TurtleCommand::ColourDown}, Entry{"#", TurtleCommand::WidthUp},
    Entry{"!", TurtleCommand::WidthDown},  Entry{"{", TurtleCommand::PolygonBegin},
    Entry{".", TurtleCommand::Vertex},     Entry{"}", TurtleCommand::PolygonEnd},
    Entry{"_", TurtleCommand::Elasticity}, Entry{"~", TurtleCommand::Surface},
    Entry{"@", TurtleCommand::At},         Entry{"?", TurtleCommand::Query},
};

constexpr std::array kAfterAt = {
    Entry{"M", TurtleCommand::SetPosition},       Entry{"R", TurtleCommand::SetHeading},
    Entry{"v", TurtleCommand::RollToVertical},    Entry{"O", TurtleCommand::Sphere},
    Entry{"o", TurtleCommand::ScreenDisc},        Entry{"c", TurtleCommand::Disc},
    Entry{"bo", TurtleCommand::ScreenDisc},       Entry{"bc", TurtleCommand::Disc},
    Entry{"D", TurtleCommand::SetScale},          Entry{"Di", TurtleCommand::ScaleUp},
    Entry{"Dd", TurtleCommand::ScaleDown},        Entry{"!", TurtleCommand::SetContourSides},
    Entry{"#", TurtleCommand::SetContour},        Entry{"Gs", TurtleCommand::CylinderStart},
    Entry{"Gc", TurtleCommand::CylinderPoint},    Entry{"Ge", TurtleCommand::CylinderEnd},
    Entry{"Gt", TurtleCommand::CylinderTangents}, Entry{"Gr", TurtleCommand::CylinderRadius},
    Entry{"Tx", TurtleCommand::SetTexture},       Entry{"Ts", TurtleCommand::ElasticitySet},
    Entry{"Ti", TurtleCommand::ElasticityUp},     Entry{"Td", TurtleCommand::ElasticityDown},
    Entry{"Tf", TurtleCommand::KeepTwist},        Entry{"Tp", TurtleCommand::TransportUp},
    Entry{"PS", TurtleCommand::PatchStart},       Entry{"PC", TurtleCommand::PatchPoint},
    Entry{"PD", TurtleCommand::PatchDraw},        Entry{"L", TurtleCommand::Label},
    Entry{"S", TurtleCommand::SystemCall},        Entry{"I", TurtleCommand::Ignored},
    Entry{"J", TurtleCommand::Ignored},           Entry{"mo", TurtleCommand::Ignored},
    Entry{"mc", TurtleCommand::ConditionalCut},   Entry{";", TurtleCommand::BackColourUp},
    Entry{",", TurtleCommand::BackColourDown},    Entry{"X", TurtleCommand::ExchangeFrames},
    Entry{"A", TurtleCommand::ScaleAngle},        Entry{"W", TurtleCommand::ScaleWidth},
    Entry{"C", TurtleCommand::CycleColour},       Entry{"Z", TurtleCommand::TurnInPlane},
    Entry{"B", TurtleCommand::BendDown},
};

}  // namespace

TurtleCommand commandOf(char character, std::uint16_t arity) {
  // symbols whose meaning depends on the number of parameters
  switch (character) {
    case '[':
      return arity == 0 ? TurtleCommand::OpenBranch : TurtleCommand::None;
    case ']':
      return arity == 0 ? TurtleCommand::CloseBranch : TurtleCommand::None;
    case '%':
      return arity == 0 ? TurtleCommand::Cut : TurtleCommand::None;
    case '$':
      return arity == 0 ? TurtleCommand::SubSystemEnd : TurtleCommand::None;
    case 's':
      return arity == 2 || arity == 3 ? TurtleCommand::LegacyPosition : TurtleCommand::None;
    default:
      break;
  }
  for (const Entry& entry : kSingle) {
    if (entry.text[0] == character) {
      return entry.command;
    }
  }
  return TurtleCommand::None;
}

TurtleCommand commandAfterAt(char first, char second) {
  for (const Entry& entry : kAfterAt) {
    const char entrySecond = entry.text.size() > 1 ? entry.text[1] : '\0';
    if (entry.text[0] == first && entrySecond == second) {
      return entry.command;
    }
  }
  return TurtleCommand::None;
}

bool isAddition(TurtleCommand command) {
  return command >= TurtleCommand::ExchangeFrames && command <= TurtleCommand::BendDown;
}

bool takesSecondSymbol(char first) {
  return std::string_view("PTGmDb").find(first) != std::string_view::npos && first != '\0';
}

}  // namespace espalier::turtle
