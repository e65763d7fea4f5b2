/// The bytes of each wire: golden frames, places of fields, damaged and split ones.
#include <random>

#include "tests/franka/rig.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm {
namespace {

using namespace franka;

constexpr int kVersions[] = {5, 6, 7, 8, 9, 10};

std::string text_of(const Data& bytes) {
  return {bytes.begin(), bytes.end()};
}
Data bytes_of(const std::string& text) {
  return {text.begin(), text.end()};
}
std::string hex(Bytes bytes) {
  std::string out;
  for (const std::uint8_t byte : bytes) {
    constexpr const char* kDigits = "0123456789abcdef";
    out += kDigits[byte >> 4];
    out += kDigits[byte & 15];
  }
  return out;
}

RobotState some_state() {
  RobotState out;
  out.id = 0x0102030405060708;
  for (std::size_t i = 0; i < 7; ++i) {
    out.q[i] = 0.5 + static_cast<double>(i);
    out.q_d[i] = 0.25 - static_cast<double>(i);
    out.tau_ext[i] = -2.0;
    out.dq[i] = 0.125;
  }
  out.O_T_EE[12] = 0.5, out.O_T_EE[15] = 1;
  out.load.mass = 1.5;
  out.O_F_ext[2] = -8;
  out.K_F_ext[0] = 16;
  out.generator = Generator::joint_velocity;
  out.controller = Controller::cartesian_impedance;
  out.errors.set(6);
  out.reflex.set(40);
  out.mode = RobotMode::reflex;
  out.success_rate = 0.75;
  return out;
}

TEST(FciFrames, AreThoseOfTheMakersLibrary) {
  EXPECT_EQ(hex(encode(Frame{0, 7, {9, 0, 0x39, 0x30}})), "00000000070000001000000009003930") << "Connect";
  const Data move =
      encode(MoveRequest{Controller::joint_impedance, Generator::joint_velocity, {1, 0, 0}, {}}, 5);
  EXPECT_EQ(move.size(), 56u);
  EXPECT_EQ(hex(Bytes(move).first(16)), "0000000001000000000000000000f03f") << "generators count from 0 here";
  EXPECT_EQ(encode(MoveRequest{}, 9).size(), 56u);
  EXPECT_EQ(encode(MoveRequest{}, 10).size(), 113u) << "with the limits of an asynchronous motion";
  EXPECT_EQ(encode(CollisionBehavior{}).size(), 416u);
  EXPECT_EQ(encode(Load{}).size(), 104u);
}

TEST(FciFrames, RequestsHaveTheNumbersOfTheirVersion) {
  EXPECT_EQ(number_of(Request::set_collision_behavior, 5), 4u);
  EXPECT_EQ(number_of(Request::set_collision_behavior, 6), 3u);
  EXPECT_EQ(number_of(Request::recover, 5), 12u);
  EXPECT_EQ(number_of(Request::recover, 9), 10u);
  EXPECT_EQ(number_of(Request::set_filters, 6), std::nullopt);
  EXPECT_EQ(number_of(Request::get_robot_model, 7), std::nullopt);
  EXPECT_EQ(number_of(Request::get_robot_model, 8), 12u);
  EXPECT_EQ(number_of(Request::get_robot_model, 10), 11u);
  EXPECT_EQ(number_of(Request::load_model_library, 10), std::nullopt);
  for (const int version : kVersions)
    for (int i = 0; i <= static_cast<int>(Request::get_robot_model); ++i) {
      const auto request = static_cast<Request>(i);
      const auto number = number_of(request, version);
      if (number) {
        EXPECT_EQ(request_of(*number, version), request) << version << " " << name(request);
      }
      EXPECT_FALSE(request_of(14, version));
    }
}

TEST(FciFrames, StatusesHaveTheNumbersOfTheirVersion) {
  EXPECT_EQ(byte_of(Status::reflex, Request::move, 5), 6);
  EXPECT_EQ(byte_of(Status::reflex, Request::move, 9), 8);
  EXPECT_EQ(byte_of(Status::user_stop, Request::recover, 5), 4);
  EXPECT_EQ(byte_of(Status::user_stop, Request::recover, 9), 5);
  EXPECT_EQ(status_of(3, Request::set_load, 9), Status::refused_by_safety);
  EXPECT_EQ(status_of(3, Request::set_load, 5), Status::unknown);
  EXPECT_EQ(status_of(200, Request::move, 9), Status::unknown);
  for (const int version : kVersions)
    for (const Request request : {Request::move, Request::stop_move, Request::recover, Request::set_load})
      for (std::uint8_t byte = 0; byte < 12; ++byte)
        if (const Status status = status_of(byte, request, version); status != Status::unknown) {
          EXPECT_EQ(byte_of(status, request, version), byte) << version << " " << name(request);
        }
}

class Versions : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Fci, Versions, testing::ValuesIn(kVersions));

