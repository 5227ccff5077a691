/* Logs what a program does to the files of one folder, in order: the crash simulator replays the log (`crash/disk.rs`).
   Preloaded into the program under test; APEX_CRASH_FOLDER names the folder, APEX_CRASH_LOG the log.

   An entry: kind (1 byte), length of the file's name (1 byte), name, offset (8 bytes), length of the data (8 bytes), data.
   Kinds: c created, w write, t truncate (offset is the new length), s sync, d sync of the folder, u unlink. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static int log_descriptor = -1;

/* The name of the file inside the folder; "." for the folder itself; null for everything else. */
static const char *name_of(const char *path) {
    const char *folder = getenv("APEX_CRASH_FOLDER");
    size_t length = folder ? strlen(folder) : 0;
    if (!length || strncmp(path, folder, length)) return NULL;
    if (!path[length]) return ".";
    if (path[length] != '/') return NULL;
    path += length + 1;
    /* Shared memory of SQLite is made anew after a crash. */
    size_t rest = strlen(path);
    if (!rest || rest > 200 || strchr(path, '/') || (rest > 4 && !strcmp(path + rest - 4, "-shm"))) return NULL;
    return path;
}

static const char *name_of_descriptor(int descriptor, char path[4096]) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, 4095);
    if (length <= 0) return NULL;
    path[length] = 0;
    return name_of(path);
}

static void put(const void *bytes, size_t length) {
    const char *from = bytes;
    while (length) {
        long written = syscall(SYS_write, log_descriptor, from, length);
        if (written <= 0) abort();
        from += written, length -= (size_t)written;
    }
}

/* The lock is held from before the operation until it is noted: the log has the order of the operations. */
static void note(char kind, const char *name, uint64_t offset, const void *data, uint64_t length) {
    if (log_descriptor < 0) {
        const char *path = getenv("APEX_CRASH_LOG");
        if (!path) abort();
        log_descriptor = (int)syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
        if (log_descriptor < 0) abort();
    }
    uint8_t size = (uint8_t)strlen(name);
    put(&kind, 1), put(&size, 1), put(name, size), put(&offset, 8), put(&length, 8);
    if (length) put(data, length);
}

static void hold(const char *name) {
    if (name) pthread_mutex_lock(&lock);
}

static void release(const char *name) {
    if (name) pthread_mutex_unlock(&lock);
}

static int opened(const char *path, int flags, mode_t mode) {
    const char *name = name_of(path);
    hold(name);
    int existed = access(path, F_OK) == 0;
    int descriptor = (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
    if (name && descriptor >= 0 && !existed && strcmp(name, ".")) note('c', name, 0, NULL, 0);
    release(name);
    return descriptor;
}

#define OPEN(function)                                                                                                 \
    int function(const char *path, int flags, ...) {                                                                   \
        va_list more;                                                                                                  \
        va_start(more, flags);                                                                                         \
        mode_t mode = (flags & O_CREAT) ? va_arg(more, mode_t) : 0;                                                    \
        va_end(more);                                                                                                  \
        return opened(path, flags, mode);                                                                              \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int descriptor, const void *data, size_t length) {
    char path[4096];
    const char *name = descriptor > 2 ? name_of_descriptor(descriptor, path) : NULL;
    hold(name);
    off_t offset = name ? lseek(descriptor, 0, SEEK_CUR) : 0;
    ssize_t written = syscall(SYS_write, descriptor, data, length);
    if (name && written > 0) note('w', name, (uint64_t)offset, data, (uint64_t)written);
    release(name);
    return written;
}

#define PWRITE(function, type)                                                                                         \
    ssize_t function(int descriptor, const void *data, size_t length, type offset) {                                   \
        char path[4096];                                                                                               \
        const char *name = name_of_descriptor(descriptor, path);                                                       \
        hold(name);                                                                                                    \
        ssize_t written = syscall(SYS_pwrite64, descriptor, data, length, offset);                                     \
        if (name && written > 0) note('w', name, (uint64_t)offset, data, (uint64_t)written);                           \
        release(name);                                                                                                 \
        return written;                                                                                                \
    }
PWRITE(pwrite, off_t)
PWRITE(pwrite64, off64_t)

#define TRUNCATE(function, type)                                                                                       \
    int function(int descriptor, type length) {                                                                        \
        char path[4096];                                                                                               \
        const char *name = name_of_descriptor(descriptor, path);                                                       \
        hold(name);                                                                                                    \
        int result = (int)syscall(SYS_ftruncate, descriptor, length);                                                  \
        if (name && !result) note('t', name, (uint64_t)length, NULL, 0);                                               \
        release(name);                                                                                                 \
        return result;                                                                                                 \
    }
TRUNCATE(ftruncate, off_t)
TRUNCATE(ftruncate64, off64_t)

#define SYNC(function, number)                                                                                         \
    int function(int descriptor) {                                                                                     \
        char path[4096];                                                                                               \
        const char *name = name_of_descriptor(descriptor, path);                                                       \
        hold(name);                                                                                                    \
        int result = (int)syscall(number, descriptor);                                                                 \
        if (name && !result) note(strcmp(name, ".") ? 's' : 'd', name, 0, NULL, 0);                                    \
        release(name);                                                                                                 \
        return result;                                                                                                 \
    }
SYNC(fsync, SYS_fsync)
SYNC(fdatasync, SYS_fdatasync)

int unlink(const char *path) {
    const char *name = name_of(path);
    hold(name);
    int result = (int)syscall(SYS_unlink, path);
    if (name && !result) note('u', name, 0, NULL, 0);
    release(name);
    return result;
}
