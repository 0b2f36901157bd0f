#include "clients/espalier/rendering/render.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <vector>

#include "clients/espalier/rendering/path_tracer.h"
#include "clients/espalier/rendering/render_light.h"
#include "clients/espalier/rendering/render_scene.h"
#include "engine/core/elementary.h"
#include "engine/core/worker_team.h"
#include "engine/turtle/export/ground_contact.h"
#include "engine/turtle/export/mesh/mesh_material.h"
#include "engine/turtle/export/palette.h"
#include "engine/turtle/export/picture/projection.h"
#include "engine/turtle/export/picture/raster_camera.h"
#include "engine/turtle/turtle_motion.h"

namespace espalier::command {

using core::Vec3;
using turtle::PictureBackground;

namespace {

constexpr int kTile = 16;   // pixels
constexpr int kRound = 16;  // samples of a pixel before the noise is looked at
constexpr int kLeastRounds = 2;
constexpr double kLeastHeight = 8.0;  // degrees of the viewer above a ground
constexpr double kShoulder = 0.72;    // brightness from which light is pressed together below white
constexpr Vec3 kUp{0.0, 1.0, 0.0};

double radians(double degrees) {
  return degrees * std::numbers::pi / 180.0;
}

// light as a component of a colour, 0 to 1; white light stays below white until it is very strong
double shown(double light) {
  const double room = 1.0 - kShoulder;
  return light <= kShoulder ? light : kShoulder + room * (1.0 - core::exp(-(light - kShoulder) / room));
}

std::uint8_t encoded(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double value = c <= 0.0031308 ? 12.92 * c : 1.055 * core::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(255.0 * value + 0.5);
}

// the sun stands still beside the viewer, so that a turning plant is lit alike from all sides
Vec3 sunOf(const turtle::Projection& projection, const RenderOptions& render) {
  Vec3 toward = projection.towardViewer();
  toward.y = 0.0;
  toward = core::length(toward) > 1e-6 ? core::normalised(toward) : Vec3{0.0, 0.0, 1.0};
  const Vec3 right = core::cross(kUp, toward);
  const double azimuth = radians(render.sunAzimuth);
  const double height = radians(render.sunElevation);
  return core::cos(height) * (core::cos(azimuth) * toward + core::sin(azimuth) * right) + core::sin(height) * kUp;
}

bool standsOnGround(const turtle::PlacedScenes& placed, const turtle::PictureOptions& options) {
  return options.hasGround && std::ranges::any_of(placed.placements, [&](const turtle::ScenePlacement& placement) {
           return !turtle::groundContactsOf(placed.scenes[placement.scene].scene).empty();
         });
}

/// The samples of a pixel so far.
struct Pixel {
  Light light{};       // sum over samples that met a plant
  double shade = 0.0;  // sum over the others
  double sum = 0.0;    // of brightness
  double squares = 0.0;
  int plants = 0;
};

/// One picture in the making.
class Rendering {
 public:
  Rendering(const PathTracer& tracer, const turtle::RasterCamera& camera, double firstDepth,
            const turtle::PictureOptions& options, const RenderOptions& render, const turtle::Colour& page)
      : tracer_(tracer), camera_(camera), firstDepth_(firstDepth), options_(options), render_(render) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::array<unsigned char, 3> parts{page.red, page.green, page.blue};
      pageLight_[k] = turtle::linearComponent(parts[k] / 255.0);
    }
  }

