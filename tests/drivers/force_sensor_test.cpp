/// Force/torque sensors in physics: the weight behind them, contacts, and who has none.
#ifdef POLYARM_MUJOCO

#include "polyarm/hardware/force_sensor.hpp"

#include "drivers/mujoco/component.hpp"
#include "polyarm/force/admittance_rule.hpp"
#include "tests/drivers/rig.hpp"

namespace polyarm::test::force_sensor_test {
namespace {

constexpr double kGravity = 9.81, kTool = 1.5, kColumn = 2;  // m/s², kg, kg

description::ComponentInfo sensor(const std::string& frame) {
  description::ComponentInfo out;
  out.name = "fts";
  out.kind = "sensor";
  out.parameters["frame_id"] = frame;
  for (const char* axis : {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"})
    out.state_interfaces.emplace_back().name = axis;
  return out;
}

/// The gantry with a tool of 1.5 kg behind a sensor whose z points down.
struct Pressing {
  Stage stage;
  std::unique_ptr<Rig> rig;
  explicit Pressing(const std::string& frame = "tool0", description::Scene scene = {},
                    const std::map<std::string, std::string>& errors = {}) {
    stage.model = gantry();
    stage.model.links[4].inertial =
        description::Inertial{kTool, {0.02, 0, 0.05}, {1e-3, 0, 0, 1e-3, 0, 1e-3}};
    stage.model.links[4].collisions = {box({0.06, 0.06, 0.1}, {0, 0, 0.05})};
    stage.scene = std::move(scene);
    hardware::ComponentContext context = stage.context(1'000'000);
    description::HardwareInfo block;
    block.components = {sensor(frame)};
    for (const auto& [name, value] : errors) block.components[0].parameters[name] = value;
    context.robots[0].hardware = {block};
    rig = std::make_unique<Rig>(std::make_unique<drivers::MujocoComponent>(), context);
  }
  double measured(const char* axis) const { return rig->state(std::string("arm/fts/") + axis); }
};

TEST(MujocoForceSensor, MeasuresTheWeightBehindIt) {
  Pressing arm;
  arm.rig->run(0.5);
  const double weight = kTool * kGravity;  // along the sensor's z, which points down
  EXPECT_NEAR(arm.measured("force.x"), 0, 1e-3);
  EXPECT_NEAR(arm.measured("force.y"), 0, 1e-3);
  EXPECT_NEAR(arm.measured("force.z"), weight, 1e-2);
  EXPECT_NEAR(arm.measured("torque.x"), 0, 1e-3);
  EXPECT_NEAR(arm.measured("torque.y"), -0.02 * weight, 1e-3);
  EXPECT_NEAR(arm.measured("torque.z"), 0, 1e-3);
}

TEST(MujocoForceSensor, MeasuresTheForceOfAContact) {
  description::Scene scene;
  scene.floor = true;
  scene.floor_height = 0.3;
  Pressing arm("tool0", scene);
  arm.rig->move({{"arm/z/position", -0.105}}, 1);  // the tool ends 100 mm below tool0, 5 mm inside the floor
  arm.rig->run(1);
  const double effort = arm.rig->state("arm/z/effort");
  EXPECT_LT(arm.measured("force.z"), kTool * kGravity - 20) << "the floor pushes against z";
  EXPECT_NEAR(arm.measured("force.z"), effort - kColumn * kGravity, 0.5)
      << "what the drive carries, less the column";
}

TEST(MujocoForceSensor, AnAdmittancePressesAsHardAsItsSpring) {
  description::Scene scene;
  scene.floor_height = 0.3;
  Pressing arm("tool0", scene);
  const int tool = arm.stage.model.find_link("tool0");
  controllers::AdmittanceRule rule(arm.stage.model, {tool, 0, 0, 0, tool}, {0, 1, 2});
  controllers::AdmittanceParameters parameters;
  parameters.axes = {false, false, true, false, false, false};
  parameters.mass.fill(5);
  parameters.stiffness.fill(500);
  parameters.damping_ratio.fill(10);  // D = 1000 N s/m
  parameters.joint_damping = parameters.alpha = 0;
  parameters.filter = 0.5;
  parameters.weight = kTool * kGravity;
  parameters.cog = {0.02, 0, 0.05};
  rule.set(parameters);
  double least = 1e9, most = 0;
  for (int k = 0; k < 8000; ++k) {
    const double down = std::max(-0.12, -0.00005 * k);  // at 50 mm/s; the floor is 100 mm below
    const std::array<double, 3> reference{0, 0, down},
        measured{arm.rig->state("arm/x/position"), arm.rig->state("arm/y/position"),
                 arm.rig->state("arm/z/position")};
    controllers::SixVector wrench;
    const char* const axes[] = {"force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"};
    for (std::size_t i = 0; i < 6; ++i) wrench[i] = arm.measured(axes[i]);
    ASSERT_TRUE(rule.update(measured, reference, wrench, 0.001));
    arm.rig->command("arm/z/position") = down + rule.offset()[2];
    ASSERT_EQ(arm.rig->cycle(), hardware::ReturnType::ok);
    const double contact = kTool * kGravity - arm.measured("force.z");
    most = std::max(most, contact);
    if (k > 7000) least = std::min(least, contact);
  }
  const double contact = kTool * kGravity - arm.measured("force.z");
  EXPECT_NEAR(contact, 500 * 0.02, 0.5) << "20 mm of its spring";
  EXPECT_GT(least, 0.95 * contact) << "it does not bounce";
  EXPECT_LT(most, 100) << "and did not hit hard: 50 mm/s against 1000 N s/m, and the mass of the column";
}

TEST(MujocoForceSensor, IsMeasuredOnlyAtALinkThatIsThere) {
  EXPECT_TRUE(Pressing("tool0").rig->has_state("arm/fts/force.z"));
  for (const char* frame : {"base_link", "tool1", ""})
    EXPECT_FALSE(Pressing(frame).rig->has_state("arm/fts/force.z"));
  description::ComponentInfo other = sensor("tool0");
  other.state_interfaces.clear();
  EXPECT_EQ(hardware::force_sensor_link(gantry(), other), -1);
}

/// Readings of `axis` of an arm at rest, one in each cycle.
std::vector<double> readings(Pressing& arm, const char* axis, int count) {
  std::vector<double> out;
  for (int k = 0; k < count; ++k) {
    EXPECT_EQ(arm.rig->cycle(), hardware::ReturnType::ok);
    out.push_back(arm.measured(axis));
  }
  return out;
}

std::pair<double, double> mean_and_deviation(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double each : values) sum += each;
  const double mean = sum / static_cast<double>(values.size());
  for (const double each : values) squares += (each - mean) * (each - mean);
  return {mean, std::sqrt(squares / static_cast<double>(values.size() - 1))};
}

TEST(MujocoForceSensor, NoiseAndBiasAreThoseThatWereAskedFor) {
  Pressing arm("tool0", {}, {{"noise", "0.2"}, {"torque_noise", "0.01"}, {"bias", "1 0 0 0 0.5 0"}});
  arm.rig->run(0.5);
  const auto [force, of_force] = mean_and_deviation(readings(arm, "force.x", 4000));
  EXPECT_NEAR(force, 1, 0.02);
  EXPECT_NEAR(of_force, 0.2, 0.01);
  const auto [torque, of_torque] = mean_and_deviation(readings(arm, "torque.y", 4000));
  EXPECT_NEAR(torque, 0.5 - 0.02 * kTool * kGravity, 2e-3);
  EXPECT_NEAR(of_torque, 0.01, 5e-4);
}

TEST(MujocoForceSensor, TheZeroDriftsAsFarAsItIsSaid) {
  double squares = 0;
  constexpr int kSeeds = 40;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Pressing arm("tool0", {}, {{"drift", "2"}, {"seed", std::to_string(seed)}});
    arm.rig->run(1.5);
    squares += arm.measured("force.x") * arm.measured("force.x");
  }
  EXPECT_NEAR(std::sqrt(squares / kSeeds), 2 * std::sqrt(1.5 / 60), 0.1);
}

TEST(MujocoForceSensor, TheSameSeedGivesTheSameReadings) {
  const auto with_seed = [](const char* seed) {
    Pressing arm("tool0", {}, {{"noise", "0.2"}, {"drift", "1"}, {"seed", seed}});
    return readings(arm, "force.y", 50);
  };
  EXPECT_EQ(with_seed("7"), with_seed("7"));
  EXPECT_NE(with_seed("7"), with_seed("8"));
}

TEST(MujocoForceSensor, WrongErrorsAreRefused) {
  description::ComponentInfo one = sensor("tool0");
  for (const auto& [name, value] :
       {std::pair{"noise", "much"}, std::pair{"noise", "-1"}, std::pair{"bias", "1 2 3"},
        std::pair{"drift", "nan"}, std::pair{"seed", "1.5"}}) {
    one.parameters = {{name, value}};
    EXPECT_THROW(hardware::force_sensor_errors(one), Error) << name << ' ' << value;
  }
  hardware::ForceSensorErrors errors;
  errors.noise = 0.25, errors.bias[4] = -0.1, errors.seed = 9;
  one.parameters.clear();
  hardware::set_force_sensor_errors(errors, one);
  const hardware::ForceSensorErrors again = hardware::force_sensor_errors(one);
  EXPECT_EQ(again.noise, errors.noise);
  EXPECT_EQ(again.bias, errors.bias);
  EXPECT_EQ(again.seed, 9u);
}

}  // namespace
}  // namespace polyarm::test::force_sensor_test

#endif
