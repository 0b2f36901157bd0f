#include "engine/turtle/export/picture/picture.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/worker_team.h"
#include "engine/turtle/export/picture/ground_shade.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_camera.h"
#include "engine/turtle/export/picture/raster_geometry.h"
#include "engine/turtle/export/picture/raster_shading.h"
#include "engine/turtle/export/picture/raster_target.h"

namespace espalier::turtle {

namespace {

constexpr std::size_t kTaskPieces = 64;       // most pieces of the scene that one task turns into triangles
constexpr std::size_t kTaskTriangles = 4096;  // about so many triangles at most, or those of one piece
constexpr std::size_t kRoundTasks = 16;       // tasks before the triangles are drawn
constexpr std::size_t kMostStanding = 1000;   // copies whose contact with the ground is drawn

/// The parts of all copies of the scenes of a picture.
class PlacedGeometry {
 public:
  PlacedGeometry(const PlacedScenes& placed, core::WorkerTeam& team) : placements_(placed.placements) {
    for (const ExportInput& input : placed.scenes) {
      scenes_.emplace_back(input, team);
    }
    firstParts_.push_back(0);
    for (const ScenePlacement& placement : placements_) {
      ESPALIER_CHECK(placement.scene < scenes_.size() && placement.scale > 0.0);
      firstParts_.push_back(firstParts_.back() + scenes_[placement.scene].geometry.partCount());
      framedPartCount_ = placed.scenes[placement.scene].isBackground ? framedPartCount_ : firstParts_.back();
    }
    framedPartCount_ = framedPartCount_ == 0 ? partCount() : framedPartCount_;
  }

  /// The data of one scene in a picture.
  struct SceneParts {
    SceneParts(const ExportInput& input, core::WorkerTeam& team)
        : palette(input.scene, input.view, input.palette),
          textures(input.view),
          geometry(input.scene, input.view, palette, team) {}
    Palette palette;
    RasterTextures textures;
    RasterGeometry geometry;
    std::optional<RasterShading> shading;  // when the camera is known
  };
  struct Item {
    const SceneParts& scene;
    const ScenePlacement& placement;
    std::size_t part;
  };

  [[nodiscard]] std::deque<SceneParts>& scenes() { return scenes_; }
  [[nodiscard]] std::size_t partCount() const { return firstParts_.back(); }
  /// Of the parts that a fitted picture shows whole; the parts of backgrounds stand behind them.
  [[nodiscard]] std::size_t framedPartCount() const { return framedPartCount_; }
  [[nodiscard]] Item item(std::size_t index) const {
    // the last copy that begins at or before it
    const auto after = std::upper_bound(firstParts_.begin(), firstParts_.end(), index);
    const auto copy = static_cast<std::size_t>(after - firstParts_.begin()) - 1;
    const ScenePlacement& placement = placements_[copy];
    return {scenes_[placement.scene], placement, index - firstParts_[copy]};
  }