/// Offsets as a compiler gives them for the maker's structures.
TEST_P(Versions, StatesHaveTheirFieldsInTheirPlaces) {
  const int version = GetParam();
  const bool single = version == 10;
  const Data bytes = encode(some_state(), version);
  ASSERT_EQ(bytes.size(), single ? 1377u : 2373u);
  EXPECT_EQ(hex(Bytes(bytes).first(8)), "0807060504030201");
  const std::size_t q = single ? 596 : 1184, torque = single ? 840 : 1672, force = single ? 868 : 1728;
  const std::size_t modes = single ? 1288 : 2280;
  EXPECT_EQ(hex(Bytes(bytes).subspan(q, 4)), single ? "0000003f" : "00000000");
  EXPECT_EQ(hex(Bytes(bytes).subspan(q + (single ? 0 : 4), 4)), single ? "0000003f" : "0000e03f");
  EXPECT_EQ(hex(Bytes(bytes).subspan(torque, single ? 4 : 8)), single ? "000000c0" : "00000000000000c0");
  EXPECT_EQ(hex(Bytes(bytes).subspan(force + 2 * (single ? 4 : 8), single ? 4 : 8)),
            single ? "000000c1" : "00000000000020c0");
  EXPECT_EQ(hex(Bytes(bytes).subspan(modes, 2)), "0201") << "velocity, Cartesian impedance";
  EXPECT_EQ(bytes[modes + 2 + 6], 1) << "joint_reflex";
  EXPECT_EQ(bytes[modes + 2 + 41 + 40], 1);
  EXPECT_EQ(bytes[modes + 84], 4) << "reflex";
  EXPECT_EQ(hex(Bytes(bytes).subspan(modes + 85)), single ? "0000403f" : "000000000000e83f");
}

TEST_P(Versions, StatesComeBackFromTheirBytes) {
  const int version = GetParam();
  const RobotState in = some_state();
  const auto out = decode_state(encode(in, version), version);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->id, in.id);
  EXPECT_EQ(out->q, in.q);
  EXPECT_EQ(out->q_d, in.q_d);
  EXPECT_EQ(out->dq, in.dq);
  EXPECT_EQ(out->tau_ext, in.tau_ext);
  EXPECT_EQ(out->O_F_ext, in.O_F_ext);
  EXPECT_EQ(out->K_F_ext, in.K_F_ext);
  EXPECT_EQ(out->O_T_EE, in.O_T_EE);
  EXPECT_EQ(out->load.mass, 1.5);
  EXPECT_EQ(out->errors, in.errors);
  EXPECT_EQ(out->reflex, in.reflex);
  EXPECT_EQ(out->mode, in.mode);
  EXPECT_EQ(out->success_rate, 0.75);
}

TEST_P(Versions, CommandsHaveTheirFieldsInTheirPlaces) {
  const int version = GetParam();
  RobotCommand command;
  command.id = 258;
  command.q[0] = 1, command.dq[6] = 2, command.finished = true;
  std::array<std::uint8_t, kMostCommand> bytes;
  encode(command, version, bytes);
  ASSERT_EQ(command_bytes(version), version >= 7 ? 371u : 370u);
  EXPECT_EQ(hex(Bytes(bytes).first(16)), "0201000000000000000000000000f03f");
  EXPECT_EQ(hex(Bytes(bytes).subspan(64 + 48, 8)), "0000000000000040");
  EXPECT_EQ(bytes[312], 0) << "no elbow";
  EXPECT_EQ(bytes[313], 1);
  const auto out = decode_command(Bytes(bytes).first(command_bytes(version)), version);
  ASSERT_TRUE(out);
  EXPECT_EQ(out->q, command.q);
  EXPECT_EQ(out->dq, command.dq);
  EXPECT_TRUE(out->finished);
  EXPECT_FALSE(decode_command(Bytes(bytes).first(300), version));
}

