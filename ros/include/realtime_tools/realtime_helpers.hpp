#pragma once
/// Priority, affinity and memory of the calling thread, for threads that a plugin starts itself.
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm_ros/standard.hpp"

namespace realtime_tools {

inline bool has_realtime_kernel() {
  std::ifstream file("/sys/kernel/realtime");
  int value = 0;
  return file && file >> value && value == 1;
}
inline bool configure_sched_fifo(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}
/// Polyarm decides whether its memory is locked.
inline std::pair<bool, std::string> lock_memory() {
  return {true, ""};
}
inline bool lock_memory(std::string& message) {
  return message.clear(), true;
}
inline std::pair<bool, std::string> set_thread_affinity(pthread_t thread, const std::vector<int>& cores) {
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int core : cores)
    if (core >= 0 && core < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(core), &set);
  const int failed = pthread_setaffinity_np(thread, sizeof set, &set);
  return {failed == 0, failed ? std::strerror(failed) : "the affinity is set"};
}
inline std::pair<bool, std::string> set_thread_affinity(pthread_t thread, int core) {
  return set_thread_affinity(thread, std::vector<int>{core});
}
inline std::pair<bool, std::string> set_current_thread_affinity(int core) {
  return set_thread_affinity(pthread_self(), core);
}
inline std::pair<bool, std::string> set_current_thread_affinity(const std::vector<int>& cores) {
  return set_thread_affinity(pthread_self(), cores);
}
inline std::pair<bool, std::string> set_thread_affinity(std::thread& thread, int core) {
  return set_thread_affinity(thread.native_handle(), core);
}
inline std::pair<bool, std::string> set_thread_affinity(std::thread& thread, const std::vector<int>& cores) {
  return set_thread_affinity(thread.native_handle(), cores);
}
inline std::pair<bool, std::string> set_current_thread_name(const std::string& name) {
  const int failed = pthread_setname_np(pthread_self(), name.substr(0, 15).c_str());
  return {failed == 0, failed ? std::strerror(failed) : "the name is set"};
}
inline long get_number_of_available_processors() {
  return ::sysconf(_SC_NPROCESSORS_ONLN);
}

}  // namespace realtime_tools
