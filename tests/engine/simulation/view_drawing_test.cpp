#include "engine/simulation/view_drawing.h"

#include <bit>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <random>
#include <thread>

#include "engine/simulation/snapshot_editing.h"
#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::view_drawing_test {
namespace {

using Records = std::vector<turtle::TurtleRecord>;

/// Several tips that grow by chance, answers that change some modules, and a trunk that stays.
std::string model(std::mt19937& dice) {
  std::string trunk;
  for (std::size_t i = dice() % 400; i > 0; --i) {
    trunk += i % 3 == 0 ? "F(1)" : "+(7)";
  }
  const bool hasBlock = dice() % 3 == 0;
  return "Lsystem: 1\nderivation length: 1000\nseed: " + std::to_string(1 + dice() % 1000) + "\nAxiom: " + trunk +
         "A(0)" + trunk + "[+(20)A(1)?E(0)]" + trunk + "?P(0,0,0)B(0)\n" + "A(x) : ran(1) < 0.4 --> A(x)\n" +
         (hasBlock ? "A(x) : x >= 0 {n = x + 1;} --> F(1)[-(30)A(n)]F(2)\n" : "A(x) --> F(1)[-(30)A(x+1)]F(2)A(x)\n") +
         "B(x) : x > 6 --> *\nB(x) --> [&(10)F(x)?E(x)]B(x+1)\n?E(x) : ran(1) < 0.05 --> ?E(x+1)\nendlsystem\n";
}

Records recordsOf(const Simulation& simulation) {
  return simulation.turtleRecords().value();
}

bool haveSameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool areSame(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), haveSameBits);
}

bool areSame(const Records& a, const Records& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.plant == y.plant && x.module == y.module && x.symbol == y.symbol && x.parent == y.parent &&
           x.colour == y.colour && x.branchOrder == y.branchOrder && haveSameBits(x.position.x, y.position.x) &&
           haveSameBits(x.position.y, y.position.y) && haveSameBits(x.position.z, y.position.z) &&
           haveSameBits(x.frame.heading.x, y.frame.heading.x) && haveSameBits(x.width, y.width) &&
           x.parameters == y.parameters;
  });
}

Records recordsOf(const turtle::RecordChain& chain, std::size_t plants) {
  Records records;
  for (std::size_t plant = 0; plant < plants; ++plant) {
    for (const auto& place : chain.places(chain.firstLink[plant], chain.firstLink[plant + 1])) {
      for (turtle::TurtleRecord record : place.stretch->records) {
        record.module += place.firstModule;
        record.parent = chain.recordOf(place, record.parent);
        records.push_back(record);
      }
    }
  }
  return records;
}

/// Something that can happen to a simulation between two views.
class Hand {
 public:
  explicit Hand(unsigned seed) : dice_(seed) {}

  std::size_t draw(std::size_t bound) { return static_cast<std::size_t>(dice_()) % bound; }
  void touch(TestRun& run) {
    Simulation& simulation = run.simulation;
    switch (draw(12)) {
      case 0:
        edit(simulation);
        break;
      case 1:
        saved_ = snapshotOf(simulation);
        break;
      case 2:
        if (!saved_.empty()) {
          expectSuccess(simulation.restore(saved_));
        }
        break;
      case 3:
        // the environment fails, and the answers that the turtle gave itself are taken back
        run.log->nextError = turtle::EnvironmentError{"away", true};
        static_cast<void>(simulation.step());
        run.log->nextError = std::nullopt;
        break;
      case 4:
        expectSuccess(simulation.answer());
        break;
      case 5:
        if (draw(8) == 0) {
          expectSuccess(simulation.rewind());
        }
        break;
      default:
        expectSuccess(simulation.step());
    }
  }

 private:
  void edit(Simulation& simulation) {
    const std::uint32_t plant = static_cast<std::uint32_t>(draw(simulation.plantCount()));
    StringEdit edit{.plant = plant, .module = draw(simulation.string(plant).size() + 1), .modules = {{"F", {0.5}}}};
    edit.kind = draw(2) == 0 ? StringEdit::Kind::Insert : StringEdit::Kind::Prune;
    // some are refused: brackets, a step half-way
    const EditedSnapshot edited = editString(snapshotOf(simulation), edit);
    if (edited) {
      expectSuccess(simulation.restore(*edited));
    }
  }

  std::mt19937 dice_;
  std::string saved_;
};

