/// The six servos of an arm behind a pty, in a process of their own: LINK leads to it until standard input
/// ends.
#include <cstdio>

#include "drivers/servo_bus/fake_bus.hpp"
#include "polyarm/base/error.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: servos_bus_process LINK\n", stderr);
    return 2;
  }
  try {
    const polyarm::servo_bus::FakeBus bus(polyarm::servo_bus::Wire::feetech, {1, 2, 3, 4, 5, 6}, argv[1]);
    std::puts(bus.path().c_str());
    std::fflush(stdout);
    while (std::getchar() != EOF) {
    }
  } catch (const polyarm::Error& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return 1;
  }
  return 0;
}