 private:
  std::span<const ScenePlacement> placements_;
  std::deque<SceneParts> scenes_;  // which do not move
  std::size_t framedPartCount_ = 0;
  std::vector<std::size_t> firstParts_;  // number of each copy's first part; behind them their count (copyCount + 1)
};

// calls `visit(part, task)` for all parts, in tasks of consecutive parts
template <typename Visit>
void forParts(core::WorkerTeam& team, std::size_t partCount, std::size_t partsInTask, const Visit& visit) {
  const std::size_t tasks = (partCount + partsInTask - 1) / partsInTask;
  team.forEach(tasks, [&](std::size_t task) {
    for (std::size_t part = task * partsInTask; part < std::min(partCount, (task + 1) * partsInTask); ++part) {
      visit(part, task);
    }
  });
}

// a perspective whose viewer stands inside the scene shows nothing sensible in a fitted picture: draw it in parallel
Projection chosenProjection(const PlacedGeometry& geometry, const files::ViewSettings& view,
                            const PictureOptions& options, core::WorkerTeam& team) {
  Projection projection(view);
  if (projection.isPerspective() && options.framing == PictureFraming::Fitted) {
    std::atomic<bool> isClear{true};
    forParts(team, geometry.framedPartCount(), 4096, [&](std::size_t part, std::size_t) {
      const PlacedGeometry::Item item = geometry.item(part);
      if (isClear && !item.scene.geometry.isVisible(item.part, item.placement, projection)) {
        isClear = false;
      }
    });
    if (!isClear) {
      projection.useParallel();
    }
  }
  return projection;
}

PictureBounds boundsOf(const PlacedGeometry& geometry, const Projection& projection, core::WorkerTeam& team) {
  constexpr std::size_t kParts = 4096;
  std::vector<PictureBounds> bounds((geometry.framedPartCount() + kParts - 1) / kParts);
  forParts(team, geometry.framedPartCount(), kParts, [&](std::size_t part, std::size_t task) {
    const PlacedGeometry::Item item = geometry.item(part);
    if (!projection.isPerspective() || item.scene.geometry.isVisible(item.part, item.placement, projection)) {
      item.scene.geometry.include(item.part, item.placement, projection, bounds[task]);
    }
  });
  PictureBounds all;
  for (const PictureBounds& some : bounds) {
    all.include(some);
  }
  return all;
}

/// Draws all parts into some rows of a picture. Pieces of parts become triangles, which are sorted into tiles, and
/// these are drawn: a round of pieces at a time. While tiles of one round are drawn, the triangles of the next are
/// made.
class PartsDrawing {
 public:
  PartsDrawing(const PlacedGeometry& geometry, const RasterCamera& camera, RasterTarget& target)
      : geometry_(geometry), camera_(camera), target_(target), tileColumns_(target.tileColumns()) {
    for (Round& round : rounds_) {
      round.tiles.resize(static_cast<std::size_t>(tileColumns_) * static_cast<std::size_t>(target.tileRows()));
    }
  }

  void draw(core::WorkerTeam& team, const std::function<void(std::size_t)>& report) {
    for (std::size_t number = 0; number == 0 || rounds_[(number + 1) % 2].taskCount > 0; ++number) {
      Round& next = rounds_[number % 2];
      const Round& ready = rounds_[(number + 1) % 2];
      plan(next);
      // the fullest tiles first, so that no thread comes late to one; the small tasks at the end fill the time
      const std::size_t tileCount = ready.fullTiles.size();
      team.forEach(tileCount + next.taskCount, [&](std::size_t task) {
        if (task < tileCount) {
          drawTile(ready, ready.fullTiles[task]);
        } else {
          makeTriangles(next.made[task - tileCount]);
        }
      });
      next.sortIntoTiles();
      if (number > 0) {
        report(ready.endPart);
      }
    }
  }

 private:
  /// A part of the scene, or one run of a long generalized cylinder.
  struct Piece {
    std::size_t part = 0;
    std::shared_ptr<const SweptCylinder> cylinder;  // null: the whole part
    std::size_t run = 0;
  };
  /// The pieces of one task and its result: triangles, and the tiles in which each of them is seen.
  struct Made {
    std::vector<Piece> pieces;
    std::vector<RasterTriangle> triangles;
    std::vector<std::pair<std::size_t, std::uint32_t>> places;  // tile and number of the triangle
  };
  struct Reference {
    std::uint32_t task = 0;
    std::uint32_t triangle = 0;
  };
  struct Round {
    std::size_t endPart = 0;  // behind the last part of which all pieces are in this round or one before it
    std::size_t taskCount = 0;
    std::vector<Made> made = std::vector<Made>(kRoundTasks);  // the first `taskCount` of them
    std::vector<std::vector<Reference>> tiles;                // the triangles in each, in order
    std::vector<std::size_t> fullTiles;                       // those with triangles

    void clear() {
      taskCount = 0;
      for (const std::size_t tile : fullTiles) {
        tiles[tile].clear();
      }
      fullTiles.clear();
    }

    void sortIntoTiles() {
      for (std::uint32_t task = 0; task < taskCount; ++task) {
        for (const auto& [tile, triangle] : made[task].places) {
          if (tiles[tile].empty()) {
            fullTiles.push_back(tile);
          }
          tiles[tile].push_back({task, triangle});
        }
      }
      std::ranges::sort(fullTiles, std::greater{}, [this](std::size_t tile) { return tiles[tile].size(); });
    }
  };

