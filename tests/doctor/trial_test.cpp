#include "polyarm/doctor/trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "polyarm/base/error.hpp"
#include "polyarm/yaml/yaml.hpp"

namespace polyarm::doctor {
namespace {

using hardware::CallbackReturn;
using hardware::ReturnType;

/// A joint that follows, and notes what is done to it.
class Scripted : public hardware::Component {
 public:
  CallbackReturn on_init(const hardware::ComponentContext&) override {
    if (bad_parameters) throw Error("bad-value", "the port is missing");
    return CallbackReturn::success;
  }
  CallbackReturn on_configure() override {
    return configured = openable ? CallbackReturn::success : CallbackReturn::failure;
  }
  CallbackReturn on_activate() override { return done += "activate ", CallbackReturn::success; }
  CallbackReturn on_deactivate() override { return done += "deactivate ", CallbackReturn::success; }
  CallbackReturn on_error() override { return done += "error ", CallbackReturn::success; }
  CallbackReturn on_shutdown() override { return done += "shutdown", CallbackReturn::success; }
  std::vector<hardware::InterfaceDescription> state_interfaces() const override {
    return {{"trial/j/position"}, {"trial/j/frames"}, {"trial/j/temperature"}};
  }
  std::vector<hardware::InterfaceDescription> command_interfaces() const override {
    return {{"trial/j/position"}, {"trial/j/torque"}};
  }
  ReturnType read(const hardware::Cycle&, std::span<double> states) noexcept override {
    states[0] = position, states[1] = ++reads, states[2] = 41;
    return reads == fails_at ? ReturnType::error : ReturnType::ok;
  }
  ReturnType write(const hardware::Cycle&, std::span<const double> commands) noexcept override {
    ++writes;
    position = commands[0];
    farthest = std::max(farthest, std::abs(position - 1));
    torqued = torqued || std::isfinite(commands[1]);
    return ReturnType::ok;
  }
  bool real() const noexcept override { return is_real; }
  std::string reason() const override { return reads == fails_at || !openable ? "the \"cable\" is out" : ""; }
  std::string summary() const override { return "one joint"; }

  bool bad_parameters = false, openable = true, is_real = true, torqued = false;
  int reads = 0, writes = 0, fails_at = -1;
  double position = 1, farthest = 0;
  CallbackReturn configured{};
  std::string done;
};

Trial tried(Scripted& component, TrialOptions options = {}) {
  options.rate = 1000;
  options.seconds = 0.02;
  hardware::ComponentContext context;
  context.name = "scripted";
  context.parameters = {{"port", "/dev/x: \"y\""}};
  return try_driver(component, context, options);
}

TEST(DriverTrial, ReadsARealDeviceWithoutActivatingOrWriting) {
  Scripted component;
  const Trial trial = tried(component);
  EXPECT_TRUE(trial.passed) << trial.failure;
  EXPECT_EQ(component.done, "shutdown");
  EXPECT_EQ(component.writes, 0);
  EXPECT_EQ(trial.reads, 20u);
  EXPECT_FALSE(trial.moved);
  EXPECT_EQ(trial.states.at(0).last, 1);
  EXPECT_EQ(trial.states.at(1).last - trial.states.at(1).first, 19);
  const auto lines = highlights(trial);
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                          [](const auto& l) { return l.find("j/frames: 19 ") != std::string::npos; }));
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                          [](const auto& l) { return l.find("temperature: 41") != std::string::npos; }));
}

TEST(DriverTrial, ASimulatedOneIsActivated) {
  Scripted component;
  component.is_real = false;
  EXPECT_TRUE(tried(component).passed);
  EXPECT_EQ(component.done, "activate deactivate shutdown");
  EXPECT_EQ(component.writes, 0);
}

TEST(DriverTrial, MovesALittleWayAndBackOnlyWhenAsked) {
  Scripted component;
  TrialOptions options;
  options.move = true;
  const Trial trial = tried(component, options);
  EXPECT_TRUE(trial.passed && trial.moved) << trial.failure;
  EXPECT_NEAR(component.farthest, 0.05, 1e-6);
  EXPECT_NEAR(component.position, 1, 1e-9);
  EXPECT_FALSE(component.torqued) << "only positions are commanded";
  EXPECT_EQ(component.done, "activate deactivate shutdown");
}

TEST(DriverTrial, DoesNotMoveFromAnUnknownPlace) {
  Scripted component;
  component.position = NAN;
  TrialOptions options;
  options.move = true;
  const Trial trial = tried(component, options);
  EXPECT_FALSE(trial.passed || trial.moved);
  EXPECT_EQ(component.writes, 0);
  EXPECT_NE(trial.failure.find("trial/j/position cannot be moved"), std::string::npos);
}

TEST(DriverTrial, FailuresSayWhichStepAndWhy) {
  Scripted parameters, opening, reading;
  parameters.bad_parameters = true;
  EXPECT_NE(tried(parameters).failure.find("port is missing"), std::string::npos);
  opening.openable = false;
  EXPECT_EQ(tried(opening).failure, "opening failed: the \"cable\" is out");
  EXPECT_EQ(opening.done, "");
  reading.fails_at = 7;
  const Trial trial = tried(reading);
  EXPECT_FALSE(trial.passed);
  EXPECT_EQ(trial.failure, "reading failed: the \"cable\" is out");
  EXPECT_EQ(trial.reads, 6u);
  EXPECT_EQ(reading.done, "error shutdown");
}

TEST(DriverTrial, APersonEndsItInGoodOrder) {
  Scripted component;
  component.is_real = false;
  TrialOptions options;
  options.stop = [&] { return component.reads >= 3; };
  const Trial trial = tried(component, options);
  EXPECT_TRUE(trial.stopped);
  EXPECT_FALSE(trial.passed);
  EXPECT_EQ(component.done, "activate deactivate shutdown");
}

TEST(DriverTrial, TheReportIsYamlWhateverTheTexts) {
  Scripted component;
  component.fails_at = 7;
  const Yaml file =
      Yaml::parse(report(tried(component), {"1.0", "6.8", "never: on \"hardware\"", "now", true}), "report");
  EXPECT_EQ(file["result"].text(), "failed");
  EXPECT_EQ(file["failure"].text(), "reading failed: the \"cable\" is out");
  EXPECT_EQ(file["parameters"]["port"].text(), "/dev/x: \"y\"");
  EXPECT_EQ(file["proof_so_far"].text(), "never: on \"hardware\"");
  EXPECT_EQ(file["states"].items().size(), 3u);
  EXPECT_EQ(file["states"].items()[2]["last"].number(), 41);
  EXPECT_TRUE(file["preempt_rt"].boolean());
}

}  // namespace
}  // namespace polyarm::doctor
