#include "engine/observe/recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/rigid_body.h"
#include "engine/model/system_graph.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "tests/engine/output/output_scratch_folder.h"

namespace lithe::test::recorder_test {

using lithe::test::message_of;
using lithe::test::ScratchFolder;
using testing::ElementsAre;
using testing::HasSubstr;

namespace {

/// A stone thrown upwards: z = 2 t - ½ 10 t².
struct Stone {
  Stone() {
    stone = &graph.add<RigidBody>("stone", {.velocity = Vector3(1, 0, 2)});
    middle = stone->marker();
  }
  SystemGraph graph{{.gravity = {0, 0, -10}}};
  RigidBody* stone;
  Marker middle;
};

}  // namespace

TEST(recorder, keeps_time_and_the_columns_of_its_sensors) {
  Stone s;
  const System system = assemble(s.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-2}};
  Simulation simulation{system, integrator};
  Recorder flight{{height(s.middle), velocity(s.middle, "speed"), kinetic_energy(*s.stone)}};
  simulation.observe(flight, every(0.1));
  simulation.run(state, 0.2);

  const Table& table = flight.table();
  EXPECT_THAT(table.columns,
              ElementsAre("t", "stone_m0_height", "speed_x", "speed_y", "speed_z", "stone_kinetic_energy"));
  EXPECT_THAT(table.column("t"), ElementsAre(0, 0.1, 0.2));
  EXPECT_NEAR(table.at(2, 1), 0.2, 1e-9);
  EXPECT_NEAR(table.at(2, 2), 1, 1e-12);
  EXPECT_NEAR(table.at(1, 4), 1, 1e-9);
  EXPECT_NEAR(table.at(0, 5), 2.5, 1e-12);

  const ScratchFolder folder;
  flight.write_csv(folder.path("flight.csv"));
  flight.write_binary(folder.path("flight.bin"));
  EXPECT_EQ(read_csv(folder.path("flight.csv")).values, table.values);
  EXPECT_EQ(read_binary(folder.path("flight.bin")).columns, table.columns);
}

TEST(recorder, refuses_two_columns_of_one_name) {
  Stone s;
  const std::string message = message_of<SceneError>([&] {
    Recorder{{position(s.middle, "it"), kinetic_energy("it_z")}};
  });
  EXPECT_THAT(message, HasSubstr("two columns of a recorder are called 'it_z'"));
  EXPECT_THAT(message, HasSubstr("recorder_test.cpp:"));
  EXPECT_THROW((Recorder{{kinetic_energy("t")}}), SceneError);
}

TEST(recorder, a_value_that_is_no_number_never_travels_silently) {
  Stone s;
  const System system = assemble(s.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-2}};
  Simulation simulation{system, integrator};
  // √z: below the hand after 0.4 s
  Recorder flight{{height(s.middle, "z"), Sensor{"root", {"root"}, [&](Snapshot& now, std::span<double> out) {
                                                   out[0] = std::sqrt(now.marker(s.middle).p.z() + 0.1);
                                                 }}}};
  simulation.observe(flight, every(0.1));
  const std::string message = message_of<SimulationError>([&] { simulation.run(state, 1); });
  EXPECT_THAT(message, HasSubstr("sensor 'root' reads"));
  EXPECT_THAT(message, HasSubstr("at t = 0.5 s"));
  EXPECT_THAT(message, HasSubstr("recorder_test.cpp:"));
  EXPECT_EQ(flight.table().row_count(), 5);  // whole rows, up to 0.4 s
  EXPECT_EQ(state.time, 0.5);
}

TEST(recorder, a_column_that_its_sensor_forgets_is_seen) {
  Stone s;
  const System system = assemble(s.graph);
  Snapshot now{system, system.initial_state()};
  Recorder recorder{{Sensor{"pair", {"first", "second"}, [](Snapshot&, std::span<double> out) { out[0] = 1; }}}};
  EXPECT_THAT(message_of<SimulationError>([&] { recorder.observe(now); }), HasSubstr("'second'"));
}

}  // namespace lithe::test::recorder_test
