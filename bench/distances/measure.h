/// Times by the processor's clock and by the wall's.
#pragma once

#include <time.h>

namespace bench {

struct Seconds {
  double cpu = 0, wall = 0;
};

template <class Work>
Seconds seconds_of(Work&& work) {
  auto now = [](clockid_t clock) {
    timespec t;
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double cpu = now(CLOCK_PROCESS_CPUTIME_ID), wall = now(CLOCK_MONOTONIC);
  work();
  return {now(CLOCK_PROCESS_CPUTIME_ID) - cpu, now(CLOCK_MONOTONIC) - wall};
}

}  // namespace bench
