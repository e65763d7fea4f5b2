/// What a recorded cycle costs: in the control thread, where it is put down for somebody else, and in the
/// recorder's, which makes messages of it, compresses and checks them. The arm of examples/r6bot, all
/// channels. The disk is left out, and so is what two threads do to each other's caches: late cycles while a
/// cell is recorded are told by `polyarm run --record`, beside those of an empty loop.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <filesystem>
#include <vector>

#include "drivers/mock/mock.hpp"
#include "polyarm/hardware/driver_loader.hpp"
#include "polyarm/recording/cell_channels.hpp"
#include "polyarm/recording/mcap_writer.hpp"
#include "tests/support/open_cell.hpp"

namespace polyarm {
namespace {

class Nowhere : public recording::ByteSink {
 public:
  bool write(std::span<const std::byte> bytes) override {
    size += bytes.size();
    return true;
  }
  std::size_t size = 0;
};

struct Arm {
  Arm() {
    hardware::register_driver(
        "mock", [] { return std::unique_ptr<hardware::Component>(new drivers::MockComponent); });
    cell::CellOptions options;
    options.lock_step = true;
    cell::Overrides overrides;
    overrides.hardware = "mock";
    cell = std::make_unique<test::OpenCell>(
        cell::cell_from_description(std::filesystem::path(POLYARM_SOURCE_DIR) / "examples/r6bot/r6bot.urdf",
                                    {}, overrides),
        description::Catalogue({}), options, nobody);
    const auto& table = cell->loop().table();
    states.assign(table.states().begin(), table.states().end());
    commands.assign(table.commands().begin(), table.commands().end());
  }
  /// The next cycle, in which every joint has gone on a little.
  control::TappedCycle next() {
    control::TappedCycle out;
    out.index = ++count;
    out.time = static_cast<Nanoseconds>(count) * 1'000'000;
    for (double& value : states) value += 1e-4;
    return out;
  }
  cell::Observer nobody;
  std::unique_ptr<test::OpenCell> cell;
  std::vector<double> states, commands;
  std::uint64_t count = 0;
};

void put_down(benchmark::State& state) {
  Arm arm;
  control::CycleTap tap(arm.states.size(), arm.commands.size(), 64);
  for (auto _ : state) {
    tap.record(arm.next(), arm.states, arm.commands);
    tap.drop();
  }
}

void make_messages(benchmark::State& state) {
  Arm arm;
  recording::CellChannels channels(arm.cell->view(), 0);
  std::size_t messages = 0;
  for (auto _ : state)
    channels.record_sample(arm.next(), arm.states, arm.commands,
                         [&](std::size_t, std::int64_t, std::span<const std::byte>) { ++messages; });
  state.counters["messages"] =
      benchmark::Counter(static_cast<double>(messages), benchmark::Counter::kAvgIterations);
}

void write_messages(benchmark::State& state) {
  Arm arm;
  recording::CellChannels channels(arm.cell->view(), 0);
  Nowhere sink;
  recording::McapWriter writer(sink, {"ros2", "bench", 1 << 20, state.range(0) != 0});
  for (const recording::Channel& channel : channels.list()) writer.add_channel(channel);
  for (auto _ : state)
    channels.record_sample(arm.next(), arm.states, arm.commands,
                         [&](std::size_t channel, std::int64_t time, std::span<const std::byte> payload) {
                           writer.message(channel, static_cast<std::uint64_t>(time), payload);
                         });
  writer.finish();
  state.counters["bytes"] =
      benchmark::Counter(static_cast<double>(sink.size), benchmark::Counter::kAvgIterations);
}

BENCHMARK(put_down);
BENCHMARK(make_messages);
BENCHMARK(write_messages)->Arg(0)->Arg(1)->ArgName("lz4");

}  // namespace
}  // namespace polyarm