  // fills a round with the next pieces; tasks with many triangles get few pieces
  void plan(Round& round) {
    round.clear();
    while (round.taskCount < kRoundTasks && (cylinder_ || nextPart_ < geometry_.partCount())) {
      std::vector<Piece>& pieces = round.made[round.taskCount++].pieces;
      pieces.clear();
      std::size_t triangleCount = 0;
      while (pieces.size() < kTaskPieces && triangleCount < kTaskTriangles &&
             (cylinder_ || nextPart_ < geometry_.partCount())) {
        triangleCount += takePiece(pieces);
      }
    }
    round.endPart = nextPart_ - (cylinder_ ? 1 : 0);
  }

  // about how many triangles the next piece has
  std::size_t takePiece(std::vector<Piece>& pieces) {
    if (!cylinder_) {
      const std::size_t part = nextPart_++;
      const PlacedGeometry::Item item = geometry_.item(part);
      const RasterGeometry& parts = item.scene.geometry;
      cylinder_ = parts.longCylinder(item.part);
      nextRun_ = 0;
      if (!cylinder_) {
        pieces.push_back({part, nullptr, 0});
        return parts.triangleCountOf(item.part);
      }
      if (!parts.isVisible(item.part, item.placement, camera_.projection())) {
        cylinder_ = nullptr;
        return 0;
      }
    }
    pieces.push_back({nextPart_ - 1, cylinder_, nextRun_});
    const std::size_t triangleCount = 2 * cylinder_->faceCountOf(cylinder_->runs()[nextRun_]);
    if (++nextRun_ == cylinder_->runs().size()) {
      cylinder_ = nullptr;
    }
    return triangleCount;
  }

  void makeTriangles(Made& made) const {
    auto& [pieces, triangles, places] = made;
    triangles.clear();
    places.clear();
    for (const Piece& piece : pieces) {
      const PlacedGeometry::Item item = geometry_.item(piece.part);
      const RasterGeometry& parts = item.scene.geometry;
      const auto organ = static_cast<std::uint32_t>(piece.part);
      std::size_t kept = triangles.size();
      if (piece.cylinder) {
        parts.appendRun(item.part, *piece.cylinder, piece.cylinder->runs()[piece.run], item.placement, camera_,
                        *item.scene.shading, organ, triangles);
      } else {
        parts.append(item.part, item.placement, camera_, *item.scene.shading, organ, triangles);
      }
      // in the picture of a large plant most triangles are smaller than a sample and meet none
      for (std::size_t i = kept; i < triangles.size(); ++i) {
        const auto [left, right, upper, lower] = target_.tilesOf(triangles[i]);
        for (int row = upper; row <= lower; ++row) {
          for (int column = left; column <= right; ++column) {
            places.emplace_back(static_cast<std::size_t>(row * tileColumns_ + column),
                                static_cast<std::uint32_t>(kept));
          }
        }
        if (left <= right) {
          triangles[kept++] = triangles[i];
        }
      }
      triangles.resize(kept);
    }
  }

  void drawTile(const Round& round, std::size_t tile) {
    const int number = static_cast<int>(tile);
    for (const Reference& reference : round.tiles[tile]) {
      target_.draw(round.made[reference.task].triangles[reference.triangle], number % tileColumns_,
                   number / tileColumns_);
    }
  }

