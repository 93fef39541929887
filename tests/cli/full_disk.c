// A disk that is full from one write on, for LD_PRELOAD. FULL_DISK_FROM: the number of that write, counted from 1 through all
// processes; FULL_DISK_COUNT: a file that keeps the count, one byte each.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

// whether this write is one too many
static int is_full(void) {
  const char *from = getenv("FULL_DISK_FROM"), *count = getenv("FULL_DISK_COUNT");
  if (from == NULL || count == NULL) return 0;
  const int kept = REAL(open)(count, O_WRONLY | O_APPEND | O_CLOEXEC);
  if (kept < 0) return 0;
  struct stat so_far;
  const int bad = REAL(write)(kept, "w", 1) != 1 || fstat(kept, &so_far) != 0;
  close(kept);
  if (bad || so_far.st_size < atol(from)) return 0;
  errno = ENOSPC;
  return 1;
}

// pipes and devices are never full
static int is_file(int file) {
  struct stat status;
  return fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

#define FULL(file) (is_file(file) && is_full())

ssize_t write(int file, const void *bytes, size_t size) { return FULL(file) ? -1 : REAL(write)(file, bytes, size); }
ssize_t writev(int file, const struct iovec *parts, int count) { return FULL(file) ? -1 : REAL(writev)(file, parts, count); }
ssize_t pwrite(int file, const void *bytes, size_t size, off_t at) { return FULL(file) ? -1 : REAL(pwrite)(file, bytes, size, at); }
ssize_t pwrite64(int file, const void *bytes, size_t size, off64_t at) { return FULL(file) ? -1 : REAL(pwrite64)(file, bytes, size, at); }
int ftruncate(int file, off_t size) { return FULL(file) ? -1 : REAL(ftruncate)(file, size); }
int ftruncate64(int file, off64_t size) { return FULL(file) ? -1 : REAL(ftruncate64)(file, size); }
int mkdir(const char *path, mode_t mode) { return is_full() ? -1 : REAL(mkdir)(path, mode); }

#define OPEN(name)                                             \
  int name(const char *path, int flags, ...) {                 \
    mode_t mode = 0;                                           \
    if (flags & (O_CREAT | O_TMPFILE)) {                       \
      va_list rest;                                            \
      va_start(rest, flags);                                   \
      mode = va_arg(rest, mode_t);                             \
      va_end(rest);                                            \
    }                                                          \
    const int makes = (flags & O_CREAT) && access(path, F_OK); \
    if (makes && is_full()) return -1;                         \
    return REAL(name)(path, flags, mode);                      \
  }
OPEN(open)
OPEN(open64)
