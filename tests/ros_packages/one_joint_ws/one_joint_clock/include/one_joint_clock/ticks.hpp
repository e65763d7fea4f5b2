#pragma once
namespace one_joint_clock {
int ticks();
}
