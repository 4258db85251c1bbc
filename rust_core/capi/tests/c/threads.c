/* Many threads, each with a camera of its own, and each with errors of its own. */
#include "check.h"

#include <pthread.h>

enum
{
  THREADS = 8,
  ROUNDS = 20
};

static void *work(void *argument)
{
  const uint32_t number = *(const uint32_t *)argument;
  CHECK(strcmp(last_error(), "") == 0);
  for (uint32_t round = 0; round < ROUNDS; ++round)
  {
    RcsCamera *camera = rcs_camera_new();
    /* Sizes change, with and without a lens. */
    const uint32_t width = 16 + 8 * ((number + round) % 4);
    const RcsCameraInfo info = round % 2 ? bent(width, 20) : pinhole(width, 20);
    RcsView view;
    CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_EXACT, true, 0.1, &view) == RCS_RESULT_OK);
    const size_t row = (size_t)4 * view.drawn_width, length = row * view.drawn_height, out_length = (size_t)width * 20 * 3;
    uint8_t *data = calloc(1, length), *out = malloc(out_length);
    const RcsPixels pixels = { data, length, view.drawn_width, view.drawn_height, row, RCS_PIXEL_ORDER_RGBA, false };
    const uint8_t black[3] = { 0, 0, 0 };
    CHECK(rcs_camera_encode(camera, &pixels, RCS_ENCODING_RGB8, black, out, out_length) == RCS_RESULT_OK);
    for (size_t i = 0; i < out_length; ++i)
      CHECK(out[i] == 0);
    CHECK(rcs_camera_encode(camera, &pixels, (RcsEncoding)(100 + number), black, out, out_length) == RCS_RESULT_BAD_VALUE);
    char words[40];
    snprintf(words, sizeof words, "%u is no RcsEncoding", 100 + number);
    CHECK(strcmp(last_error(), words) == 0);
    free(data);
    free(out);
    rcs_camera_free(camera);
  }
  return NULL;
}

void test_threads(void)
{
  pthread_t threads[THREADS];
  uint32_t numbers[THREADS];
  for (uint32_t i = 0; i < THREADS; ++i)
  {
    numbers[i] = i;
    CHECK(pthread_create(&threads[i], NULL, work, &numbers[i]) == 0);
  }
  for (uint32_t i = 0; i < THREADS; ++i)
    CHECK(pthread_join(threads[i], NULL) == 0);
  /* A handle may go from one thread to another. */
  RcsCamera *camera = rcs_camera_new();
  rcs_camera_trigger(camera);
  CHECK(rcs_camera_due(camera, 1, false));
  rcs_camera_free(camera);
}
