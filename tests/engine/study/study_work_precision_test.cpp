#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/base/number_text.h"
#include "engine/study/chart_study.h"
#include "engine/study/work_precision.h"
#include "integrators/catalogue.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::study_work_precision_test {
namespace {

using Outcome = StudyRun::Outcome;
using Setting = StudyMethod::Setting;

StudyScene pendulum() {
  return {
      .name = "pendulum", .duration = 1, .characteristic_length = 0.5, .draw = [](SystemGraph& graph) {
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        auto& rod =
            graph.add<RigidBody>("rod", {.mass = 1, .inertia = {1e-3, 1.0 / 12, 1.0 / 12}, .position = {0.5, 0, 0}});
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.5, 0, 0}, along_y)});
        return std::vector<Sensor>{position(rod.marker({0.5, 0, 0}), "tip"), total_energy("energy")};
      }};
}

/// 1 kg on a spring without length, from z = 1 m at rest: z = cos(omega t).
StudyScene oscillator(const std::string& name, double omega) {
  return {.name = name, .duration = 2, .gravity = {0, 0, 0}, .draw = [omega](SystemGraph& graph) {
            auto& mass = graph.add<RigidBody>("mass", {.mass = 1, .position = {0, 0, 1}});
            const Marker foot = graph.ground().marker({0, 0, -9});
            graph.add<PrismaticJoint>("guide", {graph.ground().marker(), mass.marker()});
            graph.add<SpringDamper>("spring", {foot, mass.marker()}, {.stiffness = omega * omega, .natural_length = 9});
            return std::vector<Sensor>{height(mass.marker(), "z")};
          }};
}

StudyMethod runge_kutta(const std::string& name = "Runge-Kutta", double factor = 1) {
  return {name, Setting::tolerance, [factor](double tolerance) {
            return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{
                .tolerance = {.relative = factor * tolerance, .absolute = factor * tolerance}});
          }};
}
StudyMethod alpha() {
  return {"alpha", Setting::step, [](double step) {
            return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{
                .step = step, .form = GeneralizedAlpha::Form::stabilized_index2, .newton_tolerance = 1e-12});
          }};
}

/// Runge-Kutta that gives up, or creeps, from a time on.
class Lame final : public Integrator {
 public:
  enum class Way { fails, creeps };
  explicit Lame(Way way) : way_(way), sound_({.step = 0.01}) {}
  std::string name() const override { return "lame"; }
  const IntegratorStatistics& statistics() const override { return sound_.statistics(); }

 protected:
  void prepare(EquationsOfMotion& equations, State& state) override { sound_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    if (state.time < 0.3) return sound_.step(equations, state, std::min(t_stop, 0.3));
    if (way_ == Way::fails) return {StepResult::Outcome::failed, "the rod is tired"};
    state.time += 1e-12;
    return {};
  }

 private:
  Way way_;
  ExplicitRungeKutta sound_;
};
StudyMethod lame(const std::string& name, Lame::Way way) {
  return {name, Setting::tolerance, [way](double) { return std::make_unique<Lame>(way); }};
}

WorkPrecisionOptions quick() {
  return {.references = {runge_kutta(), runge_kutta("Runge-Kutta, tighter", 0.1)},
          .reference_tolerance = 1e-11,
          .steps = {0.01, 0.005, 0.0025},
          .repeats = 1};
}

WorkPoint point(const std::string& method, double setting, double error, double cpu) {
  return {.method = method, .setting = setting, .error = error, .cpu = cpu};
}

TEST(WorkPrecision, TighterSettingsGiveSmallerErrorsByTheOrderOfTheMethod) {
  const WorkPrecision result = work_precision(pendulum(), {runge_kutta(), alpha()}, {1e-3, 1e-5, 1e-7}, quick());
  ASSERT_EQ(result.points.size(), 6u);
  EXPECT_TRUE(result.reference_good());
  EXPECT_LT(result.reference_agreement, 1e-8);
  for (int i : {1, 2, 4, 5}) {
    EXPECT_LT(result.points[i].error, result.points[i - 1].error);
    EXPECT_GT(result.points[i].statistics.steps, result.points[i - 1].statistics.steps);
    EXPECT_EQ(result.points[i].outcome, Outcome::reached);
    EXPECT_GT(result.points[i].cpu, 0);
  }
  EXPECT_EQ(result.points[3].setting, 0.01);
  EXPECT_EQ(result.points[3].statistics.steps, 100);
  EXPECT_NEAR(result.points[3].error / result.points[4].error, 4, 0.1);
  EXPECT_NEAR(result.points[4].error / result.points[5].error, 4, 0.05);
}

