#include "polyarm/process/confinement.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>

#include "polyarm/base/descriptor.hpp"

namespace polyarm::process {

namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kMachine = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t kMachine = 0;
#endif

/// These calls fail with any arguments.
constexpr int kRefused[] = {
    // other programs and processes
    SYS_execve, SYS_execveat, SYS_ptrace, SYS_process_vm_readv, SYS_process_vm_writev, SYS_kcmp, SYS_rt_sigqueueinfo,
    SYS_rt_tgsigqueueinfo, SYS_setpriority, SYS_sched_setscheduler, SYS_sched_setparam, SYS_sched_setattr,
    SYS_sched_setaffinity, SYS_ioprio_set, SYS_migrate_pages, SYS_move_pages, SYS_setns, SYS_unshare,
#ifdef SYS_fork
    SYS_fork, SYS_vfork,
#endif
#ifdef SYS_pidfd_open
    SYS_pidfd_open, SYS_pidfd_send_signal,
#endif
#ifdef SYS_pidfd_getfd
    SYS_pidfd_getfd,
#endif
#ifdef SYS_process_madvise
    SYS_process_madvise,
#endif
    // files
    SYS_truncate, SYS_ftruncate, SYS_unlinkat, SYS_renameat2, SYS_linkat, SYS_symlinkat, SYS_mkdirat, SYS_mknodat,
    SYS_fchmodat, SYS_fchmod, SYS_fchownat, SYS_fchown, SYS_utimensat, SYS_setxattr, SYS_lsetxattr, SYS_fsetxattr,
    SYS_removexattr, SYS_lremovexattr, SYS_fremovexattr, SYS_mount, SYS_umount2, SYS_pivot_root, SYS_chroot, SYS_fallocate,
    SYS_name_to_handle_at, SYS_open_by_handle_at,
#ifdef SYS_unlink
    SYS_unlink, SYS_rmdir, SYS_rename, SYS_link, SYS_symlink, SYS_mkdir, SYS_mknod, SYS_chmod, SYS_chown, SYS_lchown,
    SYS_creat, SYS_utime, SYS_utimes, SYS_futimesat,
#endif
#ifdef SYS_renameat
    SYS_renameat,
#endif
    // kernel interfaces
    SYS_bpf, SYS_perf_event_open, SYS_userfaultfd, SYS_keyctl, SYS_add_key, SYS_request_key, SYS_shmget, SYS_shmat,
    SYS_msgget, SYS_semget};

/// Treated as not implemented: their arguments are in memory, which a filter cannot read.
constexpr int kUnknown[] = {
#ifdef SYS_clone3
    SYS_clone3,
#endif
#ifdef SYS_openat2
    SYS_openat2,
#endif
#ifdef SYS_io_uring_setup
    SYS_io_uring_setup, SYS_io_uring_enter, SYS_io_uring_register,
#endif
};

class Filter {
 public:
  std::vector<sock_filter> program;

  void word(std::size_t offset) { add(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)); }
  void call() { word(offsetof(seccomp_data, nr)); }
  void argument(int index) { word(offsetof(seccomp_data, args) + 8 * static_cast<std::size_t>(index)); }  // low half
  void answer(int error) {
    add(BPF_RET | BPF_K, error == 0 ? SECCOMP_RET_ALLOW : SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error));
  }
  void die() { add(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS); }
  /// Skips `steps` instructions unless the loaded word is equal.
  void unless_equal(std::uint32_t value, std::uint8_t steps) { jump(BPF_JEQ, value, 0, steps); }
  void if_equal(std::uint32_t value, std::uint8_t steps) { jump(BPF_JEQ, value, steps, 0); }
  void if_any_bit(std::uint32_t bits, std::uint8_t steps) { jump(BPF_JSET, bits, steps, 0); }
  void if_at_least(std::uint32_t value, std::uint8_t steps) { jump(BPF_JGE, value, steps, 0); }

  void refuse(int number, int error) {
    unless_equal(static_cast<std::uint32_t>(number), 1);
    answer(error);
  }
  /// The call fails unless its argument is one of two values.
  void only(int number, int index, std::uint32_t value, std::uint32_t other) {
    unless_equal(static_cast<std::uint32_t>(number), 5);
    argument(index);
    if_equal(value, 2);
    if_equal(other, 1);
    answer(EPERM);
    answer(0);
  }
  /// The call fails if its argument has one of the bits.
  void without(int number, int index, std::uint32_t bits, int error) {
    unless_equal(static_cast<std::uint32_t>(number), 4);
    argument(index);
    if_any_bit(bits, 1);
    answer(0);
    answer(error);
  }

 private:
  void add(int code, std::uint32_t k) { program.push_back({static_cast<std::uint16_t>(code), 0, 0, k}); }
  void jump(int test, std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
    program.push_back({static_cast<std::uint16_t>(BPF_JMP | test | BPF_K), yes, no, value});
  }
};