TEST_P(Versions, StatesThatNoRobotSendsAreRefused) {
  const int version = GetParam();
  RobotState state = some_state();
  state.q[3] = std::nan("");
  EXPECT_FALSE(decode_state(encode(state, version), version));
  state = some_state();
  state.tau_ext[1] = INFINITY;
  EXPECT_TRUE(decode_state(encode(state, version), version)) << "an estimate ends no motion";
  Data bytes = encode(some_state(), version);
  bytes[bytes.size() - (version == 10 ? 5 : 9)] = 7;
  EXPECT_FALSE(decode_state(bytes, version)) << "mode 7";
  bytes = encode(some_state(), version);
  bytes.pop_back();
  EXPECT_FALSE(decode_state(bytes, version));
}

TEST(FciFrames, SplitAtEveryByteTheyAreTheSame) {
  Data all = encode(Frame{1, 3, {1}});
  for (const Data& more : {encode(Frame{10, 4, {0}}), encode(Frame{0, 5, {0, 9, 0}})})
    all.insert(all.end(), more.begin(), more.end());
  for (std::size_t at = 0; at <= all.size(); ++at) {
    FrameReader reader;
    std::vector<Frame> got;
    for (const Bytes part : {Bytes(all).first(at), Bytes(all).subspan(at)}) {
      ASSERT_TRUE(reader.feed(part));
      while (auto frame = reader.next()) got.push_back(*frame);
    }
    ASSERT_EQ(got.size(), 3u) << at;
    EXPECT_EQ(got[1].command, 10u);
    EXPECT_EQ(got[2].data, (Data{0, 9, 0}));
  }
}

TEST(FciFrames, ALengthThatNoFrameHasEndsTheConnection) {
  for (const Data& start :
       {Data{0, 0, 0, 0, 0, 0, 0, 0, 11, 0, 0, 0}, Data{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}}) {
    FrameReader reader;
    EXPECT_FALSE(reader.feed(start));
    EXPECT_FALSE(reader.next());
    EXPECT_FALSE(reader.feed(start)) << "for good";
  }
}

TEST(HandFrames, AreThoseOfTheMakersLibrary) {
  HandState state;
  state.id = 258;
  state.width = 0.5, state.max_width = 1, state.grasped = true, state.temperature = 31;
  EXPECT_EQ(hex(encode(state)),
            "02010000"
            "000000000000e03f"
            "000000000000f03f"
            "01"
            "1f00");
  EXPECT_EQ(decode_hand_state(encode(state))->temperature, 31);
  state.width = std::nan("");
  EXPECT_FALSE(decode_hand_state(encode(state)));
  HandOrder grasp{HandRequest::grasp, 1, 2, 4, 0.5, 0.25};
  EXPECT_EQ(hex(encode(grasp)),
            "000000000000f03f"
            "000000000000e03f"
            "000000000000d03f"
            "0000000000000040"
            "0000000000001040");
  EXPECT_EQ(decode_hand_order(2, encode(grasp))->force, 4);
  EXPECT_FALSE(decode_hand_order(3, encode(grasp)));
  EXPECT_FALSE(decode_hand_order(1, Data{1}));
  EXPECT_FALSE(decode_hand_order(5, {}));
}

