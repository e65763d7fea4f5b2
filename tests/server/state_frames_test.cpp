#include "polyarm/server/state_frames.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "polyarm/server/events.hpp"
#include "polyarm/setup/cell_file.hpp"
#include "tests/support/jetbot_cell.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::server {
namespace {

using test::Folder;
using test::Json;
using test::LockStepCell;

double value(const StateFrames& frames, const Text& frame, const std::string& field) {
  const Json layout = Json::parse(*frames.layout());
  for (std::size_t i = 0; i < layout["fields"].size(); ++i) {
    if (layout["fields"][i]["name"] != field) continue;
    float out;
    std::memcpy(&out, frame->data() + 16 + 4 * i, sizeof out);
    return out;
  }
  ADD_FAILURE() << field << " is not among " << layout["fields"];
  return 0;
}

TEST(StateFrames, ABaseThatDrivesIsInEachFrameAndInTheStatus) {
  Folder folder;
  test::write_jetbot_cell(folder, "drive 500mm\n", "jetbot_body.urdf.xacro", "xyz: [0, 2, 0]");
  LockStepCell bench(cell::read_cell_file(folder.path()));
  test::OpenCell& cell = bench.cell();
  cell::Observer nobody;
  const Journal journal(nobody);
  StateFrames frames(cell.view(), 1);
  EXPECT_NEAR(value(frames, frames.frame(), "jetbot/base/position.y"), 2, 1e-6);
  EXPECT_EQ(status_of(cell.view(), journal).bases.at("jetbot").p, Vec3(0, 2, 0));
  while (!cell.program()->ended() && cell.now() < nanoseconds(60)) bench.tick();
  bench.run(0.1);
  const Text frame = frames.frame();
  EXPECT_NEAR(value(frames, frame, "jetbot/base/position.x"), 0.5, 0.005);
  EXPECT_NEAR(value(frames, frame, "jetbot/base/position.y"), 2, 0.005);
  EXPECT_NEAR(value(frames, frame, "jetbot/base/orientation.w"), 1, 1e-3);
  EXPECT_NEAR(status_of(cell.view(), journal).bases.at("jetbot").p.x, 0.5, 0.005);
}

TEST(StateFrames, ABaseThatIsFixedCostsNone) {
  LockStepCell bench(std::filesystem::path(POLYARM_SOURCE_DIR) / "examples/r6bot/r6bot.urdf", std::string());
  const StateFrames frames(bench.cell().view(), 1);
  EXPECT_EQ(frames.layout()->find("/base/"), std::string::npos);
}

}  // namespace
}  // namespace polyarm::server
