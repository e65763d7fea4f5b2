#pragma once
/// What every fault must end in, the same for each maker: the cause is named, the robot stands, nothing moves
/// it again, and a recovery does not jump. `Rig` is a WireRig. `mend(far)` is what a person does at the
/// controller.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>
#include <span>
#include <string>
#include <thread>

#include "drivers/wire/tcp.hpp"
#include "tests/support/wire_rig.hpp"

namespace polyarm::test {

/// How a test moves a joint: `before` cycles, then `after` more at most, with the fault.
struct FaultMotion {
  const char* joint;
  double step = 0.0015;  ///< rad for each cycle
  int ramp = 80;         ///< cycles
  int before = 120, after = 40;
  int patience = 3000;  ///< cycles until the fault is noticed
};

template <class Rig, class Row>
void expect_named(Rig& rig, const Row& row) {
  const std::string said = rig.component.reason();
  EXPECT_EQ(rig.component.cause(), row.cause) << said;
  EXPECT_NE(said.find(row.words), std::string::npos) << said;
  std::string device = "127.0.0.1";
  if constexpr (requires { rig.device(); }) device = rig.device();
  EXPECT_NE(said.find(device), std::string::npos) << "names the device: " << said;
}

template <class Rig, class Row, class Mend>
void expect_fault_while_moving(Rig& rig, const Row& row, const FaultMotion& motion, Mend mend) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const std::string joint = std::string(motion.joint) + "/position";
  const double from = rig.command(joint);
  int n = 0;
  const auto move = [&](int) { rig.command(joint) = from + travel(++n, motion.step, motion.ramp); };
  ASSERT_TRUE(rig.runs(motion.before, move)) << rig.component.reason();
  rig.far().order(row.order);
  ASSERT_TRUE(rig.fails(motion.patience, [&](int i) {
    if (i < motion.after) move(i);
  }));
  expect_named(rig, row);
  expect_standing(rig);
  mend(rig.far());
  expect_standing(rig);  // what was mended moves nothing

  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  EXPECT_EQ(static_cast<int>(rig.component.cause()), 0);
  expect_standing(rig);  // nor does a new connection
  const auto before = rig.q();
  rig.forget_jumps();
  ASSERT_TRUE(rig.activate()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(50, [](int) {}));
  EXPECT_LE(rig.largest_jump(), 1e-6) << "the first command is the measured position";
  for (std::size_t j = 0; j < before.size(); ++j) EXPECT_NEAR(rig.q()[j], before[j], 1e-6);
}

/// `comes_back`: what was mended can be started here.
template <class Rig, class Row, class Mend>
void expect_fault_before_motion(Rig& rig, const Row& row, Mend mend, bool comes_back = true) {
  const auto before = rig.q();
  rig.far().order(row.order);
  ASSERT_FALSE(rig.start());
  expect_named(rig, row);
  rig.component.on_cleanup();
  mend(rig.far());
  if (comes_back) {
    ASSERT_TRUE(rig.start()) << rig.component.reason();
    ASSERT_TRUE(rig.runs(5, [](int) {}));
    rig.component.on_cleanup();
  }
  const auto after = rig.q();
  for (std::size_t j = 0; j < before.size(); ++j) EXPECT_NEAR(after[j], before[j], 1e-6) << "joint " << j;
}

/// `fifth`: the name of joint 5.
template <class Rig, class Cause>
void expect_no_jump_is_sent(Rig& rig, const std::string& fifth, Cause jump, int cycles = 20) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  ASSERT_TRUE(rig.runs(cycles, [](int) {}));
  rig.command(fifth + "/position") += 0.3;
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), jump);
  EXPECT_NE(rig.component.reason().find("joint 5"), std::string::npos) << rig.component.reason();
  expect_standing(rig);
  EXPECT_LE(rig.largest_jump(), 1e-6);
}

template <class Rig, class Cause>
void expect_no_far_begin_is_sent(Rig& rig, const std::string& second, Cause jump) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  rig.command(second + "/position") += 0.02;  // less than a step, more than a measurement
  ASSERT_TRUE(rig.fails(5, [](int) {}));
  EXPECT_EQ(rig.component.cause(), jump);
}

/// With a `loop_silence_ms` of some 300; the controller's clock stands still meanwhile.
template <class Rig, class Cause>
void expect_silent_loop_is_braked(Rig& rig, Cause loop_silent) {
  ASSERT_TRUE(rig.start()) << rig.component.reason();
  const auto well = [&] { return static_cast<int>(rig.component.cause()) == 0; };
  for (int i = 0; i < 3 && well(); ++i) rig.cycle_once();
  while (well()) std::this_thread::yield();  // it takes what it takes
  EXPECT_EQ(rig.component.cause(), loop_silent) << rig.component.reason();
  rig.component.on_error();
  expect_standing(rig);
}

/// `refuse` and `allow` are orders to the far side.
template <class Rig>
void expect_refused_activation_keeps_reading(Rig& rig, const char* refuse, const char* allow) {
  ASSERT_TRUE(rig.configure()) << rig.component.reason();
  rig.far().order(refuse);
  EXPECT_FALSE(rig.activate());
  EXPECT_EQ(rig.read(), ReturnType::ok) << "it is inactive, not broken";
  rig.far().order(allow);
  EXPECT_TRUE(rig.activate()) << rig.component.reason();
}

