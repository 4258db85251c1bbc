/* Depth buffers to metres. */
#include "check.h"

#include <math.h>

static void test_metres(RcsCamera *camera)
{
  const RcsCameraInfo info = pinhole(3, 2);
  RcsView view;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, 0.5, &view) == RCS_RESULT_OK);
  float *depth = guarded(6 * sizeof(float)), *out = guarded(6 * sizeof(float));
  /* As the projection makes them of 2, 4 and 8 metres. */
  const double metres[3] = { 2, 4, 8 };
  for (int i = 0; i < 3; ++i)
  {
    const double z = -metres[i];
    depth[i] = (float)(0.5 + 0.5 * (view.clip_from_view[10] * z + view.clip_from_view[11]) / metres[i]);
    depth[3 + i] = 1;
  }
  for (int bottom_up = 0; bottom_up < 2; ++bottom_up)
  {
    CHECK(rcs_camera_encode_depth(camera, depth, 6, bottom_up, out, 6) == RCS_RESULT_OK);
    for (int i = 0; i < 3; ++i)
    {
      CHECK(fabs(out[3 * bottom_up + i] - metres[i]) < 1e-4);
      CHECK(isnan(out[3 - 3 * bottom_up + i]));
    }
  }
  const size_t counts[] = { 0, 5, 7, SIZE_MAX, SIZE_MAX / 4 + 1 };
  for (size_t i = 0; i < 5; ++i)
  {
    CHECK_FAILS(rcs_camera_encode_depth(camera, depth, counts[i], true, out, 6), RCS_RESULT_BAD_LENGTH, "depth_count is");
    CHECK_FAILS(rcs_camera_encode_depth(camera, depth, 6, true, out, counts[i]), RCS_RESULT_BAD_LENGTH, "out_count is");
  }
  CHECK_FAILS(rcs_camera_encode_depth(camera, NULL, 6, true, out, 6), RCS_RESULT_NULL_POINTER, "depth is NULL");
  CHECK_FAILS(rcs_camera_encode_depth(camera, depth, 6, true, NULL, 6), RCS_RESULT_NULL_POINTER, "out is NULL");
  CHECK_FAILS(rcs_camera_encode_depth(NULL, depth, 6, true, out, 6), RCS_RESULT_NULL_POINTER, "camera is NULL");
  CHECK_FAILS(rcs_camera_encode_depth(camera, depth, 6, true, depth, 6), RCS_RESULT_BAD_VALUE, "overlaps");
  float *askew = (float *)((char *)out - 2);
  CHECK_FAILS(rcs_camera_encode_depth(camera, depth, 6, true, askew, 6), RCS_RESULT_BAD_VALUE, "out is not aligned");
  guarded_free(depth, 6 * sizeof(float));
  guarded_free(out, 6 * sizeof(float));
}

static void test_lens(RcsCamera *camera)
{
  const RcsCameraInfo info = bent(64, 48);
  RcsView view;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.5, &view) == RCS_RESULT_OK);
  const size_t count = (size_t)view.drawn_width * view.drawn_height;
  float *depth = guarded(count * sizeof(float)), *out = guarded(64 * 48 * sizeof(float));
  for (size_t i = 0; i < count; ++i)
    depth[i] = i < count / 2 ? 0 : 2;
  CHECK(rcs_camera_encode_depth(camera, depth, count, true, out, 64 * 48) == RCS_RESULT_OK);
  /* The lower half of the buffer is the lower half of the picture. */
  CHECK(isnan(out[5 * 64 + 32]) && fabsf(out[43 * 64 + 32] - 0.5F) < 1e-6F);
  guarded_free(depth, count * sizeof(float));
  guarded_free(out, 64 * 48 * sizeof(float));
}

void test_depths(void)
{
  RcsCamera *camera = rcs_camera_new();
  float depth = 0, out = 0;
  CHECK_FAILS(rcs_camera_encode_depth(camera, &depth, 1, true, &out, 1), RCS_RESULT_NO_CAMERA_INFO, "CameraInfo");
  test_metres(camera);
  test_lens(camera);
  rcs_camera_free(camera);
}
