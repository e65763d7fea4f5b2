#pragma once
/// `polyarm workspace`; argv[0] is the verb.
namespace polyarm::apps {

int run_workspace(int argc, char** argv);

}  // namespace polyarm::apps
