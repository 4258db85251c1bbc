/* Calls the whole C interface correctly and incorrectly. */
#include "check.h"

#include <sys/mman.h>
#include <unistd.h>

const char *last_error(void)
{
  static _Thread_local char text[1000];
  const size_t length = rcs_last_error(text, sizeof text);
  CHECK(length < sizeof text && strlen(text) == length);
  return text;
}

static size_t pages_of(size_t size)
{
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  return (size + page - 1) / page * page;
}

void *guarded(size_t size)
{
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  uint8_t *begin = mmap(NULL, pages_of(size) + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (begin == MAP_FAILED || mprotect(begin + pages_of(size), page, PROT_NONE) != 0)
  {
    perror("guarded");
    exit(1);
  }
  return begin + pages_of(size) - size;
}

void guarded_free(void *bytes, size_t size)
{
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  munmap((uint8_t *)bytes + size - pages_of(size), pages_of(size) + page);
}

RcsCameraInfo pinhole(uint32_t width, uint32_t height)
{
  RcsCameraInfo info = { 0 };
  const double cx = width / 2.0, cy = height / 2.0;
  const double k[9] = { 500, 0, cx, 0, 500, cy, 0, 0, 1 };
  const double p[12] = { 500, 0, cx, 0, 0, 500, cy, 0, 0, 0, 1, 0 };
  info.width = width;
  info.height = height;
  info.distortion_model = "plumb_bob";
  memcpy(info.k, k, sizeof k);
  memcpy(info.p, p, sizeof p);
  return info;
}

RcsCameraInfo bent(uint32_t width, uint32_t height)
{
  static const double d[5] = { -0.2, 0.03, 0.001, -0.002, 0.0 };
  RcsCameraInfo info = pinhole(width, height);
  info.d = d;
  info.d_length = 5;
  return info;
}

int main(void)
{
  test_texts();
  test_cameras();
  test_pictures();
  test_depths();
  test_pacing();
  test_statistics();
  test_configs();
  test_threads();
  printf("all passed with version %s\n", rcs_version());
  return 0;
}