/// That the modules which `changes` keeps are equal; how many they are.
std::size_t expectKept(const language::Program& program, const derivation::StepChanges& changes,
                       const derivation::ModuleString& older, const derivation::ModuleString& newer) {
  const auto offsets = [&program](const derivation::ModuleString& string) {
    std::vector<std::size_t> result{0};
    for (const core::ModuleTypeId type : string.types()) {
      result.push_back(result.back() + program.arity[type]);
    }
    return result;
  };
  const auto from = offsets(older);
  const auto to = offsets(newer);
  std::size_t count = 0;
  std::uint64_t fromEnd = 0;
  std::uint64_t toEnd = 0;
  for (const derivation::KeptModules& run : changes.kept()) {
    EXPECT_TRUE(run.from >= fromEnd && run.to >= toEnd);
    fromEnd = run.from + run.modules;
    toEnd = run.to + run.modules;
    if (fromEnd > older.size() || toEnd > newer.size()) {
      ADD_FAILURE() << "a run reaches beyond the string";
      return 0;
    }
    EXPECT_TRUE(std::equal(older.types().begin() + static_cast<std::ptrdiff_t>(run.from),
                           older.types().begin() + static_cast<std::ptrdiff_t>(fromEnd),
                           newer.types().begin() + static_cast<std::ptrdiff_t>(run.to)));
    const auto values = older.parameters().subspan(from[run.from], from[fromEnd] - from[run.from]);
    const auto same = newer.parameters().subspan(to[run.to], to[toEnd] - to[run.to]);
    EXPECT_TRUE(std::equal(values.begin(), values.end(), same.begin(), same.end(), haveSameBits));
    count += run.modules;
  }
  return count;
}

TEST(ViewDrawing, ChangesBetweenViewsAreRightWhateverHappened) {
  std::mt19937 dice(5);
  std::size_t kept = 0;
  for (unsigned round = 0; round < 40; ++round) {
    const std::string text = model(dice);
    TestRun run(compileText(text), 2);
    Simulation& simulation = run.simulation;
    expectSuccess(simulation.rewind());
    simulation.followChanges(true);
    Hand hand(round);
    ViewDrawing drawing;
    std::shared_ptr<const PlantsView> base;
    for (int i = 0; i < 25 && simulation.statistics().modules < 6'000; ++i) {
      const auto view = simulation.takeView();
      if (base != nullptr && view->base != 0) {
        ASSERT_EQ(view->base, base->number);
        for (std::size_t plant = 0; plant < 2; ++plant) {
          kept += expectKept(view->program(plant), view->changes[plant], base->plants[plant].string,
                             view->plants[plant].string);
        }
      }
      // the records that were taken over equal those that are made anew
      drawing.show(view);
      const auto chain = drawing.recordChain().value();
      ASSERT_NE(chain, nullptr);
      ASSERT_TRUE(areSame(recordsOf(*chain, 2), recordsOf(simulation)));
      ASSERT_FALSE(testing::Test::HasFailure()) << "round " << round << ", view " << i << " of\n" << text;
      base = view;
      for (std::size_t count = hand.draw(5); count > 0; --count) {
        hand.touch(run);
      }
    }
  }
  EXPECT_GT(kept, 400'000U);
}

TEST(ViewDrawing, RecordsBehindATurtleThatChangedInPlaceAreNew) {
  // the turtle stays where it is for longer than a stretch of records, and only then shows what it was given
  std::string tail;
  for (int i = 0; i < 300; ++i) {
    tail += i < 150 ? "F(0)" : "F+";
  }
  for (const std::string setter : {"@A(x)", "!(x)", ";(x)", ",(x)", "+(x)", "&(x)", "@X&(x)@X"}) {
    SCOPED_TRACE(setter);
    const std::size_t value = setter.find("(x)");
    const std::string module = setter.substr(value - 1, 1);
    TestRun run(compileText("Lsystem: 1\nderivation length: 9\nAxiom: " + setter.substr(0, value) + "(2)" +
                            setter.substr(value + 3) + tail + "@X" + tail + "\n" + module + "(x) : x > 1 --> " +
                            module + "(x+1)\nendlsystem\n"));
    Simulation& simulation = run.simulation;
    expectSuccess(simulation.rewind());
    simulation.followChanges(true);
    ViewDrawing drawing;
    for (int step = 0; step < 3; ++step) {
      drawing.show(simulation.takeView());
      const auto chain = drawing.recordChain().value();
      ASSERT_TRUE(areSame(recordsOf(*chain, 1), recordsOf(simulation)));
      expectSuccess(simulation.step());
    }
  }
}

TEST(ViewDrawing, AViewStaysAsItIsAndCopiesNoString) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 9\nAxiom: A?E(1)?P(0,0,0)\nA --> F(1)A\nendlsystem\n"));
  Simulation& simulation = run.simulation;
  expectSuccess(simulation.rewind());
  const auto view = simulation.takeView();
  EXPECT_EQ(view->plants[0].string.parameters().data(), simulation.string().parameters().data());
  EXPECT_EQ(view->plants[0].string.types().data(), simulation.string().types().data());
  ViewDrawing drawing;
  drawing.show(view);
  const std::string text = drawing.stringText(0);
  run.log->answer = 7.0;
  expectSuccess(simulation.answer());
  EXPECT_NE(simulation.stringText(), text);
  expectSuccess(simulation.step());
  expectSuccess(simulation.step());
  EXPECT_EQ(drawing.stringText(0), text);
  EXPECT_EQ(view->completedSteps, 0U);
  EXPECT_EQ(drawing.turtleRecords().value().size(), 2U);
  // drawing a view writes nothing into it, and a step that nobody looks at copies nothing
  expectSuccess(simulation.rewind());
  drawing.close();
  const double* const before = simulation.string().parameters().data();
  expectSuccess(simulation.answer());
  EXPECT_EQ(simulation.string().parameters().data(), before);
}

