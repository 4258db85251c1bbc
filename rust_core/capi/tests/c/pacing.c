/* Pacing and statistics. */
#include "check.h"

#include <math.h>

static const uint64_t MS = 1000000;

/* Pictures in ten seconds of thirty calls a second. */
static int pictures(RcsCamera *camera, float rate_hz, uint64_t begin_ns)
{
  rcs_camera_set_frame_rate(camera, rate_hz);
  int pictures = 0;
  for (uint64_t call = 0; call < 300; ++call)
  {
    const uint64_t now_ns = begin_ns + call * 100000000 / 3;
    if (rcs_camera_due(camera, now_ns, true))
    {
      rcs_camera_begin(camera, now_ns);
      ++pictures;
    }
  }
  return pictures;
}

void test_pacing(void)
{
  RcsCamera *camera = rcs_camera_new();
  CHECK(rcs_camera_due(camera, 0, true) && !rcs_camera_due(camera, 1, false));
  CHECK(pictures(camera, -1, 0) == 300);
  CHECK(pictures(camera, 0, 100000 * MS) == 0);
  CHECK(pictures(camera, NAN, 200000 * MS) == 0);
  CHECK(abs(pictures(camera, 20, 300000 * MS) - 200) <= 1);
  CHECK(abs(pictures(camera, 30, 400000 * MS) - 300) <= 1);
  CHECK(pictures(camera, INFINITY, 500000 * MS) == 300);
  CHECK(pictures(camera, 1e-40F, 600000 * MS) == 1);
  /* Triggered, without subscribers and rate. */
  rcs_camera_set_frame_rate(camera, 0);
  rcs_camera_trigger(camera);
  CHECK(rcs_camera_due(camera, 700000 * MS, false) && rcs_camera_due(camera, 700001 * MS, true));
  rcs_camera_begin(camera, 700001 * MS);
  CHECK(!rcs_camera_due(camera, 700002 * MS, true));
  /* Clocks that jump. */
  rcs_camera_set_frame_rate(camera, 10);
  const uint64_t times[] = { UINT64_MAX, 0, UINT64_MAX - 1, 5, UINT64_MAX };
  for (size_t i = 0; i < 5; ++i)
    if (rcs_camera_due(camera, times[i], true))
      rcs_camera_begin(camera, times[i]);
  rcs_camera_free(camera);
  rcs_camera_set_frame_rate(NULL, 1);
  rcs_camera_trigger(NULL);
  rcs_camera_begin(NULL, 1);
  CHECK(!rcs_camera_due(NULL, 1, true));
}

void test_statistics(void)
{
  RcsCamera *camera = rcs_camera_new();
  char text[300];
  CHECK(rcs_camera_statistics(camera, 0, text, sizeof text) == 0 && text[0] == 0);
  for (uint64_t i = 0; i < 200; ++i)
  {
    const uint64_t begun = i * 50 * MS;
    const RcsTimes times = { begun, begun + 3 * MS, begun + 4 * MS, begun + 6 * MS };
    CHECK(rcs_camera_record(camera, &times) == RCS_RESULT_OK);
  }
  const uint64_t now = 199 * 50 * MS + 6 * MS;
  CHECK(rcs_camera_statistics(camera, now, text, sizeof text) == strlen(text));
  CHECK(strcmp(text, "20.0 pictures/s; median / p95 ms of the last 100: draw 3.00 / 3.00, read back 1.00 / 1.00, "
                     "publish 2.00 / 2.00, whole 6.00 / 6.00") == 0);
  CHECK(rcs_camera_statistics(camera, UINT64_MAX, text, sizeof text) > 0 && strncmp(text, "0.0 ", 4) == 0);
  CHECK(rcs_camera_statistics(camera, 0, NULL, 0) > 100);
  const RcsTimes backwards[] = { { 2, 1, 3, 4 }, { 1, 3, 2, 4 }, { 1, 2, 4, 3 }, { UINT64_MAX, 0, 0, 0 } };
  for (size_t i = 0; i < 4; ++i)
    CHECK_FAILS(rcs_camera_record(camera, &backwards[i]), RCS_RESULT_BAD_VALUE, "a step is before");
  const RcsTimes ever = { 0, 0, 0, UINT64_MAX };
  CHECK(rcs_camera_record(camera, &ever) == RCS_RESULT_OK);
  CHECK_FAILS(rcs_camera_record(camera, NULL), RCS_RESULT_NULL_POINTER, "times is NULL");
  CHECK_FAILS(rcs_camera_record(NULL, &ever), RCS_RESULT_NULL_POINTER, "camera is NULL");
  CHECK(rcs_camera_statistics(NULL, 0, text, sizeof text) == 0);
  rcs_camera_free(camera);
}
