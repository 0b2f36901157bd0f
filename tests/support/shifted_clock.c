// For LD_PRELOAD: the wall clock is off by what the file CLOCK_SHIFT_FILE says: a number with h (hours), d (days), y (years) or
// nothing (seconds). The steady clock and the timers stay: libfaketime moves timers too, which then never end.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

typedef int (*ClockFunction)(clockid_t, struct timespec*);

static time_t shift(void) {
  char text[32] = {0};
  const char* name = getenv("CLOCK_SHIFT_FILE");
  const int file = name == NULL ? -1 : open(name, O_RDONLY | O_CLOEXEC);
  if (file < 0) {
    return 0;
  }
  const ssize_t length = read(file, text, sizeof text - 1);
  close(file);
  char* unit = text;
  const double number = length > 0 ? strtod(text, &unit) : 0.0;
  const double seconds = *unit == 'h' ? 3600.0 : *unit == 'd' ? 86400.0 : *unit == 'y' ? 31557600.0 : 1.0;
  return (time_t)(number * seconds);
}

int clock_gettime(clockid_t clock, struct timespec* time) {
  static ClockFunction real = NULL;
  if (real == NULL) {
    real = (ClockFunction)dlsym(RTLD_NEXT, "clock_gettime");
  }
  const int result = real(clock, time);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE)) {
    time->tv_sec += shift();
  }
  return result;
}

int gettimeofday(struct timeval* restrict value, void* restrict zone) {
  (void)zone;
  struct timespec now;
  const int result = clock_gettime(CLOCK_REALTIME, &now);
  value->tv_sec = now.tv_sec;
  value->tv_usec = now.tv_nsec / 1000;
  return result;
}

time_t time(time_t* result) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (result != NULL) {
    *result = now.tv_sec;
  }
  return now.tv_sec;
}
