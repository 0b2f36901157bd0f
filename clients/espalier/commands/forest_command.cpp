#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/forest/layout.h"
#include "clients/espalier/forest/tree_painting.h"
#include "clients/espalier/forest/tree_points.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/output/progress_bar.h"
#include "engine/core/elementary.h"
#include "engine/core/number_text.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kMixDraws = 4;
constexpr std::uint32_t kShowDraws = 5;
constexpr int kPaintedSides = 5;  // of a painted tree's branches in a mesh
// where the viewer stands and where the ground that is drawn begins, in radii of the forest
constexpr core::Vec3 kViewer{0.0, 0.17, 1.3};
constexpr double kNearGround = 1.22;
constexpr double kLeastPart = 0.66;  // of the width of the forest that a picture shows

struct ForestOptions {
  std::vector<std::string> models;  // FILE, FILE:ENTRY or a folder, with =WEIGHT
  std::string from;                 // folder of text files; empty: none
  std::uint64_t number = 0;         // trees; 0: not said
  std::uint64_t distinct = 200;
  std::uint64_t seed = 1;
  Spacing spacing = Spacing::Jittered;
  double distance = 0.0;  // 0: by the trees' width
  std::string trees;      // folder for text files; empty: none
  std::uint64_t turntable = 0;
  std::optional<double> turnDegrees;  // where a branch opens, in place of what a species file says
  bool isPainted = false;
  bool hasGround = true;
  ModelOptions model;  // threads, quiet, limits
  OutputOptions outputs;
};

// a kind of tree and its share of the forest
struct Species {
  std::string model;
  double weight = 1.0;
  std::shared_ptr<const language::Program> program;
  server::FolderSettings folder;
};

/// A grown tree, ready to be placed.
struct GrownTree {
  turtle::Scene scene;
  TreePoints points;
  std::size_t species = 0;
};

class Forest {
 public:
  explicit Forest(ForestOptions& options) : options_(options), colours_(options.seed) {}

  int run() {
    if (const int status = checkPlacedOutputs(options_.outputs); status != kSuccess) {
      return status;
    }
    const bool hasTrees = options_.from.empty() ? growTrees() : readTrees();
    if (!hasTrees || !writeTrees()) {
      return kFailure;
    }
    place();
    return writeAll() ? kSuccess : kFailure;
  }

 private:
  bool readSpecies() {
    if (options_.models.empty()) {
      // the seven species of the report, in equal parts
      const std::string file = server::galleryOfProgram() + "/chapter-forest/species.txt";
      if (std::error_code error; !fs::exists(file, error)) {
        printError("the seven species are in the gallery, and the gallery is missing: give models with --model");
        return false;
      }
      for (int i = 0; i < 7; ++i) {
        options_.models.push_back(file + ":" + std::to_string(i));
      }
      options_.isPainted = true;
    }
    double sum = 0.0;
    for (const std::string& text : options_.models) {
      Species species;
      const std::size_t equals = text.rfind('=');
      species.model = text.substr(0, equals);
      if (equals != std::string::npos) {
        const std::optional<double> weight = core::parseNumber(std::string_view(text).substr(equals + 1));
        if (!weight || !std::isfinite(*weight) || *weight < 0.0) {
          printError("'" + text + "': the share of a species is a number of at least 0, as in MODEL.l=2");
          return false;
        }
        species.weight = *weight;
      }
      sum += species.weight;
      ModelOptions model = options_.model;
      model.model = species.model;
      if (options_.turnDegrees) {
        std::string turn;
        core::appendNumber(turn, *options_.turnDegrees, core::NumberStyle::Shortest);
        model.defines.push_back("GIRO=" + turn);
      }
      server::DiskFileProvider files;
      species.program = loadProgram(model, files, &species.folder);
      if (!species.program) {
        return false;
      }
      species_.push_back(std::move(species));
    }
    if (!(sum > 0.0)) {
      printError("the sum of the shares of the species is zero: give a species a share above 0");
      return false;
    }
    return true;
  }