TEST(FciFrames, DamagedOnesAreReadOrRefused) {
  std::mt19937 random(27);
  std::string whole;
  for (const Data& one : {encode(Frame{0, 1, {9, 0, 1, 2}}), encode(Frame{1, 2, encode(MoveRequest{}, 9)}),
                          encode(Frame{9, 3, encode(Load{})})})
    whole += text_of(one);
  std::size_t frames = 0, moves = 0;
  for (int i = 0; i < 100'000; ++i) {
    const Data bytes =
        bytes_of(test::damaged(whole, {std::string(4, '\0'), "\xff\xff", std::string(1, '\1')}, 16, random));
    FrameReader reader(i % 2 ? kFciHead : kHandHead);
    reader.feed(bytes);
    while (const auto frame = reader.next()) {
      ++frames;
      ASSERT_LE(frame->data.size(), kMostFrame);
      moves += decode_move(frame->data, 5 + i % 6).has_value();
      decode_load(frame->data);
      decode_collision(frame->data);
      decode_hand_order(frame->command, frame->data);
    }
  }
  EXPECT_GT(frames, 50'000u);
  EXPECT_GT(moves, 1'000u);
}

TEST(FciDatagrams, DamagedOnesAreReadOrRefused) {
  std::mt19937 random(28);
  std::size_t states = 0, commands = 0;
  std::array<std::uint8_t, kMostCommand> command;
  encode(RobotCommand{}, 9, command);
  for (int i = 0; i < 100'000; ++i) {
    const int version = kVersions[i % 6];
    static const Data five = encode(some_state(), 5), ten = encode(some_state(), 10);
    Data bytes = version == 10 ? ten : five;
    for (std::uint32_t n = 1 + random() % 4; n > 0; --n)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) bytes.resize(random() % (bytes.size() + 1));
    if (const auto state = decode_state(bytes, version)) {
      ++states;
      for (const double q : state->q) ASSERT_TRUE(std::isfinite(q));
      ASSERT_LE(static_cast<int>(state->mode), 6);
    }
    Data order(command.begin(), command.begin() + static_cast<std::ptrdiff_t>(command_bytes(version)));
    order[random() % order.size()] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) order.resize(random() % order.size());
    commands += decode_command(order, version).has_value();
  }
  EXPECT_GT(states, 50'000u);
  EXPECT_GT(commands, 50'000u);
}

TEST(HandDatagrams, DamagedOnesAreReadOrRefused) {
  std::mt19937 random(29);
  std::size_t states = 0;
  const std::string whole = text_of(encode(HandState{7, 0.04, 0.08, true, 30}));
  for (int i = 0; i < 100'000; ++i)
    if (const auto state = decode_hand_state(bytes_of(test::damaged(whole, {"\xff"}, 3, random)))) {
      ++states;
      ASSERT_TRUE(std::isfinite(state->width));
    }
  EXPECT_GT(states, 1'000u);
}

/// Requests and commands at random: the simulated robot stays within its own limits.
TEST(Machine, TakesRandomRequestsAndCommands) {
  std::mt19937 random(30);
  franka::Machine machine(test::far_options().machine);
  std::size_t started = 0;
  for (int i = 0; i < 60'000; ++i) {
    const auto request = static_cast<Request>(random() % 15);
    Data data(random() % 3 == 0 ? random() % 120 : 0);
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random());
    if (request == Request::move && random() % 2 == 0) data = encode(MoveRequest{}, machine.version());
    started += machine.answer(request, data, static_cast<std::uint32_t>(i)).status == Status::started;
    RobotCommand command;
    command.id = machine.id() - random() % 2;
    for (double& one : command.q) one = static_cast<double>(random()) / 1e9 - 2;
    machine.take(command);
    machine.step();
    machine.take_end();
    for (const double q : machine.q()) ASSERT_TRUE(std::isfinite(q));
  }
  EXPECT_GT(started, 100u);
  EXPECT_LE(machine.largest_jump(), 6 * 0.001 * 57.3);
}

TEST(Poses, OfMatricesHaveTheirRotation) {
  std::mt19937 random(31);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    const Quaternion q =
        normalized(Quaternion{normal(random), normal(random), normal(random), i % 5 ? normal(random) : 0});
    Matrix4 m{};
    const Vec3 axes[3] = {q * Vec3{1, 0, 0}, q * Vec3{0, 1, 0}, q * Vec3{0, 0, 1}};
    for (std::size_t c = 0; c < 3; ++c)
      m[4 * c] = axes[c].x, m[4 * c + 1] = axes[c].y, m[4 * c + 2] = axes[c].z;
    const auto pose = pose_of(m);
    EXPECT_LT(angle_between(q, Quaternion{pose[3], pose[4], pose[5], pose[6]}), 1e-6) << i;
  }
}

}  // namespace
}  // namespace polyarm