TEST(WorkPrecision, TheErrorIsThatAgainstTheExactMotionInCharacteristicLengths) {
  const double omega = 5;
  StudyScene scene = oscillator("oscillator", omega);
  WorkPrecisionOptions options = quick();
  options.steps = {0.01};
  options.samples = 7;
  const double error = work_precision(scene, {alpha()}, {}, options).points.at(0).error;
  const StudySystem study(scene);
  std::vector<double> times;
  for (int i = 1; i <= 7; ++i) times.push_back(2.0 * i / 7);
  const StudyRun run = run_study(study, alpha(), 0.01, times, 60, Sampling::dense);
  double exact = 0;
  for (int i = 0; i < 7; ++i)
    exact = std::max(exact, std::abs(run.samples.at(i, 1) - std::cos(omega * run.samples.at(i, 0))));
  EXPECT_GT(exact, 1e-4);
  EXPECT_NEAR(error, exact, 1e-8);

  scene.characteristic_length = 0.01;
  EXPECT_NEAR(work_precision(scene, {alpha()}, {}, options).points.at(0).error, 100 * exact, 1e-6);
}

TEST(WorkPrecision, OfAVectorTheEuclideanNormCounts) {
  const StudySystem study(pendulum());  // watches tip_x, tip_y, tip_z and an energy; 0.5 m
  const Table a{.columns = {"t", "tip_x", "tip_y", "tip_z", "energy"}, .values = {0.5, 0, 0, 0, 0, 1, 1, 1, 1, 1}};
  Table b = a;
  b.values[1] = 0.3, b.values[2] = -0.4;
  EXPECT_DOUBLE_EQ(largest_difference(study, a, b), 1.0);
  b.values[9] = 1.7;
  EXPECT_DOUBLE_EQ(largest_difference(study, a, b), 1.4);
}

TEST(WorkPrecision, TheRecommendationIsTheCheapestPointWithinEachDecade) {
  WorkPrecision result{.scene = "made up", .duration = 2, .reference = "by hand", .reference_agreement = 1e-9};
  result.points = {point("A", 1e-2, 3e-3, 0.001), point("A", 1e-4, 3e-5, 0.01), point("A", 1e-6, 3e-7, 0.1),
                   point("B", 1e-2, 5e-2, 1e-4),  point("B", 1e-3, 5e-5, 0.02), point("B", 1e-4, 2e-6, 0.05),
                   point("C", 1e-9, 5e-9, 1e-6)};  // below the floor: nothing can be said of it
  result.points.push_back({.method = "D", .outcome = Outcome::failed, .why = "stuck", .error = 0, .cpu = 1e-9});
  std::vector<int> best;
  for (const Recommendation& r : result.recommendations()) best.push_back(r.point);
  EXPECT_EQ(best, (std::vector<int>{0, 1, 1, 5, 2}));  // 1e-2, 1e-3, 1e-4, 1e-5, 1e-6
  const std::string table = result.table();
  EXPECT_NE(table.find("for 1e-5: B, tolerance 1e-4, 25 ms a second\n"), std::string::npos) << table;
  EXPECT_NE(table.find("for 1e-2: A, tolerance 1e-2, 500 µs a second\n"), std::string::npos) << table;
  EXPECT_NE(table.find("NOT GOOD ENOUGH for 1 of 8 points"), std::string::npos) << table;
  EXPECT_EQ(table.find("for 1e-7"), std::string::npos);
}

TEST(WorkPrecision, AnErrorThatATighterSettingPassesAgainIsLuck) {
  WorkPrecision result{.scene = "made up", .reference = "by hand", .reference_agreement = 1e-12};
  result.points = {point("A", 1e-2, 7e-4, 0.001), point("A", 1e-3, 5e-3, 0.002), point("A", 1e-4, 9e-4, 0.004)};
  const std::vector<Recommendation> best = result.recommendations();
  ASSERT_EQ(best.size(), 2u);
  EXPECT_EQ(best[0].point, 0) << "within 1e-2 the whole line is";
  EXPECT_EQ(best[1].point, 2);
}

TEST(WorkPrecision, AReferenceThatTheOtherMethodContradictsIsSaidToBeNoGood) {
  WorkPrecisionOptions options = quick();
  options.references[1] = runge_kutta("sloppy", 1e8);
  const WorkPrecision result = work_precision(pendulum(), {runge_kutta()}, {1e-1, 1e-8}, options);
  EXPECT_FALSE(result.reference_good());
  EXPECT_GT(result.reference_agreement, 1e-6);
  EXPECT_TRUE(result.is_below_floor(result.points[1])) << "its error cannot be told from the reference's";
  EXPECT_NE(result.table().find("THE REFERENCE IS NOT GOOD ENOUGH"), std::string::npos);
  for (const Recommendation& r : result.recommendations()) EXPECT_EQ(r.point, 0);
  const std::vector<ChartLine> lines = result.chart().lines;
  EXPECT_EQ(lines.back().style, LineStyle::dashed);
  EXPECT_EQ(lines.back().x[0], result.floor());
}