  // the species of a tree, drawn by the shares
  [[nodiscard]] std::size_t speciesOf(std::size_t tree) const {
    double sum = 0.0;
    for (const Species& species : species_) {
      sum += species.weight;
    }
    double draw =
        sum * core::CounterRandom(options_.seed, 0).uniform(core::DrawDomain::Environment, kMixDraws, tree, 0);
    std::size_t chosen = 0;
    for (std::size_t i = 0; i < species_.size(); ++i) {
      if (species_[i].weight > 0.0) {
        chosen = i;
        if (draw < species_[i].weight) {
          break;
        }
        draw -= species_[i].weight;
      }
    }
    return chosen;
  }

  [[nodiscard]] std::optional<std::string> growOne(std::size_t number, GrownTree& tree) const {
    tree.species = speciesOf(number);
    const Species& species = species_[tree.species];
    ModelOptions model = options_.model;
    model.seed = options_.seed * 1'000'003 + number;
    model.isQuiet = true;
    simulation::SimulationOptions simulationOptions = simulationOptionsFor(model, *species.program);
    simulationOptions.threads = 1;
    simulationOptions.fileWriter = nullptr;
    simulationOptions.messages = {};
    simulation::Simulation simulation(species.program, std::vector<turtle::PlantPlacement>(1), nullptr,
                                      std::move(simulationOptions));
    if (const auto failure = simulation.rewind()) {
      return formatSimulationError(*failure);
    }
    const std::optional<std::uint64_t> last = server::lastStepOf(species.folder, std::nullopt, simulation);
    while (!server::isOver(simulation, last)) {
      if (const auto failure = simulation.step()) {
        return formatSimulationError(*failure);
      }
    }
    auto scene = simulation.scene();
    if (!scene) {
      return formatSimulationError(scene.error());
    }
    tree.scene = std::move(*scene);
    tree.points = treePointsOf(tree.scene);
    if (options_.isPainted) {
      tree.scene = paintTree(tree.points, options_.seed, static_cast<std::uint32_t>(number));
    }
    return std::nullopt;
  }

  bool growTrees() {
    if (!readSpecies()) {
      return false;
    }
    count_ = static_cast<std::size_t>(options_.number == 0 ? 1000 : options_.number);
    trees_.resize(std::min(count_, static_cast<std::size_t>(options_.distinct)));
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::optional<std::string> problem;
    std::size_t done = 0;
    ProgressBar bar(!options_.model.isQuiet);
    const auto work = [&] {
      for (std::size_t i = next++; i < trees_.size(); i = next++) {
        const auto failure = growOne(i, trees_[i]);
        const std::scoped_lock lock(mutex);
        bar.show(++done, trees_.size(), trees_[i].points.points.size() / 2);
        if (failure) {
          problem = problem ? problem : species_[trees_[i].species].model + ": " + *failure;
          next = trees_.size();
        }
      }
    };
    {
      std::vector<std::jthread> helpers;
      for (unsigned i = 1; i < options_.model.threadCount(); ++i) {
        helpers.emplace_back(work);
      }
      work();
    }
    bar.clear();
    if (problem) {
      printError(*problem);
    }
    return !problem;
  }

