#pragma once

#include <cstdint>

namespace espalier::turtle {

/// The turtle's command for a symbol. The order of the enumerators has no meaning.
enum class TurtleCommand : std::uint8_t {
  None,
  // one symbol
  DrawVertex,    // F
  Draw,          // G
  MoveVertex,    // f
  Move,          // g
  TurnLeft,      // +
  TurnRight,     // -
  PitchDown,     // &
  PitchUp,       // ^
  RollRight,     // /
  RollLeft,      // the backslash
  TurnAround,    // |
  OpenBranch,    // [
  CloseBranch,   // ]
  ColourUp,      // ;
  ColourDown,    // ,
  WidthUp,       // #
  WidthDown,     // !
  PolygonBegin,  // {
  Vertex,        // .
  PolygonEnd,    // }
  Elasticity,    // _
  Cut,           // %
  SubSystemEnd,  // $
  // first symbol of a pair or triple
  Surface,  // ~
  At,       // @
  Query,    // ?
  // the legacy query
  LegacyPosition,  // s
  // after @
  SetPosition,       // M
  SetHeading,        // R
  RollToVertical,    // v
  Sphere,            // O
  ScreenDisc,        // o
  Disc,              // c
  SetScale,          // D
  ScaleUp,           // Di
  ScaleDown,         // Dd
  SetContourSides,   // !
  SetContour,        // #
  CylinderStart,     // Gs
  CylinderPoint,     // Gc
  CylinderEnd,       // Ge
  CylinderTangents,  // Gt
  CylinderRadius,    // Gr
  SetTexture,        // Tx
  ElasticitySet,     // Ts
  ElasticityUp,      // Ti
  ElasticityDown,    // Td
  KeepTwist,         // Tf
  TransportUp,       // Tp
  // in Espalier's own mode only, for other dialects
  ExchangeFrames,  // X
  ScaleAngle,      // A
  ScaleWidth,      // W
  CycleColour,     // C
  TurnInPlane,     // Z
  BendDown,        // B
  PatchStart,      // PS
  PatchPoint,      // PC
  PatchDraw,       // PD
  Label,           // L
  SystemCall,      // S
  Ignored,         // I J mo: for other renderers
  ConditionalCut,  // mc
  BackColourUp,    // ;
  BackColourDown,  // ,
};

/// The command of a symbol with `arity` parameters on its own; `character` 0 (a declared name) has none.
[[nodiscard]] TurtleCommand commandOf(char character, std::uint16_t arity);

/// The command of `first` after `@`, or of `first second` when second is not 0. None: unknown.
[[nodiscard]] TurtleCommand commandAfterAt(char first, char second);

/// Whether a command exists in Espalier's own mode only.
[[nodiscard]] bool isAddition(TurtleCommand command);

/// Whether `first` after `@`, when it has no parameters, takes one more symbol: P T G m D b.
[[nodiscard]] bool takesSecondSymbol(char first);

}  // namespace espalier::turtle
