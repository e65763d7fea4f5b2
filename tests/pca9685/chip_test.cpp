#include "drivers/pca9685/chip.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/pca9685/fake_chip.hpp"

namespace polyarm::drivers {
namespace {

/// The chip on a wire of its own, in this process.
class DirectBus : public I2cBus {
 public:
  int write(std::span<const std::uint8_t> bytes) noexcept override {
    written.emplace_back(bytes.begin(), bytes.end());
    return fail_at-- == 0 ? EREMOTEIO : chip.write(bytes);
  }
  int read(std::uint8_t first, std::span<std::uint8_t> into) noexcept override {
    return fail_at-- == 0 ? EREMOTEIO : chip.read(first, into);
  }
  test::FakeChip chip;
  std::vector<std::vector<std::uint8_t>> written;
  int fail_at = -1;
};

TEST(Prescale, IsThatOfTheDataSheet) {
  EXPECT_EQ(prescale_for(1600), 3);
  EXPECT_EQ(prescale_for(50), 121);
  EXPECT_EQ(prescale_for(200), 30) << "what the chip has after power-on";
  EXPECT_EQ(prescale_for(24), 253);
  EXPECT_EQ(prescale_for(23), std::nullopt);
  EXPECT_EQ(prescale_for(2000), std::nullopt) << "hardware takes no less than 3";
  EXPECT_EQ(prescale_for(0), std::nullopt);
  EXPECT_EQ(prescale_for(-50), std::nullopt);
  EXPECT_EQ(prescale_for(NAN), std::nullopt);
  EXPECT_NEAR(frequency_of(3), 1525.88, 0.01);
  EXPECT_NEAR(frequency_of(121), 50.03, 0.01);
}

TEST(Chip, StartsInTheOrderOfTheDataSheet) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(*prescale_for(50)));
  const std::vector<std::vector<std::uint8_t>> expected = {{0xFD, 0x10},   // all off
                                                           {0x00, 0x30},   // asleep
                                                           {0xFE, 121},    // only now
                                                           {0x01, 0x04},   // both transistors, change at STOP
                                                           {0x00, 0x20},   // awake
                                                           {0x00, 0xA0}};  // no restart is left pending
  EXPECT_EQ(bus.written, expected);
  EXPECT_EQ(bus.chip.at(0xFE), 121);
  EXPECT_EQ(bus.chip.at(0x00), 0x20);
  EXPECT_FALSE(chip.check());
}

TEST(Chip, OldPulsesDoNotStartAgain) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(3));
  ASSERT_FALSE(chip.set(8, 2000));
  ASSERT_FALSE(chip.set(9, 4096));
  EXPECT_EQ(bus.chip.output(8), 2000);
  ASSERT_FALSE(chip.start(3));
  EXPECT_TRUE(bus.chip.all_off());
}

TEST(Chip, EveryFailureOnTheWayIsTold) {
  for (int n = 0; n < 9; ++n) {
    DirectBus bus;
    bus.fail_at = n;
    const ChipFailure failure = Pca9685(bus).start(3);
    EXPECT_TRUE(failure) << "transaction " << n;
    EXPECT_EQ(failure.error, EREMOTEIO) << n;
  }
}

TEST(Chip, DutiesAreTicks) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(3));
  for (const int ticks : {0, 1, 255, 256, 2048, 4095, 4096}) {
    ASSERT_FALSE(chip.set(15, ticks));
    EXPECT_EQ(bus.chip.output(15), ticks);
  }
  EXPECT_EQ(bus.chip.output(14), 0);
}

TEST(Chip, OffIsOneTransactionAndWinsOverOn) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(3));
  for (int channel = 0; channel < 16; ++channel) ASSERT_FALSE(chip.set(channel, 4096));
  bus.written.clear();
  ASSERT_FALSE(chip.off());
  EXPECT_EQ(bus.written.size(), 1u);
  EXPECT_TRUE(bus.chip.all_off());
}

TEST(Chip, AsleepNothingThatIsWrittenComesOut) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(3));
  ASSERT_FALSE(chip.off());
  ASSERT_FALSE(chip.sleep());
  ASSERT_FALSE(chip.set(8, 4096));
  EXPECT_TRUE(bus.chip.all_off());
  EXPECT_EQ(chip.check().value, 0x30) << "and that is found out";
}

TEST(Chip, LossOfPowerIsFoundOut) {
  DirectBus bus;
  Pca9685 chip(bus);
  ASSERT_FALSE(chip.start(3));
  bus.chip.power_on();
  const ChipFailure failure = chip.check();
  EXPECT_EQ(failure.step, ChipFailure::Step::check);
  EXPECT_EQ(failure.error, 0);
  EXPECT_EQ(failure.value, 0x11);
}

/// Something else that answers: a memory.
class Memory : public I2cBus {
 public:
  int write(std::span<const std::uint8_t>) noexcept override {
    ++writes;
    return 0;
  }
  int read(std::uint8_t, std::span<std::uint8_t> into) noexcept override {
    for (std::uint8_t& byte : into) byte = value;
    return 0;
  }
  std::uint8_t value = 0;
  int writes = 0;
};

TEST(Chip, AnotherDeviceIsToldApartWithoutWriting) {
  for (const int value : {0x00, 0x55, 0xFF, 0x10}) {
    Memory memory;
    memory.value = static_cast<std::uint8_t>(value);
    EXPECT_TRUE(Pca9685(memory).identify()) << value;
    EXPECT_EQ(memory.writes, 0);
  }
  DirectBus bus;
  EXPECT_FALSE(Pca9685(bus).identify());
}

}  // namespace
}  // namespace polyarm::drivers
