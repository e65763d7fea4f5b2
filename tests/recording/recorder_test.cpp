#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <thread>

#include "polyarm/messages/json.hpp"
#include "polyarm/recording/cell_channels.hpp"
#include "polyarm/recording/cell_recorder.hpp"
#include "tests/recording/demo.hpp"
#include "tests/support/jetbot_cell.hpp"

namespace polyarm::recording {
namespace {

using test::decoded;
using test::Demo;
using test::Json;
using test::McapFile;
using test::McapMessage;

TEST(Recorder, AFileSaysWhatTheCellDid) {
  Demo demo;
  const McapFile file = McapFile::read(demo.record(3, 100));
  ASSERT_TRUE(file.whole);
  EXPECT_FALSE(demo.status.recording);
  EXPECT_EQ(demo.status.messages, file.messages.size());
  EXPECT_EQ(demo.status.lost, 0u);

  const auto joints = file.of("/joint_states");
  ASSERT_NEAR(static_cast<double>(joints.size()), 300, 2);
  for (std::size_t i = 1; i < joints.size(); ++i)
    EXPECT_EQ(joints[i]->time - joints[i - 1]->time, 10'000'000u);
  const Json first = decoded(*joints.front()), last = decoded(*joints.back());
  EXPECT_EQ(last["name"][0], "joint_1");
  EXPECT_NEAR(last["position"][0].get<double>(), 0.4, 1e-3);
  EXPECT_LT(std::abs(first["position"][0].get<double>()), 0.05);

  EXPECT_EQ(file.of("/tf").size(), joints.size());
  EXPECT_EQ(file.of("/joint_commands").size(), joints.size());
  EXPECT_EQ(file.of("/tcp").size(), joints.size());
  EXPECT_EQ(file.of("/loop").size(), joints.size());
  ASSERT_EQ(file.of("/tf_static").size(), 1u);
  ASSERT_EQ(file.of("/robot_description").size(), 1u);
  EXPECT_NE(decoded(*file.of("/robot_description")[0])["data"].get<std::string>().find("<robot"),
            std::string::npos);
  EXPECT_FALSE(decoded(*file.of("/loop")[0]).contains("cost_us")) << "it would differ from run to run";
}

TEST(Recorder, ABaseThatDrivesIsInTheWorldByWayOfItsOdometry) {
  test::Folder folder;
  test::write_jetbot_cell(folder, "drive 500mm\n", "jetbot_body.urdf.xacro", "xyz: [1, 2, 0]");
  std::string bytes;
  {
    test::LockStepCell bench(cell::read_cell_file(folder.path()));
    bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
    bench.cell().recorder()->start({folder.path() / "drive.mcap", 100});
    bench.run(5);
    bench.cell().recorder()->stop();
    bytes = read_file(folder.path() / "drive.mcap");
  }
  const McapFile file = McapFile::read(bytes);
  const Json fixed = decoded(*file.of("/tf_static").front());
  for (const Json& each : fixed["transforms"])
    EXPECT_NE(each["child_frame_id"], "base_footprint") << "a frame has one parent";
  double x = 0;
  int told = 0;
  std::uint64_t latest = 0;
  for (const McapMessage* message : file.of("/tf")) {
    const Json frames = decoded(*message);
    if (frames["transforms"].empty() || frames["transforms"][0]["header"]["frame_id"] != "world") continue;
    ASSERT_EQ(frames["transforms"].size(), 2u);
    const Json &odometry = frames["transforms"][0], &base = frames["transforms"][1];
    EXPECT_EQ(odometry["child_frame_id"], "odom");
    EXPECT_EQ(base["header"]["frame_id"], "odom");
    EXPECT_EQ(base["child_frame_id"], "base_footprint");
    EXPECT_NEAR(odometry["transform"]["translation"]["x"].get<double>(), 1, 1e-9);
    EXPECT_NEAR(odometry["transform"]["translation"]["y"].get<double>(), 2, 1e-9);
    x = base["transform"]["translation"]["x"];
    if (++told > 1) {
      EXPECT_EQ(message->time - latest, 20'000'000u);
    }
    latest = message->time;
  }
  EXPECT_NEAR(told, 250, 3);
  EXPECT_NEAR(x, 0.5, 0.005);
  EXPECT_EQ(decoded(*file.of("/tcp").back())["header"]["frame_id"], "base_footprint");
}

TEST(Recorder, ATagIsAStepOfTwoMessagesAndIsSaidAgainEachSecond) {
  Demo demo;
  const McapFile file = McapFile::read(demo.record(3, 100));
  const auto lamp = file.of("/tags/Lamp");
  std::vector<std::pair<std::uint64_t, bool>> steps;
  std::uint64_t latest = 0;
  for (const McapMessage* message : lamp) {
    EXPECT_LE(message->time - latest, 1'010'000'000u) << "seeking finds a value within a second";
    latest = message->time;
    const bool value = decoded(*message)["data"];
    if (steps.empty() || steps.back().second != value) {
      if (!steps.empty()) {
        const auto& before = **(std::find(lamp.begin(), lamp.end(), message) - 1);
        EXPECT_LE(message->time - before.time, 1'000u) << "a plot shows an edge, not a ramp";
      }
      steps.emplace_back(message->time, value);
    }
  }
  ASSERT_EQ(steps.size(), 3u) << "off, on, off";
  EXPECT_NEAR(1e-9 * static_cast<double>(steps[2].first - steps[1].first), 0.3, 0.01);
  EXPECT_EQ(decoded(*file.of("/tags/Count").back())["data"], 4.0);
}

TEST(Recorder, PartsAreFramesWhileTheyAreInTheWorld) {
  Demo demo;
  demo.folder.write("scene.yaml",
                    "polyarm: scene/1\nparts:\n  cube: {box: [0.04, 0.04, 0.04], at: [0.5, 0.2, 0.02]}\n");
  demo.folder.write("cell.yaml", "polyarm: cell/1\nrobots:\n  arm: {model: " + Demo::robot() +
                                     ", hardware: mock}\nscene: scene.yaml\nsignals: signals.yaml\nprogram: "
                                     "demo.script\n");
  const McapFile file = McapFile::read(demo.record(2.5, 100));
  std::vector<Json> frames;
  for (const McapMessage* message : file.of("/tf")) {
    const Json all = decoded(*message);
    for (const Json& frame : all["transforms"])
      if (frame["child_frame_id"] == "part/cube") frames.push_back(frame);
  }
  ASSERT_GE(frames.size(), 3u) << "said again each second";
  EXPECT_LE(frames.size(), 20u) << "a part that lies is not told in each cycle";
  EXPECT_EQ(frames.back()["header"]["frame_id"], "world");
  EXPECT_NEAR(frames.back()["transform"]["translation"]["x"].get<double>(), 0.5, 1e-3);
  EXPECT_NEAR(frames.back()["transform"]["translation"]["y"].get<double>(), 0.2, 1e-3);
}

TEST(Recorder, LinesAndLogTellWhatTheProgramDid) {
  Demo demo;
  const McapFile file = McapFile::read(demo.record(3, 100));
  std::vector<int> lines;
  for (const McapMessage* message : file.of("/program")) lines.push_back(decoded(*message)["line"]);
  EXPECT_NE(std::find(lines.begin(), lines.end(), 5), lines.end()) << "it waited there";
  bool logged = false;
  for (const McapMessage* message : file.of("/rosout"))
    logged = logged || decoded(*message)["msg"] == "there";
  EXPECT_TRUE(logged);
}

TEST(Recorder, WhatTheCellIsMadeOfLiesInTheFile) {
  Demo demo;
  const McapFile file = McapFile::read(demo.record(0.1, 100));
  for (const char* name : {"cell.yaml", "signals.yaml", "demo.script"})
    EXPECT_EQ(file.attachments.at(name), read_file(demo.folder.path() / name)) << name;
  EXPECT_NE(file.attachments.at("arm.urdf").find("joint_1"), std::string::npos);
  EXPECT_EQ(file.metadata.at("polyarm.version"), "9.9");
  EXPECT_EQ(file.metadata.at("polyarm.clock"), "lock-step");
}

TEST(Recorder, TheSameRunGivesTheSameBytes) {
  Demo demo;
  const std::string first = demo.record(1.5, 1000, "a.mcap"), second = demo.record(1.5, 1000, "b.mcap");
  EXPECT_TRUE(first == second);
  EXPECT_GT(first.size(), 10'000u);
}

TEST(Recorder, EveryCycleIsThereWhereThatIsAskedFor) {
  Demo demo;
  const McapFile file = McapFile::read(demo.record(0.5, 1000));
  EXPECT_EQ(file.of("/joint_states").size(), 500u);
  const auto dynamic = file.of("/dynamic_joint_states");
  EXPECT_LE(dynamic.size(), 51u) << "a hundred times a second is enough for these";
  const Json last = decoded(*dynamic.back());
  EXPECT_EQ(last["joint_names"].size(), last["interface_values"].size());
}

TEST(Recorder, IsAskedForFromOutsideByTheNameOfAFileAlone) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  EXPECT_EQ(bench.ask({{"request", "record.start"}})["error"]["code"], "no-recorder");
  bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
  for (const char* bad : {"../out.mcap", "/tmp/out.mcap", "a/b.mcap", "..", "."})
    EXPECT_EQ(bench.ask({{"request", "record.start"}, {"file", bad}})["error"]["code"], "bad-argument")
        << bad;
  EXPECT_EQ(bench.ask({{"request", "record.start"}, {"rate", -1}})["error"]["code"], "bad-value");
  const Json begun = bench.result({{"request", "record.start"}, {"file", "by_hand"}});
  EXPECT_EQ(begun["recording"], true) << begun;
  EXPECT_EQ(bench.ask({{"request", "record.start"}})["error"]["code"], "recording");
  bench.run(0.2);
  const Json ended = bench.result({{"request", "record.stop"}});
  EXPECT_EQ(ended["recording"], false);
  const auto path = demo.folder.path() / ".state" / "recordings" / "by_hand.mcap";
  EXPECT_EQ(ended["file"], path.string());
  EXPECT_TRUE(McapFile::read(read_file(path)).whole);
  EXPECT_EQ(bench.result({{"request", "record.start"}})["recording"], true) << "and again, into a new file";
}

/// Files of this process end at `bytes`, as on a disk that is full there.
class ShortFiles {
 public:
  explicit ShortFiles(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~ShortFiles() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  ShortFiles(const ShortFiles&) = delete;
  ShortFiles& operator=(const ShortFiles&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(Recorder, AFullDiskEndsTheRecordingAndNotTheRun) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  struct Problems : cell::Observer {
    std::vector<std::string> told;
    void on_problem(Nanoseconds, const Problem& problem) override { told.push_back(problem.what); }
  } problems;
  bench.cell().add_observer(problems);
  bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
  {
    const ShortFiles full(4096);
    bench.cell().recorder()->start({demo.folder.path() / "full.mcap", 100});
    bench.run(3);
  }
  EXPECT_FALSE(bench.cell().failure());
  const std::string why = std::strerror(EFBIG);
  const auto said = std::count_if(problems.told.begin(), problems.told.end(), [&](const std::string& text) {
    return text.find(why) != std::string::npos;
  });
  EXPECT_EQ(said, 1);
  EXPECT_NE(bench.cell().recorder()->status().problem.find(why), std::string::npos);
  bench.cell().remove_observer(problems);
}

TEST(Recorder, WhatIsNoOrdinaryFileIsNotRecordedInto) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
  for (const char* path : {"/dev/null", "/tmp"}) try {
      bench.cell().recorder()->start({path, 100});
      FAIL() << path;
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "not-a-file") << e.what();
    }
}

TEST(Recorder, AFileThatCannotBeMadeIsRefusedWithItsName) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
  try {
    bench.cell().recorder()->start({"/proc/nowhere/run.mcap", 100});
    FAIL() << "it was made";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("/proc/nowhere/run.mcap"), std::string::npos);
  }
}

TEST(Recorder, OnTheWallClockAThreadOfItsOwnWritesAndTheFileGrowsWhileItRuns) {
  Demo demo;
  test::LockStepCell bench("controller_manager: {ros__parameters: {update_rate: 1000}}\n", true);
  const auto path = demo.folder.path() / "live.mcap";
  bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
  bench.cell().recorder()->start({path, 1000});
  // The thread ends a chunk by the system's clock: cycles go on until it has.
  for (int i = 0; i < 2'000'000 && McapFile::read(read_file(path)).chunks < 2; ++i)
    for (int k = 0; k < 20; ++k) bench.tick();
  const McapFile part = McapFile::read(read_file(path));
  EXPECT_GE(part.chunks, 2u);
  EXPECT_FALSE(part.whole);
  bench.cell().recorder()->stop();
  for (int i = 0; i < 2'000'000 && bench.cell().recorder()->status().recording; ++i) {
    bench.tick();
    std::this_thread::yield();
  }
  const McapFile file = McapFile::read(read_file(path));
  EXPECT_TRUE(file.whole);
  EXPECT_EQ(file.metadata.at("polyarm.clock"), "wall clock");
  EXPECT_GT(file.messages.front().time, 1'600'000'000'000'000'000u)
      << "times are those of the system's clock";
}

TEST(Channels, ArePrintedInTheirPage) {
  Demo demo;
  test::LockStepCell bench(demo.file());
  const std::string table = channel_reference(CellChannels(bench.cell().view(), 0).list());
  const std::string page = read_file(std::filesystem::path(POLYARM_SOURCE_DIR) / "docs/recording.md");
  EXPECT_NE(page.find(table), std::string::npos) << "docs/recording.md has to have this table:\n" << table;
}

}  // namespace
}  // namespace polyarm::recording
