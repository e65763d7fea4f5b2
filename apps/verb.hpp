#pragma once
/// The verbs of the command. Dispatch, help and completion come from one table.
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::apps {

/// Exit codes of every verb.
enum Exit {
  kOk = 0,
  kFailed = 1,   ///< the run, the check or the solution failed
  kUsage = 2,    ///< usage error
  kStopped = 3,  ///< stopped by a person before the end
};

/// A command line that was parsed but asks for something impossible; ends the command with kUsage.
class WrongUse : public Error {
 public:
  using Error::Error;
};

struct Verb {
  const char* name;
  const char* summary;
  int (*run)(int argc, char** argv);  ///< argv[0] is the verb
};
const std::vector<Verb>& verbs();

int run_run(int argc, char** argv);
int run_check(int argc, char** argv);
int run_calibrate(int argc, char** argv);
int run_fmt(int argc, char** argv);
int run_fleet(int argc, char** argv);
int run_users(int argc, char** argv);
int run_audit(int argc, char** argv);
int run_test(int argc, char** argv);
int run_compare(int argc, char** argv);
int run_sweep(int argc, char** argv);
int run_language(int argc, char** argv);
int run_new(int argc, char** argv);
int run_plugins(int argc, char** argv);
int run_plugin(int argc, char** argv);
int run_robots(int argc, char** argv);
int run_describe(int argc, char** argv);
int run_fk(int argc, char** argv);
int run_ik(int argc, char** argv);
int run_plan(int argc, char** argv);
int run_xacro(int argc, char** argv);
int run_export(int argc, char** argv);
int run_replay(int argc, char** argv);
int run_control(int argc, char** argv);
int run_hardware(int argc, char** argv);
int run_interfaces(int argc, char** argv);
int run_health(int argc, char** argv);
int run_limits(int argc, char** argv);
int run_tags(int argc, char** argv);
int run_data(int argc, char** argv);
int run_send(int argc, char** argv);
int run_watch(int argc, char** argv);
int run_console(int argc, char** argv);
int run_lead(int argc, char** argv);
int run_teleop(int argc, char** argv);
int run_jog(int argc, char** argv);
int run_param(int argc, char** argv);
int run_setup(int argc, char** argv);
int run_doctor(int argc, char** argv);
int run_drivers(int argc, char** argv);
int run_far_side(int argc, char** argv);
int run_completion(int argc, char** argv);
int run_version(int argc, char** argv);

}  // namespace polyarm::apps