  bool readTrees() {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(options_.from, error)) {
      if (entry.path().extension() == ".txt") {
        names.push_back(entry.path().string());
      }
    }
    if (error || names.empty()) {
      printError("the folder '" + options_.from + "' holds no trees (*.txt): give the folder that --trees wrote");
      return false;
    }
    std::sort(names.begin(), names.end());
    count_ = static_cast<std::size_t>(options_.number == 0 ? names.size() : options_.number);
    // draw the trees by the seed
    const core::CounterRandom random(options_.seed, 0);
    for (std::size_t i = 0; i < std::min(count_, names.size()); ++i) {
      const double draw = random.uniform(core::DrawDomain::Environment, kShowDraws, i, 0);
      std::swap(names[i], names[i + static_cast<std::size_t>(draw * static_cast<double>(names.size() - i))]);
    }
    names.resize(std::min(count_, names.size()));
    server::DiskFileProvider files;
    for (const std::string& name : names) {
      const std::optional<std::string> text = files.read(name);
      Result<TreePoints> read = text ? readTreePoints(*text) : problem("the file cannot be read");
      if (!read) {
        printError(name + ": " + read.error());
        return false;
      }
      GrownTree tree;
      tree.points = std::move(*read);
      tree.scene = paintTree(tree.points, options_.seed, static_cast<std::uint32_t>(trees_.size()));
      trees_.push_back(std::move(tree));
    }
    options_.isPainted = true;
    return true;
  }

  bool writeTrees() {
    if (options_.trees.empty()) {
      return true;
    }
    std::error_code error;
    fs::create_directories(options_.trees, error);
    for (std::size_t i = 0; i < trees_.size(); ++i) {
      const std::string name = numberedName((fs::path(options_.trees) / "tree.txt").string(), i + 1, 4);
      if (const auto problem = server::writeFileAtomically(name, writeTreePoints(trees_[i].points))) {
        printError(*problem);
        return false;
      }
    }
    if (!options_.model.isQuiet) {
      printNote("wrote " + std::to_string(trees_.size()) + " trees to " + options_.trees);
    }
    return true;
  }

  // computes where the trees stand
  void place() {
    double distance = options_.distance;
    if (distance == 0.0) {
      for (const GrownTree& tree : trees_) {
        distance += std::max(tree.points.radius(), tree.points.height() / 5.0);
      }
      distance *= 0.8 / static_cast<double>(trees_.size());
    }
    const std::vector<TreePlace> places =
        layoutForest(options_.spacing, count_, distance > 0.0 ? distance : 1.0, options_.seed);
    for (std::size_t i = 0; i < places.size(); ++i) {
      placements_.push_back({.scene = static_cast<std::uint32_t>(i % trees_.size()),
                             .position = places[i].position,
                             .turnRadians = places[i].turnRadians,
                             .scale = 0.35 + 0.65 * places[i].size});
      extent_ = std::max(extent_, core::hypot(places[i].position.x, places[i].position.z));
      height_ = std::max(height_, placements_.back().scale * trees_[placements_.back().scene].points.height());
    }
    extent_ = std::max(extent_ + distance, 0.8 * height_);
  }

  // a disc; for pictures the ground up to the horizon
  [[nodiscard]] turtle::Scene groundOf(bool isPicture) const {
    turtle::Polygon ground;
    ground.colour = ForestColours::kGround;
    if (isPicture) {
      // from in front of the viewer's feet
      const double far = 25.0 * extent_;
      const double near = kNearGround * extent_;
      ground.vertices = {{-2.0 * far, 0.0, -far}, {-far, 0.0, near}, {far, 0.0, near}, {2.0 * far, 0.0, -far}};
    } else {
      constexpr int kCorners = 72;
      for (int i = 0; i < kCorners; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kCorners;
        ground.vertices.push_back({extent_ * core::sin(angle), 0.0, extent_ * core::cos(angle)});
      }
    }
    turtle::Scene scene;
    scene.polygons.push_back(std::move(ground));
    return scene;
  }

  // from a little above the crowns
  [[nodiscard]] files::ViewSettings camera() const {
    files::ViewSettings view;
    view.viewReferencePoint = {0.0, 0.3 * height_, 0.0};
    view.viewpoint = view.viewReferencePoint + extent_ * kViewer;
    view.isPerspective = true;
    return view;
  }

  bool writeAll() {
    // the first scene's camera is the picture's
    const files::ViewSettings common = camera();
    std::deque<files::ViewSettings> views;
    std::vector<turtle::ExportInput> inputs;
    for (const GrownTree& tree : trees_) {
      const bool isOwn = !options_.isPainted;
      files::ViewSettings& view = views.emplace_back(isOwn ? species_[tree.species].program->view : common);
      view.viewpoint = common.viewpoint;
      view.viewReferencePoint = common.viewReferencePoint;
      view.isPerspective = common.isPerspective;
      view.box.reset();
      if (!isOwn) {
        view.contourSides = kPaintedSides;
      }
      inputs.push_back({.scene = tree.scene,
                        .view = view,
                        .palette = isOwn ? &species_[tree.species].folder.palette : &colours_.palette()});
    }
    OutputOptions pictures = options_.outputs;
    OutputOptions meshes = options_.outputs;
    const auto isPicture = [&](const std::string& file) { return formatOf(options_.outputs, file)->name == "png"; };
    std::erase_if(pictures.files, [&](const std::string& file) { return !isPicture(file); });
    std::erase_if(meshes.files, isPicture);
    return writeMeshes(meshes, inputs) && (pictures.files.empty() || writePictures(pictures, inputs));
  }

  bool writeMeshes(const OutputOptions& outputs, std::vector<turtle::ExportInput> inputs) const {
    const turtle::Scene ground = groundOf(false);
    addGround(inputs, ground);
    return writePlacedFiles(outputs, inputs, onGround(turned(0.0)), whatIsShown(), options_.model.isQuiet);
  }

  // one picture, or the frames of a turntable, all in one scale
  bool writePictures(OutputOptions outputs, std::vector<turtle::ExportInput> inputs) const {
    const std::uint64_t frames = std::max<std::uint64_t>(1, options_.turntable);
    const auto angleOf = [frames](std::uint64_t frame) {
      return 2.0 * std::numbers::pi * static_cast<double>(frame) / static_cast<double>(frames);
    };
    // the trees fill the picture, the ground extends beyond its edges
    turtle::PictureFrame shown;
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      shown.include(turtle::pictureFrame({inputs, turned(angleOf(frame))}, outputs.picture));
    }
    // as high as the page allows: the forest goes on beyond its sides
    const double aspect = static_cast<double>(outputs.picture.widthPixels) / outputs.picture.heightPixels;
    const double width = shown.bounds.right - shown.bounds.left;
    const double height = shown.bounds.top - shown.bounds.bottom;
    const double cut = 0.5 * (width - std::clamp(aspect * height, kLeastPart * width, width));
    shown.bounds.left += cut;
    shown.bounds.right -= cut;
    outputs.picture.frame = shown;
    const turtle::Scene ground = groundOf(true);
    addGround(inputs, ground);
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      OutputOptions one = outputs;
      for (std::string& file : one.files) {
        file = options_.turntable > 0 ? numberedName(file, frame, 4) : file;
      }
      if (!writePlacedFiles(one, inputs, onGround(turned(angleOf(frame))), whatIsShown(), options_.model.isQuiet)) {
        return false;
      }
    }
    return true;
  }

  // the last of the scenes
  void addGround(std::vector<turtle::ExportInput>& inputs, const turtle::Scene& ground) const {
    inputs.push_back({.scene = ground, .view = inputs[0].view, .palette = &colours_.palette()});
  }

  [[nodiscard]] std::vector<turtle::ScenePlacement> onGround(std::vector<turtle::ScenePlacement> placements) const {
    if (options_.hasGround) {
      placements.insert(placements.begin(), {.scene = static_cast<std::uint32_t>(trees_.size())});
    }
    return placements;
  }

  [[nodiscard]] std::string whatIsShown() const {
    return std::to_string(count_) + " trees, " + std::to_string(std::min(trees_.size(), count_)) + " of them distinct";
  }

  // the whole forest turned about the y axis, far ones first
  [[nodiscard]] std::vector<turtle::ScenePlacement> turned(double angle) const {
    std::vector<turtle::ScenePlacement> placements = placements_;
    const double c = core::cos(angle);
    const double s = core::sin(angle);
    for (turtle::ScenePlacement& placement : placements) {
      const core::Vec3 p = placement.position;
      placement.position = {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
      placement.turnRadians += angle;
    }
    std::stable_sort(
        placements.begin(), placements.end(),
        [](const turtle::ScenePlacement& a, const turtle::ScenePlacement& b) { return a.position.z < b.position.z; });
    return placements;
  }

  ForestOptions& options_;
  ForestColours colours_;
  std::vector<Species> species_;
  std::vector<GrownTree> trees_;
  std::size_t count_ = 0;
  std::vector<turtle::ScenePlacement> placements_;
  double extent_ = 0.0;  // radius of the ground
  double height_ = 0.0;  // of the highest tree
};

}  // namespace

