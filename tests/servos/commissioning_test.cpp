#include "drivers/servo_bus/commissioning.hpp"

#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <vector>

#include "drivers/servo_bus/setup.hpp"
#include "polyarm/base/file.hpp"
#include "tests/servos/rig.hpp"

namespace polyarm::test {
namespace {

using servo_bus::Commissioning;
using servo_bus::CommissioningOptions;
namespace fs = std::filesystem;

/// A person who does what is asked: for each question, in order, a deed and an answer.
class Person : public servo_bus::Dialogue {
 public:
  struct Step {
    std::string question;  ///< must stand in what is asked
    std::function<void(const std::function<void()>&)> deed;
    std::string answer;
  };
  void expect(std::string question, std::string answer,
              std::function<void(const std::function<void()>&)> deed = {}) {
    steps_.push_back({std::move(question), std::move(deed), std::move(answer)});
  }
  void say(const std::string& text) override { heard += text + "\n"; }
  std::string ask(const std::string& question, const std::function<void()>& meanwhile) override {
    if (steps_.empty()) throw Error("no-answer", "nobody expected: " + question);
    const Step step = steps_.front();
    steps_.pop_front();
    EXPECT_NE(question.find(step.question), std::string::npos) << question;
    if (step.deed) step.deed(meanwhile);
    return step.answer;
  }
  bool done() const { return steps_.empty(); }
  std::string heard;

