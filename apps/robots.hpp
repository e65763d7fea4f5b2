#pragma once
/// `polyarm robots add | remove | picture | page | fit`. argv[0] is the second word.
namespace polyarm::apps {

int run_robots_add(int argc, char** argv);
int run_robots_remove(int argc, char** argv);
int run_robots_picture(int argc, char** argv);
int run_robots_page(int argc, char** argv);
int run_robots_fit(int argc, char** argv);

}  // namespace polyarm::apps
