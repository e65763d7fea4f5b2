#pragma once
/// Ends objects of plugins. A destructor that throws ends the process in C++, before anyone has read why the
/// plugin failed. Here it runs on a thread of its own: if it throws, that thread stands still for ever with
/// what is left of the object, the module stays loaded, and the log says what was thrown.
#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>

#include <condition_variable>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "polyarm_ros/log.hpp"
#include "polyarm_ros/wires.hpp"

namespace polyarm_ros {

struct LastCall {
  std::mutex mutex;
  std::condition_variable changed;
  bool over = false, failed = false;
  std::string text;
  void end(bool by_failing, std::string with) {
    {
      const std::lock_guard lock(mutex);
      over = true, failed = by_failing, text = std::move(with);
    }
    changed.notify_all();
  }
};
/// Of the thread that runs a destructor; null in others.
inline LastCall*& last_call() {
  static thread_local LastCall* value = nullptr;
  return value;
}
inline std::terminate_handler& earlier_handler() {
  static std::terminate_handler value = nullptr;
  return value;
}
[[noreturn]] inline void stand_still() {
  LastCall* const call = last_call();
  if (!call) {  // another thread: as without this header
    if (earlier_handler()) earlier_handler()();
    std::abort();
  }
  std::string text = "it threw something that is not a std::exception";
  try {
    if (const auto thrown = std::current_exception())
      std::rethrow_exception(thrown);
    else
      text = "it called std::terminate, as at the end of a std::thread that nobody joined";
  } catch (const std::exception& e) {
    text = std::string("it threw: ") + e.what();
  } catch (...) {
  }
  Dl_info here{};
  if (::dladdr(reinterpret_cast<void*>(&stand_still), &here) && here.dli_fname)
    ::dlopen(here.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE);
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, nullptr);
  call->end(true, text);
  for (;;) ::pause();
}

/// Runs `destroy`, which ends an object of the plugin. Not in a cycle.
inline void end_of_plugin(const char* name, std::function<void()> destroy) {
  static std::mutex one_at_a_time;  // the handler is the process's
  const std::lock_guard lock(one_at_a_time);
  const auto call = std::make_shared<LastCall>();
  earlier_handler() = std::set_terminate(stand_still);
  try {
    std::thread thread([call, destroy, serves = serves_graph()] {
      serves_graph() = serves;
      last_call() = call.get();
      destroy();
      call->end(false, "");
    });
    std::unique_lock wait(call->mutex);
    call->changed.wait(wait, [&] { return call->over; });
    wait.unlock();
    if (call->failed)
      thread.detach();
    else
      thread.join();
  } catch (const std::system_error&) {  // no thread is left
    destroy();
  }
  std::set_terminate(earlier_handler());
  if (call->failed)
    log_format(
        Severity::error, name,
        "its destructor failed, which its author must mend; what is left of the plugin stays as it is: %s",
        call->text.c_str());
}

}  // namespace polyarm_ros