  void drawTile(int left, int upper, turtle::PictureImage& image) const {
    const int width = std::min(kTile, image.width - left);
    const int height = std::min(kTile, image.height - upper);
    std::vector<Pixel> pixels(static_cast<std::size_t>(width * height));
    int samples = 0;
    while (samples < render_.samples && (samples < kLeastRounds * kRound || noiseOf(pixels, samples) > render_.noise)) {
      const int more = std::min(kRound, render_.samples - samples);
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          for (int sample = samples; sample < samples + more; ++sample) {
            take(left + x, upper + y, sample, image.width, pixels[static_cast<std::size_t>(y * width + x)]);
          }
        }
      }
      samples += more;
    }
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::size_t at = (static_cast<std::size_t>(upper + y) * static_cast<std::size_t>(image.width) +
                                static_cast<std::size_t>(left + x)) *
                               4;
        develop(pixels[static_cast<std::size_t>(y * width + x)], samples, &image.pixels[at]);
      }
    }
  }

 private:
  void take(int x, int y, int sample, int width, Pixel& pixel) const {
    SampleNumbers numbers(
        static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(width) + static_cast<std::uint64_t>(x),
        static_cast<std::uint32_t>(sample));
    const double pageX = x + numbers.next();
    const double pageY = y + numbers.next();
    Vec3 origin;
    Vec3 direction = -camera_.projection().towardViewer();
    if (camera_.projection().isPerspective()) {
      origin = camera_.fromPage(pageX, pageY, 0.0);
      direction = core::normalised(camera_.fromPage(pageX, pageY, camera_.projection().distance()) - origin);
    } else {
      origin = camera_.fromPage(pageX, pageY, firstDepth_);
    }
    const Seen seen = tracer_.look(origin, direction, numbers);
    double bright = 0.0;
    if (seen.isPlant) {
      ++pixel.plants;
      for (std::size_t k = 0; k < 3; ++k) {
        pixel.light[k] += seen.light[k];
      }
      bright = 0.2126 * seen.light[0] + 0.7152 * seen.light[1] + 0.0722 * seen.light[2];
    } else {
      pixel.shade += seen.shade;
      bright = seen.shade * (0.2126 * pageLight_[0] + 0.7152 * pageLight_[1] + 0.0722 * pageLight_[2]);
    }
    pixel.sum += bright;
    pixel.squares += bright * bright;
  }

  // standard error of the brightness as it is shown, over the pixels
  static double noiseOf(const std::vector<Pixel>& pixels, int samples) {
    double sum = 0.0;
    for (const Pixel& pixel : pixels) {
      const double mean = pixel.sum / samples;
      const double variance = std::max(0.0, pixel.squares / samples - mean * mean) / samples;
      // the slope of the square root, which is near to how colours are encoded
      sum += variance / (4.0 * (mean + 0.02));
    }
    return std::sqrt(sum / static_cast<double>(pixels.size()));
  }

  void develop(const Pixel& pixel, int samples, std::uint8_t* to) const {
    const double plant = static_cast<double>(pixel.plants) / samples;
    const int others = samples - pixel.plants;
    const double shade = others > 0 ? std::min(1.0, pixel.shade / others) : 1.0;
    const bool isTransparent = options_.background == PictureBackground::Transparent;
    // a transparent page keeps the shadow as black of that opacity
    const double opacity = isTransparent ? plant + (1.0 - plant) * (1.0 - shade) : 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double own = pixel.plants > 0 ? plant * shown(pixel.light[k] / pixel.plants) : 0.0;
      const double page = isTransparent ? 0.0 : (1.0 - plant) * shade * pageLight_[k];
      to[k] = encoded(opacity > 0.0 ? (own + page) / opacity : 0.0);
    }
    to[3] = static_cast<std::uint8_t>(255.0 * opacity + 0.5);
  }

  const PathTracer& tracer_;
  const turtle::RasterCamera& camera_;
  double firstDepth_;  // of a parallel view: where its rays start
  const turtle::PictureOptions& options_;
  const RenderOptions& render_;
  Light pageLight_{};
};

}  // namespace

files::ViewSettings viewToRender(const files::ViewSettings& view, const RenderOptions& render) {
  Vec3 back = view.viewpoint - view.viewReferencePoint;
  if (core::length(back) == 0.0) {
    back = {0.0, 0.0, 1.0};
  }
  const double distance = core::length(back);
  const double height = core::asin(std::clamp(back.y / distance, -1.0, 1.0)) * 180.0 / std::numbers::pi;
  const double shown = std::clamp(render.height.value_or(std::max(height, kLeastHeight)), -89.9, 89.9);
  files::ViewSettings moved = view;
  if (shown != height || render.turn != 0.0) {
    const double azimuth = core::atan2(back.x, back.z) + radians(render.turn);
    const double level = distance * core::cos(radians(shown));
    moved.viewpoint = moved.viewReferencePoint + Vec3{level * core::sin(azimuth), distance * core::sin(radians(shown)),
                                                      level * core::cos(azimuth)};
  }
  return moved;
}

std::optional<std::string> renderInDaylight(const turtle::PlacedScenes& placed, const turtle::PictureOptions& options,
                                            const RenderOptions& render, turtle::PictureImage& image,
                                            const turtle::ExportProgress& progress) {
  const bool hasGround = standsOnGround(placed, options);
  const turtle::ExportInput& first = placed.scenes[0];
  const bool isFramed = options.frame && options.framing == turtle::PictureFraming::Fitted;
  const turtle::PictureFrame frame = isFramed ? *options.frame : turtle::pictureFrame(placed, options);
  turtle::Projection projection(first.view);
  if (frame.isParallel) {
    projection.useParallel();
  }
  const turtle::RasterCamera camera(projection, first.view, frame.bounds, options);

  const RenderScene scene(placed);
  if (scene.problem()) {
    return scene.problem();
  }
  const Daylight above(sunOf(projection, render));
  const PathTracer tracer(scene, above, hasGround ? std::optional(scene.lowest()) : std::nullopt);
  const turtle::Palette palette(first.scene, first.view, first.palette);
  const turtle::Colour page =
      options.background == PictureBackground::Model ? palette.background() : turtle::Colour{255, 255, 255};
  const double extent = std::max({frame.bounds.right - frame.bounds.left, frame.bounds.top - frame.bounds.bottom,
                                  frame.bounds.farthest - frame.bounds.nearest, 0.0});
  const Rendering rendering(tracer, camera, frame.bounds.nearest - 2.0 * extent, options, render, page);

  image = {options.widthPixels, options.heightPixels, {}};
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4);
  const int columns = (image.width + kTile - 1) / kTile;
  const auto tiles = static_cast<std::size_t>(columns * ((image.height + kTile - 1) / kTile));
  core::WorkerTeam team(std::max(1U, options.threads));
  std::mutex mutex;
  std::uint64_t done = 0;
  team.forEach(tiles, [&](std::size_t tile) {
    const int index = static_cast<int>(tile);
    rendering.drawTile(index % columns * kTile, index / columns * kTile, image);
    if (progress) {
      const std::lock_guard lock(mutex);
      progress(++done, tiles);
    }
  });
  return std::nullopt;
}

}  // namespace espalier::command
