#pragma once
/// The parts of `polyarm setup` for one kind of device each.

namespace polyarm::apps {

int run_setup_abb(int argc, char** argv);
int run_setup_kuka(int argc, char** argv);
int run_setup_yaskawa(int argc, char** argv);
int run_setup_xarm(int argc, char** argv);
int run_setup_franka(int argc, char** argv);
int run_setup_cia402(int argc, char** argv);

}  // namespace polyarm::apps