/// Drives that are off are switched on by activating; or not, with `parameter` false; or the controller
/// refuses.
template <class Rig, class Cause>
void expect_drives_are_switched_on(const char* off_order, const char* refuse_order, const char* parameter,
                                   Cause off_cause, Cause refused_cause) {
  Rig on;
  on.far().order(off_order);
  EXPECT_TRUE(on.start()) << on.component.reason();
  Rig off(Parameters{{parameter, "false"}});
  off.far().order(off_order);
  EXPECT_FALSE(off.start());
  EXPECT_EQ(off.component.cause(), off_cause);
  Rig refused;
  refused.far().order(off_order);
  refused.far().order(refuse_order);
  EXPECT_FALSE(refused.start());
  EXPECT_EQ(refused.component.cause(), refused_cause) << refused.component.reason();
}

/// Each cause up to `last` has a name and a sentence of its own, which names the device and says what to do.
template <class Cause, class Sentence, class Name>
void expect_words_for_every_cause(Cause last, Sentence sentence, Name name, std::size_t least) {
  std::set<std::string> seen, names;
  for (int i = 1; i <= static_cast<int>(last); ++i) {
    const std::string text = sentence(static_cast<Cause>(i), 2, "the controller at 10.0.0.1", "x");
    EXPECT_NE(text.find("10.0.0.1"), std::string::npos) << text;
    EXPECT_NE(text.find_first_of(":;,"), std::string::npos) << text;
    EXPECT_TRUE(seen.insert(text).second) << text;
    EXPECT_TRUE(names.insert(name(static_cast<Cause>(i))).second) << i;
  }
  EXPECT_GE(seen.size(), least);
}

/// Rounds of a test with random faults: POLYARM_FAULT_ROUNDS, or the usual number.
inline int fault_rounds(int usual) {
  const char* const asked = std::getenv("POLYARM_FAULT_ROUNDS");
  return asked ? std::atoi(asked) : usual;
}

/// Faults drawn at random, in every state. `motion.after`: cycles with a fault. `most_jump`: rad.
/// `step(machine)` is a cycle of the controller; it stands after `rest` of them. POLYARM_FAULT_ROUNDS: more
/// rounds than 20.
template <class Rig, class Mend, class Step>
void expect_random_faults_end_well(Rig& rig, std::span<const char* const> orders, const FaultMotion& motion,
                                   double most_jump, Mend mend, Step step, int rest = 200) {
  const int rounds = fault_rounds(20);
  const std::string joint = std::string(motion.joint) + "/position";
  Draw draw(27);
  int named = 0;
  for (int round = 0; round < rounds; ++round) {
    const std::string order = orders[draw(static_cast<std::uint32_t>(orders.size()))];
    rig.forget_jumps();
    const bool early = draw(4) == 0;
    if (early) rig.far().order(order);
    if (rig.start()) {
      const double from = rig.command(joint);
      const double way = draw(2) ? motion.step : -motion.step;
      const auto move = [&](int i) {
        rig.command(joint) = from + travel(std::min(i, 200), way, motion.ramp);
      };
      const int before = static_cast<int>(draw(60));
      bool alive = true;
      int i = 0;
      for (; alive && i < before; ++i) move(i), alive = rig.cycle_once() == ReturnType::ok;
      if (alive && !early) rig.far().order(order);
      for (int k = 0; alive && k < motion.after; ++k, ++i)
        move(i), alive = rig.cycle_once() == ReturnType::ok;
    }
    if (static_cast<int>(rig.component.cause()) != 0) {
      ++named;
      ASSERT_GT(rig.component.reason().size(), 30u) << round << " " << order;
    }
    ASSERT_LE(rig.largest_jump(), most_jump) << round << " " << order;
    rig.component.on_error();
    mend(rig.far());
    rig.far().with([&](auto& machine) {
      for (int k = 0; k < rest; ++k) step(machine);
      const auto at = machine.q();
      for (int k = 0; k < 50; ++k) step(machine);
      EXPECT_EQ(machine.q(), at) << round << " " << order;
      return 0;
    });
  }
  EXPECT_GT(named, rounds / 2);
}

/// A TCP port of this machine at which nothing listens.
inline int closed_port() {
  std::string why;
  const Descriptor closing = wire::listen_tcp("127.0.0.1", 0, why);
  return wire::local_port(closing.number());
}

template <class Component, class Cause>
void expect_unreachable(const hardware::ComponentContext& context, Cause unreachable,
                        const std::string& words) {
  Component component;
  component.on_init(context);
  EXPECT_EQ(component.on_configure(), CallbackReturn::failure);
  EXPECT_EQ(component.cause(), unreachable);
  EXPECT_NE(component.reason().find("127.0.0.1"), std::string::npos) << component.reason();
  EXPECT_NE(component.reason().find(words), std::string::npos) << component.reason();
}

}  // namespace polyarm::test