 private:
  std::deque<Step> steps_;
};

class SettingUp : public testing::TestWithParam<Wire> {
 protected:
  SettingUp() : family(ServoRig::family_of(GetParam())) {
    std::string pattern = (fs::temp_directory_path() / "polyarm_setup_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
  }
  ~SettingUp() override { fs::remove_all(folder); }
  Commissioning setup(const FakeBus& fake) { return setup(fake.path()); }
  Commissioning setup(const fs::path& port) {
    CommissioningOptions options;
    options.joints = {"a", "b", "c"};
    options.calibration = folder / "calibration.yaml";
    options.backup = folder / "backup.yaml";
    options.port = port.string();
    options.baud = family.default_baud;
    options.highest_id = 6;
    options.answer_timeout = 60'000'000;
    const bool feetech = GetParam() == Wire::feetech;
    return Commissioning(
        family,
        [feetech]() -> std::unique_ptr<servo_bus::Protocol> {
          if (feetech) return std::make_unique<feetech::Protocol0>();
          return std::make_unique<dynamixel::Protocol2>();
        },
        options, person);
  }
  /// The hand takes each joint from one stop to the other, in steps the encoder can follow.
  std::function<void(const std::function<void()>&)> by_hand(FakeBus& fake, int id, int from, int to) {
    return [this, &fake, id, from, to](const std::function<void()>& meanwhile) {
      for (int at = from;; at += from < to ? 200 : -200) {
        const bool last = from < to ? at >= to : at <= to;
        fake.move_by_hand(id, ((last ? to : at) % 4096 + 4096) % 4096);
        meanwhile();
        if (last) return;
      }
    };
  }
  const servo_bus::Family& family;
  fs::path folder;
  Person person;
};
INSTANTIATE_TEST_SUITE_P(On, SettingUp, testing::Values(Wire::feetech, Wire::dynamixel),
                         [](const auto& which) {
                           return std::string(which.param == Wire::feetech ? "Feetech" : "Dynamixel");
                         });

TEST_P(SettingUp, FindsWhoIsThere) {
  FakeBus fake(GetParam(), {2, 5});
  Commissioning work = setup(fake);
  const auto found = work.find();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, 2);
  EXPECT_EQ(found[1].id, 5);
  EXPECT_EQ(found[1].model, family.models.front().number == 777 ? 777 : 1020);
  EXPECT_NE(person.heard.find("id 5"), std::string::npos) << person.heard;
}

TEST_P(SettingUp, AnEmptyBusIsToldWithWhatToDo) {
  FakeBus fake(GetParam(), {});
  CommissioningOptions quick;
  try {
    setup(fake).find();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("power"), std::string::npos) << e.what();
  }
}

TEST_P(SettingUp, IdsAreGivenOneServoAtATimeAndARunGoesOnWhereItStopped) {
  FakeBus fake(GetParam(), {});
  const auto plug = [&](int take_away) {
    return [&fake, take_away](const std::function<void()>&) {
      if (take_away) fake.unplug(take_away);
      fake.plug_in(1);  // as they come out of the box
    };
  };
  person.expect("servo of a alone", "", plug(0));
  person.expect("servo of b alone", "", [&](const auto&) { fake.plug_in(5); });  // and a is still there
  person.expect("servo of b alone", "", [&](const auto&) {
    fake.unplug(1);
    fake.unplug(5);
    fake.plug_in(1);
  });
  EXPECT_THROW(setup(fake).assign_ids(), Error) << "the person goes home before c";
  EXPECT_EQ(fake.ids(), std::vector<int>{2});
  EXPECT_NE(person.heard.find("2 servos answer"), std::string::npos) << person.heard;

  person.expect("servo of c alone", "", plug(2));
  person.expect("Connect all", "");
  setup(fake).assign_ids();
  EXPECT_EQ(fake.ids(), std::vector<int>{3});
  EXPECT_TRUE(person.done());
  if (family.lock) {
    EXPECT_EQ(fake.get(3, family.lock), 1) << "the lock closes behind it";
  }
}

TEST_P(SettingUp, ChecksPresenceFirmwareAndVoltage) {
  FakeBus fake(GetParam(), {1, 2, 3});
  EXPECT_TRUE(setup(fake).check()) << person.heard;
  fake.set(2, family.firmware, 9);
  fake.set(3, family.present_voltage, 20);
  EXPECT_FALSE(setup(fake).check());
  EXPECT_NE(person.heard.find("firmware differs"), std::string::npos) << person.heard;
  EXPECT_NE(person.heard.find("voltage is outside"), std::string::npos) << person.heard;
  fake.unplug(1);
  EXPECT_FALSE(setup(fake).check());
  EXPECT_NE(person.heard.find("a: servo 1 does not answer"), std::string::npos) << person.heard;
}

TEST_P(SettingUp, RangesByHandThenZeroAndTheDriverReadsThem) {
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("stop to stop", "", [&](const std::function<void()>& meanwhile) {
    by_hand(fake, 1, 1000, 3000)(meanwhile);
    by_hand(fake, 2, 2048, 2500)(meanwhile);
    by_hand(fake, 2, 2500, 1200)(meanwhile);
  });
  person.expect("stop to stop", "", [&](const std::function<void()>& meanwhile) {  // c was forgotten
    by_hand(fake, 3, 2048, 4140)(meanwhile);  // through the end of the count
    by_hand(fake, 3, 4140, 2000)(meanwhile);
  });
  person.expect("zero pose", "", [&](const std::function<void()>& meanwhile) {
    by_hand(fake, 1, 3000, 1800)(meanwhile);
    by_hand(fake, 3, 2000, 3300)(meanwhile);
  });
  Commissioning work = setup(fake);
  work.find();
  fake.set(1, family.torque, 1);
  work.calibrate();
  EXPECT_NE(person.heard.find("not moved yet: c"), std::string::npos) << person.heard;
  EXPECT_EQ(fake.get(1, family.torque), 0);
  EXPECT_EQ(fake.get(1, family.min_limit), 1000);
  EXPECT_EQ(fake.get(1, family.max_limit), 3000);
  // c went from 2000 to 4140, 44 beyond the end of the count; its middle becomes that of the count.
  const int middle = (2000 + 4140) / 2, shift = 2048 - middle;
  EXPECT_EQ(fake.get(3, family.homing), static_cast<int>(family.homing_sign) * shift);
  EXPECT_EQ(fake.get(3, family.min_limit), 2000 + shift);
  EXPECT_EQ(fake.get(3, family.max_limit), 4140 + shift);
  const std::string text = read_file(folder / "calibration.yaml");
  EXPECT_NE(text.find("a: {id: 1, zero: 1800, min: 1000, max: 3000}"), std::string::npos) << text;
  EXPECT_NE(text.find("c: {id: 3, zero: " + std::to_string(3300 + shift)), std::string::npos) << text;

  ServoRig rig(GetParam());
  for (auto& part : rig.context.robots[0].hardware[0].components) part.parameters.clear();
  rig.set("calibration", (folder / "calibration.yaml").string());
  rig.fake.move_by_hand(1, 1800);
  ASSERT_TRUE(rig.start());
  ASSERT_EQ(rig.step(), ReturnType::ok);
  EXPECT_NEAR(rig.state(0, 0), 0, 1e-9);
}

TEST_P(SettingUp, AnInterruptedMeasurementContinuesWithTheOtherJoints) {
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("every joint", "", [&](const std::function<void()>& meanwhile) {
    by_hand(fake, 1, 1000, 3000)(meanwhile);
    by_hand(fake, 2, 1200, 2500)(meanwhile);
  });
  EXPECT_THROW(setup(fake).calibrate(), Error) << "the person goes home before c";
  EXPECT_FALSE(fs::exists(folder / "calibration.yaml"));

  fake.move_by_hand(1, 1500);  // overnight
  person.expect("type yes", "yes");
  person.expect("the other joints", "", by_hand(fake, 3, 1900, 2900));
  person.expect("zero pose", "",
                [&](const std::function<void()>& meanwhile) { by_hand(fake, 1, 1500, 1800)(meanwhile); });
  setup(fake).calibrate();
  EXPECT_TRUE(person.done());
  EXPECT_NE(person.heard.find("an earlier run has measured a, b"), std::string::npos) << person.heard;
  const std::string text = read_file(folder / "calibration.yaml");
  EXPECT_NE(text.find("a: {id: 1, zero: 1800, min: 1000, max: 3000}"), std::string::npos) << text;
  EXPECT_NE(text.find("b: {id: 2, zero: 2500, min: 1200, max: 2500}"), std::string::npos) << text;
  EXPECT_NE(text.find("c: {id: 3, zero: 2900, min: 1900, max: 2900}"), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(servo_bus::progress_file(folder / "calibration.yaml")));
}

TEST_P(SettingUp, WhatWasMeasuredIsSavedWhileAPersonStillMoves) {
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("every joint", "", [&](const std::function<void()>& meanwhile) {
    by_hand(fake, 1, 1000, 3000)(meanwhile);
    for (int k = 0; k < 30; ++k) meanwhile();
    throw std::runtime_error("the machine loses its power");
  });
  EXPECT_THROW(setup(fake).calibrate(), std::runtime_error);
  const auto progress = servo_bus::read_progress(folder / "calibration.yaml", family);
  ASSERT_TRUE(progress);
  ASSERT_EQ(progress->joints.size(), 1u);
  EXPECT_EQ(progress->joints.at("a").min, 1000);
  EXPECT_EQ(progress->joints.at("a").max, 3000);
}

TEST_P(SettingUp, ARangeThroughTheEndOfTheCountSurvivesAnInterruption) {
  if (GetParam() == Wire::dynamixel) GTEST_SKIP() << "its homing does not reach that far";
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("every joint", "", [&](const std::function<void()>& meanwhile) {
    by_hand(fake, 1, 2048, 4140)(meanwhile);  // ends at 44 of the next turn
    by_hand(fake, 2, 1200, 2500)(meanwhile);
  });
  EXPECT_THROW(setup(fake).calibrate(), Error);
  person.expect("type yes", "yes");
  person.expect("the other joints", "", by_hand(fake, 3, 1900, 2900));
  person.expect("zero pose", "",
                [&](const std::function<void()>& meanwhile) { by_hand(fake, 1, 4140, 3000)(meanwhile); });
  setup(fake).calibrate();
  const int shift = 2048 - (2048 + 4140) / 2;
  EXPECT_EQ(fake.get(1, family.min_limit), 2048 + shift);
  EXPECT_EQ(fake.get(1, family.max_limit), 4140 + shift);
  const std::string text = read_file(folder / "calibration.yaml");
  EXPECT_NE(text.find("a: {id: 1, zero: " + std::to_string(3000 + shift)), std::string::npos) << text;
}

TEST_P(SettingUp, AnInterruptedWritingIsFinishedByTheNextRunAndNotDrivenBefore) {
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("every joint", "", [&](const std::function<void()>& meanwhile) {
    for (const int id : {1, 2, 3}) by_hand(fake, id, 1000, 2900)(meanwhile);
  });
  person.expect("zero pose", "m", [&](const std::function<void()>& meanwhile) {
    meanwhile();
    fake.unplug(3);
  });
  EXPECT_THROW(setup(fake).calibrate(), Error) << "servo 3 has lost its cable";
  EXPECT_EQ(fake.get(1, family.min_limit), 1000);
  EXPECT_FALSE(fs::exists(folder / "calibration.yaml"));

  ServoRig rig(GetParam());
  for (auto& part : rig.context.robots[0].hardware[0].components) part.parameters.clear();
  write_file_atomically(folder / "calibration.yaml",
                        std::string("polyarm: servo_calibration/1\nfamily: ") + family.name +
                            "\njoints: {a: {id: 1}, b: {id: 2}, c: {id: 3}}\n");  // an old one
  rig.context.parameters["calibration"] = (folder / "calibration.yaml").string();
  try {
    servo_bus::read_setup(rig.context, family);
    FAIL() << "half of a calibration is in the servos";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "unfinished-calibration") << e.what();
  }

