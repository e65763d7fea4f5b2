/// The bus of Linux over a kernel of ours, behind which the chip is.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>

#include "drivers/pca9685/chip.hpp"
#include "tests/pca9685/fake_chip.hpp"

namespace polyarm::drivers {
namespace {

struct Kernel {
  test::FakeChip chip;
  int file = 0;  ///< a good descriptor: whoever tests `!file` refuses it
  int open_error = 0, functions_error = 0, address_error = 0;
  unsigned long functions = I2C_FUNC_I2C | I2C_FUNC_SMBUS_EMUL;
  int transfers = 0, fail_from = -1, fail_to = -1, transfer_error = EREMOTEIO;
  bool cut_short = false;
  std::string opened;
  int open_flags = 0, closed = 0;
  unsigned long address = 0;
};
Kernel* kernel = nullptr;

int transfer(i2c_rdwr_ioctl_data& all) {
  const int n = kernel->transfers++;
  if (n >= kernel->fail_from && n < kernel->fail_to) {
    errno = kernel->transfer_error;
    return -1;
  }
  if (kernel->cut_short) return static_cast<int>(all.nmsgs) - 1;
  const i2c_msg& first = all.msgs[0];
  EXPECT_EQ(first.addr, kernel->address);
  int error = 0;
  if (all.nmsgs == 1) {
    EXPECT_EQ(first.flags, 0);
    error = kernel->chip.write({first.buf, first.len});
  } else {
    EXPECT_EQ(all.nmsgs, 2u);
    EXPECT_EQ(all.msgs[1].flags, I2C_M_RD);
    EXPECT_EQ(all.msgs[1].addr, kernel->address);
    error = kernel->chip.read(first.buf[0], {all.msgs[1].buf, all.msgs[1].len});
  }
  if (error == 0) return static_cast<int>(all.nmsgs);
  errno = error;
  return -1;
}

int fail_with(int error) {
  errno = error;
  return error == 0 ? 0 : -1;
}

const BusCalls kCalls = {[](const char* path, int flags) {
                           kernel->opened = path;
                           kernel->open_flags = flags;
                           return kernel->open_error ? fail_with(kernel->open_error) : kernel->file;
                         },
                         [](int file, unsigned long request, void* argument) {
                           EXPECT_EQ(file, kernel->file);
                           if (request == I2C_FUNCS) {
                             *static_cast<unsigned long*>(argument) = kernel->functions;
                             return fail_with(kernel->functions_error);
                           }
                           if (request == I2C_SLAVE) {
                             kernel->address = reinterpret_cast<std::uintptr_t>(argument);
                             return fail_with(kernel->address_error);
                           }
                           EXPECT_EQ(request, static_cast<unsigned long>(I2C_RDWR));
                           return transfer(*static_cast<i2c_rdwr_ioctl_data*>(argument));
                         },
                         [](int file) {
                           EXPECT_EQ(file, kernel->file);
                           ++kernel->closed;
                           return 0;
                         }};

class LinuxBusTest : public ::testing::Test {
 protected:
  LinuxBusTest() { kernel = &own; }
  ~LinuxBusTest() override { kernel = nullptr; }
  std::unique_ptr<I2cBus> open() { return open_linux_bus("/dev/i2c-1", 0x60, failure, kCalls); }
  void expect_refused(BusFailure::Step step, int error) {
    EXPECT_EQ(open(), nullptr);
    EXPECT_EQ(failure.step, step);
    EXPECT_EQ(failure.error, error);
    EXPECT_EQ(own.closed, step == BusFailure::Step::open ? 0 : 1);
  }
  Kernel own;
  BusFailure failure;
};

TEST_F(LinuxBusTest, DrivesTheChipThroughDescriptorZero) {
  {
    const auto bus = open();
    ASSERT_NE(bus, nullptr);
    EXPECT_EQ(own.opened, "/dev/i2c-1");
    EXPECT_EQ(own.open_flags, O_RDWR | O_CLOEXEC);
    EXPECT_EQ(own.address, 0x60u);
    EXPECT_EQ(own.transfers, 0) << "opening sends nothing";
    Pca9685 chip(*bus);
    EXPECT_FALSE(chip.identify());
    EXPECT_FALSE(chip.start(3));
    EXPECT_FALSE(chip.set(8, 1234));
    EXPECT_EQ(own.chip.output(8), 1234);
  }
  EXPECT_EQ(own.closed, 1);
}

TEST_F(LinuxBusTest, AFailedOpenIsNoticed) {
  own.open_error = ENOENT;
  expect_refused(BusFailure::Step::open, ENOENT);
}
TEST_F(LinuxBusTest, AFileThatIsNoBusIsNoticed) {
  own.functions_error = ENOTTY;
  expect_refused(BusFailure::Step::functions, ENOTTY);
}
TEST_F(LinuxBusTest, ABusThatKnowsSmbusAloneIsNoticed) {
  own.functions = I2C_FUNC_SMBUS_EMUL;
  expect_refused(BusFailure::Step::not_plain, EOPNOTSUPP);
}
TEST_F(LinuxBusTest, ADriverOfTheKernelIsNoticed) {
  own.address_error = EBUSY;
  expect_refused(BusFailure::Step::address, EBUSY);
}

TEST_F(LinuxBusTest, AMissingAcknowledgeIsAnError) {
  const auto bus = open();
  const std::uint8_t bytes[] = {0xFD, 0x10};
  own.fail_from = 0;
  own.fail_to = 1;
  EXPECT_EQ(bus->write(bytes), EREMOTEIO);
  EXPECT_EQ(bus->write(bytes), 0);
  own.cut_short = true;
  std::uint8_t got = 0;
  EXPECT_EQ(bus->read(0, {&got, 1}), EIO) << "half of it";
}

TEST_F(LinuxBusTest, ALostArbitrationIsTriedAgainButNotForEver) {
  const auto bus = open();
  const std::uint8_t bytes[] = {0xFD, 0x10};
  own.transfer_error = EAGAIN;
  own.fail_from = 0;
  own.fail_to = 2;
  EXPECT_EQ(bus->write(bytes), 0);
  own.transfers = 0;
  own.fail_to = 1000;
  EXPECT_EQ(bus->write(bytes), EAGAIN);
  EXPECT_EQ(own.transfers, 3);
}

}  // namespace
}  // namespace polyarm::drivers
