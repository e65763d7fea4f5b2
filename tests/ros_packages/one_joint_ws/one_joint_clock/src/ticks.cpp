#include "one_joint_clock/ticks.hpp"

#include "rate.h"

int one_joint_clock::ticks() {
  return ONE_JOINT_TICKS;
}
