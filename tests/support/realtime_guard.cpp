#include "tests/support/realtime_guard.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define POLYARM_NO_GUARD 1
#endif

namespace {
enum Forbidden {
  kMalloc,
  kCalloc,
  kRealloc,
  kFree,
  kAlign,
  kLock,
  kCondWait,
  kWrite,
  kSleep,
  kThrow,
  kForbidden
};
constexpr const char* kNames[kForbidden] = {
    "malloc", "calloc",    "realloc", "free", "aligned_alloc", "pthread_mutex_lock", "pthread_cond_wait",
    "write",  "nanosleep", "throw"};
thread_local bool guarded = false;
thread_local std::array<unsigned, kForbidden> counts{};

[[maybe_unused]] void note(Forbidden what) {
  if (guarded) ++counts[static_cast<std::size_t>(what)];
}
}  // namespace

namespace polyarm::test {
RealtimeGuard::RealtimeGuard() {
  counts.fill(0);
  guarded = true;
}
RealtimeGuard::~RealtimeGuard() {
  guarded = false;
}

bool RealtimeGuard::watches() {
#ifdef POLYARM_NO_GUARD
  return false;
#else
  return true;
#endif
}

std::uint64_t RealtimeGuard::allocations() {
  std::uint64_t out = 0;
  for (const Forbidden one : {kMalloc, kCalloc, kRealloc, kAlign}) out += counts[one];
  return out;
}

std::string RealtimeGuard::violations() const {
  const bool was = guarded;
  guarded = false;
  std::string out;
  for (std::size_t i = 0; i < kForbidden; ++i)
    if (counts[i] > 0)
      out += (out.empty() ? "" : ", ") + std::string(kNames[i]) + " x" + std::to_string(counts[i]);
  guarded = was;
  return out;
}
}  // namespace polyarm::test

#ifndef POLYARM_NO_GUARD
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void __libc_free(void*);
void* __libc_memalign(size_t, size_t);

void* malloc(size_t size) {
  note(kMalloc);
  return __libc_malloc(size);
}
void* calloc(size_t n, size_t size) {
  note(kCalloc);
  return __libc_calloc(n, size);
}
void* realloc(void* p, size_t size) {
  note(kRealloc);
  return __libc_realloc(p, size);
}
void free(void* p) {
  if (p) note(kFree);
  __libc_free(p);
}
void* aligned_alloc(size_t alignment, size_t size) {
  note(kAlign);
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
  note(kAlign);
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : 12;
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  note(kLock);
  static auto* real = reinterpret_cast<int (*)(pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  return real(mutex);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  note(kCondWait);
  static auto* real =
      reinterpret_cast<int (*)(pthread_cond_t*, pthread_mutex_t*)>(dlsym(RTLD_NEXT, "pthread_cond_wait"));
  return real(condition, mutex);
}
ssize_t write(int fd, const void* data, size_t size) {
  note(kWrite);
  static auto* real = reinterpret_cast<ssize_t (*)(int, const void*, size_t)>(dlsym(RTLD_NEXT, "write"));
  return real(fd, data, size);
}
int nanosleep(const timespec* wanted, timespec* left) {
  note(kSleep);
  static auto* real = reinterpret_cast<int (*)(const timespec*, timespec*)>(dlsym(RTLD_NEXT, "nanosleep"));
  return real(wanted, left);
}
[[noreturn]] void __cxa_throw(void* object, void* type, void (*destroy)(void*)) {
  note(kThrow);
  using Throw = void (*)(void*, void*, void (*)(void*));
  static auto real = reinterpret_cast<Throw>(dlsym(RTLD_NEXT, "__cxa_throw"));
  real(object, type, destroy);
  std::abort();
}
}
#endif
