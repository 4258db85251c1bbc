/* Checks that end the program, and buffers right before a protected page, so that one byte too many ends it, too. */
#ifndef RCS_TEST_CHECK_H
#define RCS_TEST_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rviz_camera_stream/core.h"

#define CHECK(condition)                                                                  \
  do                                                                                      \
  {                                                                                       \
    if (!(condition))                                                                     \
    {                                                                                     \
      char check_text[500];                                                               \
      rcs_last_error(check_text, sizeof check_text);                                      \
      fprintf(stderr, "%s:%d: %s; last error: %s\n", __FILE__, __LINE__, #condition, check_text); \
      exit(1);                                                                            \
    }                                                                                     \
  } while (0)

/* Checks that the call fails with this result, and that the error contains these words. */
#define CHECK_FAILS(call, wanted, words)                  \
  do                                                      \
  {                                                       \
    CHECK((call) == (wanted));                            \
    CHECK(strstr(last_error(), (words)) != NULL);         \
  } while (0)

/* Error of the last failed call; valid until the next call of this function on this thread. */
const char *last_error(void);

/* `size` bytes right before a protected page. Freed by guarded_free. */
void *guarded(size_t size);
void guarded_free(void *bytes, size_t size);

/* A CameraInfo of this size with one focal length of 500 px and its centre in the middle. */
RcsCameraInfo pinhole(uint32_t width, uint32_t height);

/* A CameraInfo like `pinhole`, with a plumb_bob lens. */
RcsCameraInfo bent(uint32_t width, uint32_t height);

void test_texts(void);
void test_cameras(void);
void test_pictures(void);
void test_depths(void);
void test_pacing(void);
void test_statistics(void);
void test_configs(void);
void test_threads(void);

#endif