  fake.plug_in(3);
  person.expect("type yes", "yes");
  setup(fake).calibrate();
  EXPECT_TRUE(person.done()) << "nothing is measured again";
  EXPECT_EQ(fake.get(3, family.max_limit), 2900);
  EXPECT_EQ(servo_bus::read_setup(rig.context, family).joints[2].zero, 1950);
  EXPECT_FALSE(fs::exists(servo_bus::progress_file(folder / "calibration.yaml")));
}

TEST_P(SettingUp, AnAdapterThatIsPulledIsWaitedFor) {
  auto fake = std::make_unique<FakeBus>(GetParam(), std::vector<int>{1, 2, 3});
  const fs::path port = folder / "port";
  fs::create_symlink(fake->path(), port);
  person.expect("type yes", "yes");
  person.expect("every joint", "", [&](const std::function<void()>& meanwhile) {
    by_hand(*fake, 1, 300, 3700)(meanwhile);
    fake.reset();
    for (int k = 0; k < 60; ++k) meanwhile();
    fake = std::make_unique<FakeBus>(GetParam(), std::vector<int>{1, 2, 3});
    fs::remove(port);
    fs::create_symlink(fake->path(), port);
    fake->move_by_hand(1, 400);  // more than half a turn from where it was, inside its range
    for (int k = 0; k < 60; ++k) meanwhile();
    for (const int id : {2, 3}) by_hand(*fake, id, 1000, 2900)(meanwhile);
  });
  person.expect("zero pose", "m");
  setup(port).calibrate();
  EXPECT_NE(person.heard.find("is gone"), std::string::npos) << person.heard;
  EXPECT_NE(person.heard.find("is back"), std::string::npos) << person.heard;
  EXPECT_EQ(fake->get(1, family.min_limit), 300);
  EXPECT_EQ(fake->get(1, family.max_limit), 3700);
  EXPECT_EQ(fake->get(3, family.max_limit), 2900);
}

