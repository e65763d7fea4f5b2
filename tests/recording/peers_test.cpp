/// Recordings and the live view as readers and clients of others see them. These come from npm; where it is
/// missing, or reaches no registry at the first time, the tests say so and are skipped.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "polyarm/base/file.hpp"
#include "tests/recording/demo.hpp"
#include "tests/support/node_peers.hpp"

namespace polyarm::recording {
namespace {

namespace fs = std::filesystem;
using test::Json;
using test::McapFile;
using test::node;
using test::peers;

TEST(Recording, ReadersOfOthersReadIt) {
  std::string why;
  const fs::path folder = peers(why);
  if (folder.empty()) GTEST_SKIP() << why;
  test::Demo demo;
  const McapFile ours = McapFile::read(demo.record(3, 100));
  const Json said = node(folder, "check.mjs '" + (demo.folder.path() / "demo.mcap").string() + "'");
  EXPECT_EQ(said["done"], true);
  EXPECT_EQ(said["left"], 0);
  EXPECT_EQ(said["profile"], "ros2");
  for (const char* good : {"ordered", "reversed", "sought", "by_topic"}) EXPECT_EQ(said[good], true) << good;
  EXPECT_EQ(said["messages"], ours.messages.size());
  EXPECT_EQ(said["messages"], said["statistics"]);
  EXPECT_EQ(said["messages"], said["indexed"]);
  EXPECT_GT(said["description"].get<int>(), 1000);
  EXPECT_EQ(said["attachments"]["demo.script"], fs::file_size(demo.folder.path() / "demo.script"));
  for (const auto& [topic, channel] : ours.channels)
    EXPECT_EQ(said["topics"].value(topic, 0u), ours.of(topic).size()) << topic;
  // The last row is within the last 10 ms of the run, and the robot stands.
  const std::vector<double> last = said["last_joints"][1];
  EXPECT_EQ(said["joint_names"], Json(demo.joints));
  ASSERT_EQ(last.size(), demo.measured.size());
  for (std::size_t j = 0; j < last.size(); ++j)
    EXPECT_NEAR(last[j], demo.measured[j], 1e-9) << demo.joints[j];
}

/// A process that records on the wall clock until it is killed.
class RecordingProcess {
 public:
  RecordingProcess(const test::Demo& demo, const fs::path& file) : pid_(::fork()) {
    if (pid_ != 0) return;
    test::LockStepCell bench("controller_manager: {ros__parameters: {update_rate: 1000}}\n", true);
    bench.cell().set_recorder(make_recorder(bench.cell().view(), "9.9"));
    bench.cell().recorder()->start({file, 1000});
    for (;; ::usleep(1000)) bench.tick();
  }
  ~RecordingProcess() { kill(); }
  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_;
};

TEST(Recording, OfAProcessThatWasKilledIsReadableUpToItsLastSecond) {
  test::Demo demo;
  const fs::path file = demo.folder.path() / "killed.mcap";
  std::size_t messages = 0;
  {
    RecordingProcess process(demo, file);
    for (int i = 0; i < 10'000 && messages == 0; ++i, ::usleep(10'000)) {
      std::error_code error;
      if (!fs::exists(file, error)) continue;
      const McapFile seen = McapFile::read(read_file(file));
      if (seen.chunks >= 2) messages = seen.messages.size();
    }
  }
  ASSERT_GT(messages, 0u) << "a second after its beginning there is a chunk";
  const McapFile left = McapFile::read(read_file(file));
  EXPECT_FALSE(left.whole);
  EXPECT_GE(left.messages.size(), messages);
  EXPECT_EQ(left.of("/robot_description").size(), 1u);
  std::string why;
  const fs::path folder = peers(why);
  if (folder.empty()) GTEST_SKIP() << why;
  const Json said = node(folder, "check.mjs '" + file.string() + "'");
  EXPECT_EQ(said["done"], false);
  EXPECT_EQ(said["messages"], left.messages.size());
}

}  // namespace
}  // namespace polyarm::recording