TEST(WorkPrecision, AReferenceThatFailsLeavesNothingToRecommend) {
  WorkPrecisionOptions options = quick();
  options.references[0] = lame("lame", Lame::Way::fails);
  const WorkPrecision result = work_precision(pendulum(), {runge_kutta()}, {1e-5}, options);
  EXPECT_FALSE(result.reference_good());
  EXPECT_TRUE(result.recommendations().empty());
  EXPECT_LT(result.points[0].error, 1e-2) << "measured against the one that is left";
  EXPECT_NE(result.table().find("unproven, since lame"), std::string::npos) << result.table();
  EXPECT_NE(result.table().find("the rod is tired"), std::string::npos) << result.table();

  options.references[1] = options.references[0];
  EXPECT_THROW(work_precision(pendulum(), {runge_kutta()}, {1e-5}, options), SimulationError);
  options.references.pop_back();
  EXPECT_THROW(work_precision(pendulum(), {runge_kutta()}, {1e-5}, options), SceneError);
}

TEST(WorkPrecision, RunsThatFailOrCreepAreKeptWithTheirReason) {
  WorkPrecisionOptions options = quick();
  options.time_limit = 0.2;
  const StudyMethod refusing{
      "refusing", Setting::tolerance, [](double tolerance) -> std::unique_ptr<Integrator> {
        return std::make_unique<ExplicitRungeKutta>(ExplicitRungeKutta::Parameters{.step = -tolerance});
      }};
  const WorkPrecision result = work_precision(
      pendulum(), {runge_kutta(), lame("tired", Lame::Way::fails), lame("creeping", Lame::Way::creeps), refusing},
      {1e-3, 1e-4}, options);
  ASSERT_EQ(result.points.size(), 8u);
  EXPECT_EQ(result.points[2].outcome, Outcome::failed);
  EXPECT_EQ(result.points[2].why, "t = 0.3 s: the rod is tired");
  EXPECT_EQ(result.points[2].statistics.steps, 30);
  EXPECT_EQ(result.points[4].outcome, Outcome::too_slow);
  EXPECT_NE(result.points[4].why.find("stopped at t = 0.3 s after 200 ms"), std::string::npos) << result.points[4].why;
  EXPECT_EQ(result.points[5].outcome, Outcome::too_slow);
  EXPECT_EQ(result.points[5].cpu, 0) << "a tighter tolerance is not tried";
  EXPECT_EQ(result.points[6].outcome, Outcome::failed);
  EXPECT_NE(result.points[6].why.find("step"), std::string::npos) << result.points[6].why;
  for (const Recommendation& r : result.recommendations()) EXPECT_LT(r.point, 2);

  const std::vector<ChartLine> lines = result.chart().lines;
  ASSERT_EQ(lines.size(), 1u) << "what has no error has no point";
  EXPECT_EQ(lines[0].title, "Runge-Kutta");
}