TEST_P(SettingUp, AProgressFileOfOthersIsRefused) {
  FakeBus fake(GetParam(), {1, 2, 3});
  for (const char* text : {"", "[", "polyarm: servo_progress/1\nfamily: other\nstage: moving\n",
                           "polyarm: servo_progress/1\nfamily: feetech\nstage: flying\n"}) {
    write_file_atomically(servo_bus::progress_file(folder / "calibration.yaml"), text);
    EXPECT_THROW(setup(fake).calibrate(), Error) << text;
  }
}

TEST_P(SettingUp, ARangeThatCannotBeMovedFromTheEndOfTheCountIsToldWithWhatToDo) {
  if (GetParam() == Wire::feetech) GTEST_SKIP() << "Feetech's homing reaches half a turn";
  FakeBus fake(GetParam(), {1, 2, 3});
  person.expect("type yes", "yes");
  person.expect("stop to stop", "", [&](const std::function<void()>& meanwhile) {
    for (const int id : {1, 2}) by_hand(fake, id, 2048, 2500)(meanwhile);
    by_hand(fake, 3, 3500, 5000)(meanwhile);
  });
  person.expect("zero pose", "m");
  try {
    setup(fake).calibrate();
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("take its horn off"), std::string::npos) << e.what();
  }
  EXPECT_EQ(fake.get(3, family.homing), 0);
}

TEST_P(SettingUp, TorqueStaysWithoutAYes) {
  FakeBus fake(GetParam(), {1, 2, 3});
  for (const int id : {1, 2, 3}) fake.set(id, family.torque, 1);
  person.expect("type yes", "no");
  EXPECT_THROW(setup(fake).calibrate(), Error);
  for (const int id : {1, 2, 3}) EXPECT_EQ(fake.get(id, family.torque), 1);
}

TEST_P(SettingUp, ABackupBringsEveryRegisterBack) {
  FakeBus fake(GetParam(), {1, 2, 3});
  fake.set(2, family.homing, -77);
  Commissioning work = setup(fake);
  work.find();
  const fs::path kept = work.back_up();
  EXPECT_EQ(work.back_up().filename(), "backup-2.yaml") << "a backup is never overwritten";
  fake.set(2, family.homing, 5);
  fake.set(3, family.max_limit, 100);
  person.expect("type yes", "yes");
  EXPECT_EQ(work.restore(kept), 2);
  EXPECT_EQ(fake.get(2, family.homing), -77);
  EXPECT_EQ(fake.get(3, family.max_limit), 4095);
  EXPECT_EQ(work.restore(kept), 0) << "nothing is asked and nothing written where all is the same";
}

TEST_P(SettingUp, ABackupOfOtherServosIsRefusedWhole) {
  FakeBus fake(GetParam(), {1, 2, 3});
  Commissioning work = setup(fake);
  work.find();
  const fs::path kept = work.back_up();
  fake.set(1, family.max_limit, 100);
  fake.set(2, family.model, 55);
  EXPECT_THROW(work.restore(kept), Error);
  EXPECT_EQ(fake.get(1, family.max_limit), 100) << "all or nothing";
}

}  // namespace
}  // namespace polyarm::test
