// realtime.cpp: asks the kernel, and tells in one line what it refused and what would be right.
// SPDX-License-Identifier: Apache-2.0
#include "daemon/service/realtime.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sysexits.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>

#include "config/cpu_list.h"

namespace vdisp {
namespace {

std::set<int> allowed_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::set<int> cpus;
  if (sched_getaffinity(0, sizeof set, &set) != 0) return cpus;
  for (int cpu = 0; cpu <= largest_cpu; ++cpu)
    if (CPU_ISSET(cpu, &set)) cpus.insert(cpu);
  return cpus;
}

void take_cpus(const std::string& text) {
  const std::set<int> allowed = allowed_cpus();
  const auto wanted = cpu_list(text);
  cpu_set_t set;
  CPU_ZERO(&set);
  for (const int cpu : wanted.value()) {
    if (!allowed.contains(cpu))
      throw RealtimeError(EX_CONFIG, "[main] cpus = " + text + ": there is no processor " + std::to_string(cpu) +
                                         " for this process, only " + text_of(allowed) +
                                         " (CPUAffinity and AllowedCPUs in its unit count)");
    CPU_SET(cpu, &set);
  }
  if (sched_setaffinity(0, sizeof set, &set) != 0) throw RealtimeError(EX_NOPERM, "[main] cpus = " + text + ": " + std::strerror(errno));
}

std::string limit_of(int resource, rlim_t unit) {
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  return limit.rlim_cur == RLIM_INFINITY ? "none" : std::to_string(limit.rlim_cur / unit);
}

/// "VmSize" in KiB.
std::string mapped_kib() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == "VmSize:" && status >> word) return word;
  return "an unknown number of";
}

}  // namespace

void take_processors(const main_section& main) {
  if (!main.cpus.empty()) take_cpus(main.cpus);
  if (main.scheduling == "other") return;
  const sched_param parameter{main.priority};
  if (sched_setscheduler(0, main.scheduling == "fifo" ? SCHED_FIFO : SCHED_RR, &parameter) == 0) return;
  const std::string asked = "[main] scheduling = " + main.scheduling + ", priority = " + std::to_string(main.priority);
  // A control group without a share of the time for real time refuses even root with EPERM.
  throw RealtimeError(EX_NOPERM, asked + ": " + std::strerror(errno) + "; this process may have priorities up to " +
                                     limit_of(RLIMIT_RTPRIO, 1) + " (LimitRTPRIO in its unit, ulimit -r), or set scheduling = other");
}

void lock_memory(const main_section& main) {
  if (!main.lockMemory || mlockall(MCL_CURRENT) == 0) return;
  const std::string why = std::strerror(errno);
  munlockall();
  throw RealtimeError(EX_NOPERM, "[main] lockMemory = yes: " + why + "; needed are " + mapped_kib() + " KiB, this process may lock " +
                                     limit_of(RLIMIT_MEMLOCK, 1024) + " (LimitMEMLOCK in its unit, ulimit -l), or set lockMemory = no");
}

}  // namespace vdisp