TEST(WorkPrecision, WritesAllThatWasMeasured) {
  const ScratchFolder folder;
  WorkPrecision result{.scene = "made up", .duration = 2, .reference = "by hand", .reference_agreement = 1e-9};
  result.points = {point("alpha, index 2", 1e-2, 3e-3, 0.5)};
  result.points[0].kind = Setting::step;
  result.points[0].statistics = {
      .steps = 7, .rejected = 6, .newton_iterations = 5, .factorizations = 4, .evaluations = 3, .newton_failures = 2};
  result.points.push_back({.method = "B", .setting = 1e-3, .outcome = Outcome::failed, .why = "a \"bad\" step"});
  result.write_csv(folder.path("chart.csv"));
  EXPECT_EQ(file_text(folder.path("chart.csv")),
            "method,kind,setting,error,cpu_s,cpu_s_per_s,steps,rejected,evaluations,factorizations,newton_iterations,"
            "newton_failures,outcome,below_floor,why\n"
            "\"alpha, index 2\",step,0.01,0.003,0.5,0.25,7,6,3,4,5,2,reached,0,\n"
            "B,tolerance,0.001,,0,,0,0,0,0,0,0,failed,0,\"a \"\"bad\"\" step\"\n");

  write_text(folder.path("peers.csv"), "error,Other engine,\"Third, sloppy\"\n1e-4,0.01,0.1\n1e-6,0.04,nan\n");
  const std::vector<ChartLine> peers = read_work_points(folder.path("peers.csv"));
  ASSERT_EQ(peers.size(), 2u);
  EXPECT_EQ(peers[0].x, (std::vector<double>{1e-4, 1e-6}));
  EXPECT_EQ(peers[1].title, "Third, sloppy");
  EXPECT_EQ(peers[1].y, (std::vector<double>{0.1}));
  result.write_chart(folder.path("chart"), peers);
  const std::string svg = file_text(folder.path("chart.svg"));
  for (const char* words : {"alpha, index 2", "Other engine", "CPU time a simulated second"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
}

TEST(WorkPrecision, OfModelsComesToAStandAtTheErrorOfTheModel) {
  const double exact = 5;
  const std::vector<StudyScene> models = {oscillator("coarse", 5.5), oscillator("fine", 5.05)};
  Table given{.columns = {"t", "z", "of no interest"}, .values = {}};
  double coarse = 0, fine = 0;
  for (double t : {0.0, 0.4, 0.8, 1.2, 1.6, 2.0, 2.4}) {
    given.add_row({t, std::cos(exact * t), 0});
    if (t > 2) continue;  // beyond the duration
    coarse = std::max(coarse, std::abs(std::cos(5.5 * t) - std::cos(exact * t)));
    fine = std::max(fine, std::abs(std::cos(5.05 * t) - std::cos(exact * t)));
  }
  const WorkPrecision result = model_precision("models", models, given, runge_kutta(), {1e-6, 1e-9}, quick());
  ASSERT_EQ(result.points.size(), 4u);
  EXPECT_EQ(result.points[0].method, "coarse");
  for (int i : {0, 1}) EXPECT_NEAR(result.points[i].error, coarse, 1e-4 * coarse);
  for (int i : {2, 3}) EXPECT_NEAR(result.points[i].error, fine, 1e-3 * fine);
  EXPECT_NE(result.table().find("reference: given, 5 instants"), std::string::npos) << result.table();

  // Against the finest model itself: no error but that of time is left to it.
  const WorkPrecision self = model_precision("models", models, models[1], runge_kutta(), {1e-6}, quick());
  EXPECT_GT(self.points[0].error, 0.1);
  EXPECT_LT(self.points[1].error, 1e-4);
  EXPECT_TRUE(self.reference_good());
}

TEST(WorkPrecision, MistakesAreTold) {
  StudyScene scene = pendulum();
  EXPECT_THROW(work_precision(scene, {runge_kutta()}, {0}, quick()), SceneError);
  scene.draw = [](SystemGraph& graph) {
    graph.add<RigidBody>("body");
    return std::vector<Sensor>{};
  };
  const std::string unwatched = message_of<SceneError>([&] { work_precision(scene, {}, {1e-3}, quick()); });
  EXPECT_NE(unwatched.find("watches nothing"), std::string::npos) << unwatched;
  const std::string unknown = message_of<SceneError>([] {
    select_methods({runge_kutta(), alpha()}, {"RUNGE", "rosenbrock"});
  });
  EXPECT_NE(unknown.find("known are: Runge-Kutta; alpha"), std::string::npos) << unknown;
  EXPECT_EQ(select_methods({runge_kutta(), alpha()}, {"ALP"}).at(0).name, "alpha");
  for (const char* word : {"tolerances=1e-3,tight", "nonsense=1", "out"})
    EXPECT_THROW(chart_study(pendulum(), {}, quick().references, {word, "limit=1x"}), SceneError) << word;
}

TEST(WorkPrecision, NumbersAreShort) {
  for (const auto& [value, text] : {std::pair(1e-5, "1e-5"),
                                    {2.5e-12, "2.5e-12"},
                                    {0.01, "1e-2"},
                                    {0.25, "0.25"},
                                    {10.0, "10"},
                                    {1412.0, "1410"},
                                    {999.6, "1000"},
                                    {12345.0, "1.23e4"},
                                    {0.0, "0"},
                                    {1.0 / 0.0, "inf"}})
    EXPECT_EQ(short_number(value), text);
  for (const auto& [value, text] :
       {std::pair(2e-3, "2 ms"), {1.5, "1.5 s"}, {6.25e-5, "62.5 µs"}, {1e-3, "1 ms"}, {3e-8, "30 ns"}})
    EXPECT_EQ(duration_text(value), text);
}

TEST(WorkPrecision, AllOfTheCatalogueComesCloserToItsReferencesWithTighterSettings) {
  WorkPrecisionOptions options{.references = reference_methods(), .reference_tolerance = 1e-9, .repeats = 1};
  options.steps = {0.01, 0.001};
  const WorkPrecision result = work_precision(oscillator("oscillator", 5), standard_methods(), {1e-3, 1e-5}, options);
  EXPECT_LT(result.reference_agreement, 1e-5);
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    const WorkPoint& point = result.points[i];
    EXPECT_EQ(point.outcome, Outcome::reached) << point.method << ": " << point.why;
    if (i % 2 == 0) continue;                      // the looser setting
    EXPECT_LT(point.error, 0.03) << point.method;  // order 1 at 1 ms: 0.023
    EXPECT_LT(point.error, 0.3 * result.points[i - 1].error) << point.method;
  }
}

}  // namespace
}  // namespace lithe::test::study_work_precision_test
