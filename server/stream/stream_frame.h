#pragma once

#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/simulation/view_drawing.h"
#include "engine/turtle/interpretation/record_chain.h"
#include "protocol/messages.h"
#include "server/stream/geometry_frame.h"
#include "server/stream/query_recorder.h"
#include "server/stream/turtle_frame.h"

namespace espalier::server {

/// The last frame of a viewer, from which differences are told. Null: none.
struct FrameBase {
  std::shared_ptr<const turtle::RecordChain> chain;  // of all records, where drawings are repeatable
  std::shared_ptr<const TurtleFrame> turtle;         // of a selection, or where they are not
  std::shared_ptr<const GeometryFrame> geometry;
  std::shared_ptr<const std::string> text;

  [[nodiscard]] bool isEmpty() const {
    return chain == nullptr && turtle == nullptr && geometry == nullptr && text == nullptr;
  }
  [[nodiscard]] std::uint64_t bytes() const;
  bool operator==(const FrameBase&) const = default;  // the same ones
};

/// One frame as it is sent.
struct StreamFrame {
  protocol::Body body;  // as in protocol::StreamData
  bool isKey = true;
  FrameBase base;  // for the next one; empty for streams without differences
};

/// Makes the frames of one view of a simulation for all its streams. Parts that several streams need are made once.
/// Refers to the drawing: use it before the next view is shown.
class FrameMaker {
 public:
  /// `milliseconds` of the step that made the view; `queries` of it, or null.
  FrameMaker(simulation::ViewDrawing& drawing, double milliseconds, std::shared_ptr<const QueryRecord> queries)
      : drawing_(drawing),
        milliseconds_(milliseconds),
        queries_(std::move(queries)),
        symbols_(std::make_shared<const std::vector<std::string>>(drawing.symbolNames())) {}

  /// The difference from `base` when the stream wants differences and it is shorter, else a key frame.
  [[nodiscard]] tl::expected<StreamFrame, core::SimulationError> make(const protocol::StreamOpenParams& params,
                                                                      const FrameBase& base);

 private:
  struct Turtle {
    protocol::StreamSelection select;
    std::shared_ptr<const TurtleFrame> frame;
  };
  struct Geometry {
    protocol::StreamSelection select;
    std::shared_ptr<const GeometryFrame> frame;
  };
  struct Made {
    protocol::StreamOpenParams params;
    FrameBase base;
    StreamFrame frame;
  };

  [[nodiscard]] tl::expected<std::shared_ptr<const TurtleFrame>, core::SimulationError> turtle(
      const protocol::StreamSelection& select);
  [[nodiscard]] tl::expected<StreamFrame, core::SimulationError> makeNew(const protocol::StreamOpenParams& params,
                                                                         const FrameBase& base);
  [[nodiscard]] tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> chain();
  [[nodiscard]] tl::expected<StreamFrame, core::SimulationError> makeTurtle(const protocol::StreamOpenParams& params,
                                                                            const FrameBase& base);
  [[nodiscard]] tl::expected<StreamFrame, core::SimulationError> makeGeometry(const protocol::StreamOpenParams& params,
                                                                              const FrameBase& base);
  [[nodiscard]] tl::expected<std::shared_ptr<const GeometryFrame>, core::SimulationError> geometry(
      const protocol::StreamSelection& select);
  [[nodiscard]] StreamFrame makeText(const protocol::StreamOpenParams& params, const FrameBase& base);

  simulation::ViewDrawing& drawing_;
  double milliseconds_;
  std::shared_ptr<const QueryRecord> queries_;
  std::shared_ptr<const std::vector<std::string>> symbols_;
  std::optional<std::vector<turtle::TurtleRecord>> records_;
  std::optional<std::shared_ptr<const turtle::RecordChain>> chain_;  // null: the drawings are not repeatable
  std::vector<Turtle> turtles_;
  std::vector<Geometry> geometries_;
  std::vector<std::pair<std::uint32_t, std::shared_ptr<const std::string>>> texts_;  // plant, its string
  std::vector<Made> made_;
};

/// The turtle records of a simulation as they are now, as simulation.get tells them.
[[nodiscard]] tl::expected<protocol::Body, core::SimulationError> turtleBody(const simulation::Simulation& simulation,
                                                                             const protocol::StreamOpenParams& params);

}  // namespace espalier::server