  const PlacedGeometry& geometry_;
  const RasterCamera& camera_;
  RasterTarget& target_;
  const int tileColumns_;
  std::array<Round, 2> rounds_;
  std::size_t nextPart_ = 0;                       // the first that no round has begun with
  std::shared_ptr<const SweptCylinder> cylinder_;  // the part before it, while runs of it are left
  std::size_t nextRun_ = 0;
};

// where the plants stand; only the page of the model shows it: a white or transparent one is for other pages
GroundShade groundOf(const PlacedScenes& placed, const PictureOptions& options) {
  GroundShade ground;
  if (!options.hasGround || options.background != PictureBackground::Model ||
      options.framing != PictureFraming::Fitted || placed.placements.size() > kMostStanding) {
    return ground;
  }
  std::vector<std::vector<GroundContact>> contacts;
  for (const ExportInput& input : placed.scenes) {
    contacts.push_back(groundContactsOf(input.scene));
  }
  for (const ScenePlacement& placement : placed.placements) {
    ground.add(contacts[placement.scene], placement);
  }
  return ground;
}

Colour backgroundOf(const Palette& palette, PictureBackground background) {
  return background == PictureBackground::Model ? palette.background() : Colour{255, 255, 255};
}

}  // namespace

PictureImage renderPicture(const Scene& scene, const files::ViewSettings& view, const PictureOptions& options) {
  const ExportInput input{.scene = scene, .view = view, .palette = options.palette};
  const ScenePlacement here;
  return renderPlaced({{&input, 1}, {&here, 1}}, options);
}

PictureFrame pictureFrame(const PlacedScenes& placed, const PictureOptions& options) {
  core::WorkerTeam team(std::max(1U, options.threads));
  const PlacedGeometry geometry(placed, team);
  const files::ViewSettings& view = placed.scenes[0].view;
  const Projection projection = chosenProjection(geometry, view, options, team);
  PictureBounds bounds = boundsOf(geometry, projection, team);
  groundOf(placed, options).include(projection, bounds);
  return {bounds, Projection(view).isPerspective() && !projection.isPerspective()};
}

PictureImage renderPlaced(const PlacedScenes& placed, const PictureOptions& options, const ExportProgress& progress) {
  ESPALIER_CHECK(options.widthPixels > 0 && options.widthPixels <= kMaximumPicturePixels);
  ESPALIER_CHECK(options.heightPixels > 0 && options.heightPixels <= kMaximumPicturePixels);
  core::WorkerTeam team(std::max(1U, options.threads));
  PlacedGeometry geometry(placed, team);
  const files::ViewSettings& view = placed.scenes[0].view;
  const Colour background = backgroundOf(geometry.scenes()[0].palette, options.background);
  const bool isFramed = options.frame && options.framing == PictureFraming::Fitted;
  Projection projection = isFramed ? Projection(view) : chosenProjection(geometry, view, options, team);
  if (isFramed && options.frame->isParallel) {
    projection.useParallel();
  }
  GroundShade ground = groundOf(placed, options);
  PictureBounds bounds = isFramed ? options.frame->bounds : boundsOf(geometry, projection, team);
  if (!isFramed) {
    ground.include(projection, bounds);
  }
  const RasterCamera camera(projection, view, bounds, options);
  ground.place(camera);
  for (PlacedGeometry::SceneParts& scene : geometry.scenes()) {
    scene.shading.emplace(view, projection, scene.palette, scene.textures, bounds, background);
  }

  PictureImage image{options.widthPixels, options.heightPixels, {}};
  const auto width = static_cast<std::size_t>(image.width);
  image.pixels.resize(width * static_cast<std::size_t>(image.height) * 4);
  // a large picture is made in strips of rows
  const auto rowsAtOnce = static_cast<int>(
      std::clamp<std::size_t>(options.sampleBytes / (width * RasterTarget::kBytesPerPixel), 1, kMaximumPicturePixels));
  for (int first = 0; first < image.height; first += rowsAtOnce) {
    const int rows = std::min(rowsAtOnce, image.height - first);
    RasterTarget target(image.width, first, rows);
    const std::size_t stripCount =
        (static_cast<std::size_t>(image.height + rowsAtOnce) - 1) / static_cast<std::size_t>(rowsAtOnce);
    const std::size_t strip = static_cast<std::size_t>(first / rowsAtOnce);
    PartsDrawing(geometry, camera, target).draw(team, [&](std::size_t done) {
      if (progress) {
        progress(strip * geometry.partCount() + done, stripCount * geometry.partCount());
      }
    });
    team.forEach(static_cast<std::size_t>(rows), [&](std::size_t row) {
      const std::size_t at = (static_cast<std::size_t>(first) + row) * width * 4;
      std::vector<float> shades(ground.empty() ? 0 : width);
      ground.row(first + static_cast<int>(row), shades);
      target.resolve(static_cast<int>(row), background, options.background == PictureBackground::Transparent,
                     std::span(image.pixels).subspan(at, width * 4), shades);
    });
  }
  return image;
}

}  // namespace espalier::turtle
