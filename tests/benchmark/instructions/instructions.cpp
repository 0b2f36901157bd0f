// Fixed work for counting instructions: check_instructions.py runs this program under callgrind, which collects only
// inside the function `measured` and writes one file after each call of it. The names of the workloads go to standard
// output in the same order, after that of the compiler.

#include <cstdio>
#include <exception>
#include <utility>

#include "tests/benchmark/workload.h"

namespace espalier::benchmarking {

enum class Measured { Derivation, Answer, Scene };

namespace {

struct FixedWork {
  Measured measured;
  Workload workload;
};

// together a few seconds under callgrind: each about 5 to 50 million instructions
const FixedWork kWork[] = {
    {Measured::Derivation, {"d0l", "7", ""}},
    {Measured::Derivation, {"parametric", "12", ""}},
    {Measured::Derivation, {"signal-up", "10", ""}},
    {Measured::Derivation, {"diffusion", "10", ""}},
    {Measured::Derivation, {"signal-down", "10", ""}},
    {Measured::Derivation, {"stochastic", "8", ""}},
    {Measured::Derivation, {"steady", "100", "7"}},
    {Measured::Derivation, {"steady", "16", "12"}},
    {Measured::Derivation, {"productions", "18", "11"}},
    {Measured::Derivation, {"parameters", "18", "10"}},
    {Measured::Derivation, {"nesting", "200", ""}},
    {Measured::Derivation, {"fan", "12", "8"}},
    {Measured::Derivation, {"ignored-rows", "14", "9"}},
    {Measured::Derivation, {"wide-contexts", "18", "11"}},
    {Measured::Derivation, {"stochastic-contexts", "18", "9"}},
    {Measured::Derivation, {"decomposition", "14", "9"}},
    {Measured::Derivation, {"dense-cheap", "60", "10"}},
    {Measured::Derivation, {"rare-general", "20", "4"}},
    {Measured::Derivation, {"draws", "16", "8"}},
    {Measured::Derivation, {"pairs", "20", "8"}},
    {Measured::Derivation, {"blocks", "14", ""}},
    {Measured::Derivation, {"accounts", "40", "9"}},
    {Measured::Derivation, {"globals", "14", "10"}},
    {Measured::Derivation, {"neighbours", "10", "7"}},
    {Measured::Derivation, {"candidates", "20", "9"}},
    {Measured::Derivation, {"cuts", "14", "8"}},
    {Measured::Derivation, {"arrays", "20", "9"}},
    {Measured::Derivation, {"assigned", "20", "9"}},
    {Measured::Derivation, {"counters", "20", "9"}},
    {Measured::Derivation, {"functions", "20", "9"}},
    {Measured::Derivation, {"answers", "20", "9"}},
    {Measured::Answer, {"open", "16", "12"}},
    {Measured::Scene, {"d0l", "6", ""}},
    {Measured::Scene, {"parametric", "11", ""}},
    {Measured::Scene, {"homomorphism", "11", "10"}},
};

}  // namespace

// never inlined: callgrind finds it by its name
void measured(simulation::Simulation& simulation, Measured what);

[[gnu::noinline]] void measured(simulation::Simulation& simulation, Measured what) {
  switch (what) {
    case Measured::Derivation:
      while (!simulation.isFinished()) {
        require(simulation.step());
      }
      return;
    case Measured::Answer:
      require(simulation.answer());
      return;
    case Measured::Scene: {
      const auto scene = simulation.scene();
      if (!scene) {
        require(scene.error());
      }
      return;
    }
  }
}

namespace {

const char* nameOf(Measured what) {
  return what == Measured::Derivation ? "derive" : what == Measured::Answer ? "answer" : "scene";
}

void run(const FixedWork& work) {
  auto environment = work.measured == Measured::Answer ? makeProcess("height", "") : nullptr;
  simulation::Simulation simulation(compileWorkload(work.workload), {turtle::PlantPlacement{}}, std::move(environment),
                                    {});
  require(simulation.rewind());
  while (work.measured != Measured::Derivation && !simulation.isFinished()) {
    require(simulation.step());
  }
  std::printf("%s/%s\n", nameOf(work.measured), work.workload.name().c_str());
  measured(simulation, work.measured);
}

}  // namespace
}  // namespace espalier::benchmarking

int main() {
  using namespace espalier::benchmarking;
  // counts of one compiler say nothing about another
#if defined(__clang__)
  std::printf("clang %d\n", __clang_major__);
#else
  std::printf("g++ %d\n", __GNUC__);
#endif
  try {
    for (const FixedWork& work : kWork) {
      run(work);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
