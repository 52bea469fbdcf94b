/* atomic_file.c - write under a temporary name, sync, rename, sync the directory. */
#include "lib/io/atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void release(struct kith_atomic_file **file) {
  if ((*file)->stream != NULL) fclose((*file)->stream);
  kith_free(file);
}

static kith_status open_temporary(struct kith_atomic_file *file) {
  const char *path = file->path;
  struct stat present;
  if (stat(path, &present) == 0 && !S_ISREG(present.st_mode)) /* a rename would replace a device or a pipe */
    KITH_FAIL(BAD_FILE, "%s: cannot write: not a regular file", path);
  unlink(file->temporary); /* of a run that was killed; a link would lead elsewhere */
  const int descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  file->stream = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
  const int reason = errno;
  if (file->stream == NULL && descriptor >= 0) close(descriptor), unlink(file->temporary); /* no memory */
  if (file->stream == NULL) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", path, strerror(reason));
  file->opened = true;
  return KITH_OK;
}

kith_status kith_atomic_file_join(struct kith_atomic_file **out, const char *path) {
  const size_t longest = strlen(path) + sizeof ".previous";
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + 3 * longest));
  struct kith_atomic_file *file = *out;
  file->path = strcpy((char *)(file + 1), path);
  file->temporary = file->path + longest;
  file->previous = file->temporary + longest;
  snprintf(file->temporary, longest, "%s.partial", path);
  snprintf(file->previous, longest, "%s.previous", path);
  return KITH_OK;
}

kith_status kith_atomic_file_open(struct kith_atomic_file **out, const char *path) {
  KITH_TRY(kith_atomic_file_join(out, path));
  const kith_status status = open_temporary(*out);
  if (status != KITH_OK) release(out);
  return status;
}

/* Flushes and syncs what was written. 0, or -1 with errno. */
static int flush_to_disk(struct kith_atomic_file *file) {
  const bool written = fflush(file->stream) == 0 && !ferror(file->stream) && fsync(fileno(file->stream)) == 0;
  const int why = errno;
  const bool closed = fclose(file->stream) == 0;
  file->stream = NULL;
  if (!written) errno = why != 0 ? why : EIO;
  return written && closed ? 0 : -1;
}

/* Keeps the file that PATH is as PATH.previous. A hard link gives it this second name, so that PATH is not
 * missing before the rename in `publish` replaces it. A file system without hard links leaves a moment in
 * which PATH is missing. */
static kith_status set_aside(const struct kith_atomic_file *file) {
  if (access(file->path, F_OK) != 0) return KITH_OK; /* there is none; an earlier .previous stays */
  unlink(file->previous);
  if (link(file->path, file->previous) == 0 || errno == ENOENT) return KITH_OK;
  if (rename(file->path, file->previous) == 0) return KITH_OK;
  KITH_FAIL(BAD_FILE, "%s: cannot keep it as .previous: %s", file->path, strerror(errno));
}

/* Syncs the rename itself. File systems that cannot sync a directory return EINVAL. */
static int sync_directory(const char *path) {
  char *copy = strdup(path);
  if (copy == NULL) return -1;
  const int fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  kith_free(&copy);
  if (fd < 0) return -1;
  const int result = fsync(fd) == 0 || errno == EINVAL ? 0 : -1;
  close(fd);
  return result;
}

static kith_status publish(struct kith_atomic_file *file, bool keep_previous) {
  if (flush_to_disk(file) != 0) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(errno));
  if (keep_previous) KITH_TRY(set_aside(file));
  if (rename(file->temporary, file->path) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot rename %s: %s", file->path, file->temporary, strerror(errno));
  if (sync_directory(file->path) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot sync its directory: %s", file->path, strerror(errno));
  return KITH_OK;
}

kith_status kith_atomic_file_commit(struct kith_atomic_file **file, bool keep_previous) {
  const kith_status status = publish(*file, keep_previous);
  if (status == KITH_OK)
    release(file);
  else
    kith_atomic_file_abandon(file);
  return status;
}

void kith_atomic_file_abandon(struct kith_atomic_file **file) {
  if (*file == NULL) return;
  if ((*file)->opened) unlink((*file)->temporary);
  release(file);
}

int kith_write_at(int descriptor, const void *data, size_t bytes, uint64_t place) {
  for (size_t done = 0; done < bytes;) {
    errno = EIO; /* unless the call says otherwise */
    const ssize_t n = pwrite(descriptor, (const char *)data + done, bytes - done, (off_t)(place + done));
    if (n <= 0 && errno != EINTR) return -1;
    done += (size_t)KITH_MAX(n, (ssize_t)0);
  }
  return 0;
}