void addForest(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("forest", "Grow many trees of several species and write them as one scene");
  command->footer(
      "Without --model the forest has the seven species of Rodrigues, Coelho & Alencar (2018), drawn with\n"
      "leaves and flowers. The command grows one tree for each of --distinct seeds, and places copies of them up to "
      "--number.\n"
      "A text file of a tree (--trees, --from) has one point per line: x y z, number of lines on the longest path to "
      "a\n"
      "leaf, number of branches on the path from the root. Two successive points are the ends of a line.\n"
      "Examples:\n"
      "  espalier forest --number 1000 --seed 7 -o forest.png -o forest.glb\n"
      "  espalier forest --model pine.l=3 --model birch.l --spacing competition -o stand.glb\n"
      "  espalier forest --number 1000 --flat -o flat.png\n"
      "  espalier forest --number 1000 --trees trees -o all.png\n"
      "  espalier forest --from trees --show 100 --seed 2 --turntable 36 -o turn.png");
  auto options = std::make_shared<ForestOptions>();
  CLI::Option* models =
      command->add_option("--model", options->models, "A model and its share of the trees (1). May be repeated")
          ->type_name("MODEL[=SHARE]")
          ->allow_extra_args(false);
  command
      ->add_option("--from", options->from, "Read the trees from the text files of a folder, instead of growing them")
      ->type_name("FOLDER")
      ->excludes(models);
  addWholeNumber(*command, "--number,--show", "Number of trees (1000; with --from all)", 1, 1'000'000,
                 [options](std::uint64_t count) { options->number = count; });
  addWholeNumber(*command, "--distinct", "Number of different trees, each from its own seed (200)", 1, 1'000'000,
                 [options](std::uint64_t count) { options->distinct = count; });
  addWholeNumber(*command, "--seed", "Seed of the random numbers (1)", 0, 1'000'000'000'000,
                 [options](std::uint64_t seed) { options->seed = seed; });
  const std::map<std::string, Spacing> spacings{{"jittered", Spacing::Jittered},
                                                {"grid", Spacing::Grid},
                                                {"poisson", Spacing::Poisson},
                                                {"competition", Spacing::Competition}};
  command
      ->add_option("--spacing", options->spacing,
                   "jittered (near the points of a grid), grid (on the points), poisson (no two trees nearer than the\n"
                   "distance) or competition (seedlings grow and shade each other; the survivors are the forest)")
      ->transform(CLI::CheckedTransformer(spacings))
      ->option_text("jittered|grid|poisson|competition");
  addPositiveNumber(*command, "--distance", "Distance between trees (default: by their mean crown)",
                    "a distance in the models' unit", [options](double distance) { options->distance = distance; });
  command->add_option("--trees", options->trees, "Also write every different tree as text into this folder")
      ->type_name("FOLDER");
  addWholeNumber(*command, "--turntable", "Write N PNG frames of one turn of the forest", 2, 100'000,
                 [options](std::uint64_t count) { options->turntable = count; });
  command
      ->add_option_function<double>(
          "--turn", [options](const double& degrees) { options->turnDegrees = degrees; },
          "For species files: turn of a branch about its own axis, in degrees (default: as in the file, 30)")
      ->check(numberFrom(-360.0, 360.0));
  command->add_flag_callback(
      "--flat", [options] { options->turnDegrees = 0.0; }, "Flat trees: the same as --turn 0");
  command->add_flag("--painted", options->isPainted,
                    "Draw the trees of --model with the thickness, leaves and flowers of the report");
  command->add_flag_callback(
      "--no-ground", [options] { options->hasGround = false; }, "Do not draw the ground");
  command
      ->add_option("--threads", options->model.threads,
                   "Threads for growing trees; 0: as many as the process may use processors")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--quiet", options->model.isQuiet, "Print only errors");
  addOutputOptions(*command, options->outputs, false, true);
  command->callback([options, &status] {
    if (options->outputs.files.empty() && options->trees.empty()) {
      throw CLI::RequiredError("-o FILE or --trees FOLDER");
    }
    options->outputs.picture.threads = options->model.threadCount();
    status = Forest(*options).run();
  });
}

}  // namespace espalier::command