Filter filter(bool local_sockets) {
  const auto self = static_cast<std::uint32_t>(::getpid());
  Filter out;
  out.word(offsetof(seccomp_data, arch));
  out.if_equal(kMachine, 1);
  out.die();
  out.call();
#ifdef __x86_64__
  constexpr std::uint32_t kOfX32 = 0x40000000;
  out.if_at_least(kOfX32, 1);
  out.if_at_least(0, 1);
  out.die();
#endif
  for (const int number : kRefused) out.refuse(number, EPERM);
  for (const int number : kUnknown) out.refuse(number, ENOSYS);
  constexpr std::uint32_t kWrites = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC | O_APPEND;
  out.without(SYS_openat, 2, kWrites, EACCES);
#ifdef SYS_open
  out.without(SYS_open, 1, kWrites, EACCES);
#endif
  // abort() sends a signal to its own process.
  out.only(SYS_kill, 0, self, self);
  out.only(SYS_tgkill, 0, self, self);
  out.refuse(SYS_tkill, EPERM);
  out.only(SYS_prlimit64, 0, 0, self);
  // Allows threads, but no processes.
  out.unless_equal(SYS_clone, 4);
  out.argument(0);
  out.if_any_bit(CLONE_THREAD, 1);
  out.answer(EPERM);
  out.answer(0);
  if (!local_sockets) {
    out.unless_equal(SYS_socket, 4);
    out.argument(0);
    out.if_equal(AF_UNIX, 1);
    out.answer(0);
    out.answer(EPERM);
  }
  out.answer(0);
  return out;
}

// --- Landlock; features of newer kernels are missing in older headers

struct Ruleset {
  std::uint64_t files, ports, scopes;
};
struct __attribute__((packed)) PathRule {
  std::uint64_t allowed;
  std::int32_t folder;
};
struct PortRule {
  std::uint64_t allowed, port;
};
enum RuleKind { kPath = 1, kPort = 2 };
constexpr std::uint64_t kReadFile = 1 << 2, kReadFolder = 1 << 3;
constexpr std::uint64_t kBind = 1 << 0, kConnect = 1 << 1;
constexpr std::uint64_t kAbstractSockets = 1 << 0, kSignals = 1 << 1;
constexpr int kCreateRuleset = 444, kAddRule = 445, kRestrictSelf = 446;

/// Files that libraries read: host and service names, certificates, glibc modules, CPU counts.
constexpr const char* kOfTheSystem[] = {"/etc", "/lib", "/lib64", "/usr/lib", "/usr/local/lib", "/usr/share/ca-certificates",
                                        "/usr/local/share/ca-certificates", "/usr/share/zoneinfo", "/run/systemd/resolve",
                                        "/run/resolvconf", "/run/NetworkManager", "/dev/null", "/dev/urandom", "/proc/self",
                                        "/proc/sys/net", "/proc/cpuinfo", "/proc/meminfo", "/sys/devices/system/cpu",
                                        "/sys/class/net"};

std::uint64_t files_of(long version) {
  std::uint64_t out = (1 << 13) - 1;      // 5.13
  if (version >= 2) out |= 1 << 13;       // moving between folders
  if (version >= 3) out |= 1 << 14;       // truncating
  if (version >= 5) out |= 1 << 15;       // commands to devices
  return out;
}

void allow_path(int rules, const std::string& path) {
  const Descriptor at(::open(path.c_str(), O_PATH | O_CLOEXEC));
  if (!at) return;
  struct stat status {};
  const bool folder = ::fstat(at.number(), &status) == 0 && S_ISDIR(status.st_mode);
  const PathRule rule{kReadFile | (folder ? kReadFolder : 0), at.number()};
  ::syscall(kAddRule, rules, kPath, &rule, 0);
}

void allow_ports(int rules, std::uint64_t what, const std::vector<std::uint16_t>& ports) {
  for (const std::uint16_t port : ports) {
    const PortRule rule{what, port};
    ::syscall(kAddRule, rules, kPort, &rule, 0);
  }
}

}  // namespace

bool filter_calls(bool local_sockets) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return false;
#endif
  if (kMachine == 0) return false;
  Filter made = filter(local_sockets);
  const sock_fprog program{static_cast<unsigned short>(made.program.size()), made.program.data()};
  return ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

bool confine(const Confinement& to) {
  constexpr long kVersion = 1;  // a flag: returns the kernel's version
  const long version = ::syscall(kCreateRuleset, nullptr, 0, kVersion);
  if (version < 1) return false;
  Ruleset wanted{files_of(version), 0, 0};
  if (version >= 4) wanted.ports = (to.listens ? kBind : 0) | (to.connects ? kConnect : 0);
  if (version >= 6) wanted.scopes = kAbstractSockets | kSignals;
  const Descriptor rules(static_cast<int>(::syscall(kCreateRuleset, &wanted, sizeof wanted, 0)));
  if (!rules) return false;
  for (const char* path : kOfTheSystem) allow_path(rules.number(), path);
  for (const std::string& path : to.readable)
    if (!path.empty()) allow_path(rules.number(), path);
  if (version >= 4 && to.listens) allow_ports(rules.number(), kBind, *to.listens);
  if (version >= 4 && to.connects) allow_ports(rules.number(), kConnect, *to.connects);
  return ::syscall(kRestrictSelf, rules.number(), 0) == 0;
}

}  // namespace polyarm::process