TEST(ViewDrawing, AnswersFromBeforeTheFirstViewCanBeTakenBack) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 9\nAxiom: F(1)?P(0,0,0)X\nX --> X(exp(1000))\nendlsystem\n"),
              1, {}, false);
  Simulation& simulation = run.simulation;
  expectSuccess(simulation.rewind());
  expectSuccess(simulation.answer());
  simulation.followChanges(true);
  const auto view = simulation.takeView();
  EXPECT_TRUE(simulation.step().has_value());
  const auto next = simulation.takeView();
  EXPECT_FALSE(areSame(view->plants[0].string.parameters(), next->plants[0].string.parameters()));
  EXPECT_EQ(next->base, 0U);
}

TEST(ViewDrawing, SaysWhatASimulationSays) {
  TestRun run(compileText(kAskingModel), 2);
  Simulation& simulation = run.simulation;
  expectSuccess(simulation.rewind());
  ViewDrawing drawing;
  for (int step = 0; step < 6; ++step) {
    drawing.show(simulation.takeView());
    EXPECT_EQ(drawing.stringText(1), simulation.stringText(1));
    EXPECT_EQ(drawing.symbolNames(), simulation.symbolNames());
    EXPECT_TRUE(areSame(drawing.turtleRecords().value(), recordsOf(simulation)));
    EXPECT_EQ(drawing.scene().value().segments.size(), simulation.scene().value().segments.size());
    // a homomorphism with a block can be drawn, and its records cannot be shared
    EXPECT_EQ(drawing.recordChain().value(), nullptr);
    expectSuccess(simulation.step());
  }
  const std::string large = "F(1" + std::string(308, '0') + ")";
  TestRun failing(compileText("Lsystem: 1\nAxiom: " + large + large + "\nA --> A\nendlsystem\n"));
  expectSuccess(failing.simulation.rewind());
  drawing.show(failing.simulation.takeView());
  EXPECT_EQ(drawing.turtleRecords().error().message, failing.simulation.turtleRecords().error().message);
}

TEST(ViewDrawing, ReadersHoldOldViewsWhileTheSimulationGoesOn) {
  // a view and the records that it must have
  struct Shown {
    std::shared_ptr<const PlantsView> view;
    Records records;
  };
  std::mutex mutex;
  std::condition_variable ready;
  std::deque<Shown> waiting;
  bool isOver = false;
  std::size_t drawn = 0;
  const auto read = [&] {
    ViewDrawing drawing;
    std::deque<Shown> held;
    while (true) {
      {
        std::unique_lock lock(mutex);
        ready.wait(lock, [&] { return isOver || !waiting.empty(); });
        if (waiting.empty()) {
          return;
        }
        held.push_back(std::move(waiting.front()));
        waiting.pop_front();
        ++drawn;
      }
      // the newest and the oldest that this reader holds
      for (const Shown* shown : {&held.back(), &held.front()}) {
        drawing.show(shown->view);
        EXPECT_TRUE(areSame(drawing.turtleRecords().value(), shown->records));
      }
      drawing.close();
      if (held.size() > 3) {
        held.pop_front();
      }
    }
  };
  std::mt19937 dice(9);
  TestRun run(compileText(model(dice)), 2);
  Simulation& simulation = run.simulation;
  expectSuccess(simulation.rewind());
  simulation.followChanges(true);
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back(read);
  }
  Hand hand(9);
  for (int i = 0; i < 200; ++i) {
    const auto view = simulation.takeView();
    Records records = recordsOf(simulation);
    {
      const std::lock_guard lock(mutex);
      // the same view for both
      waiting.push_back({view, records});
      waiting.push_back({view, std::move(records)});
    }
    ready.notify_all();
    hand.touch(run);
    if (simulation.statistics().modules > 6'000) {
      expectSuccess(simulation.rewind());
    }
    if (i % 20 == 0) {
      // a fork goes its own way
      TestRun fork(simulation.programs().front(), 2);
      expectSuccess(fork.simulation.restore(snapshotOf(simulation)));
      expectSuccess(fork.simulation.step());
    }
  }
  {
    const std::lock_guard lock(mutex);
    isOver = true;
  }
  ready.notify_all();
  for (std::thread& reader : readers) {
    reader.join();
  }
  EXPECT_EQ(drawn, 400U);
}

}  // namespace
}  // namespace espalier::simulation::view_drawing_test
