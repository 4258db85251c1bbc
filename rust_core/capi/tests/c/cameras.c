/* Valid and invalid CameraInfos, and their views. */
#include "check.h"

#include <math.h>

static bool is_near(double a, double b)
{
  return fabs(a - b) < 1e-9;
}

static void test_view(RcsCamera *camera)
{
  RcsCameraInfo info = pinhole(640, 480);
  info.p[3] = -50;
  RcsView view;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(view.drawn_width == 640 && view.drawn_height == 480 && view.image_width == 640 && view.image_height == 480);
  CHECK(is_near(view.optical_from_eye[0], 0.1) && is_near(view.optical_from_eye[1], 0) && view.optical_from_eye[2] == 0);
  CHECK(is_near(view.near_m, 0.05) && is_near(view.far_m, 100));
  const double far_m = 100, near_m = 0.05;
  const double wanted[16] = { 2.0 * 500 / 640, 0, 0, 0, 0, 2.0 * 500 / 480, 0, 0, 0, 0, -(far_m + near_m) / (far_m - near_m),
                              -2 * far_m * near_m / (far_m - near_m), 0, 0, -1, 0 };
  for (int i = 0; i < 16; ++i)
    CHECK(is_near(view.clip_from_view[i], wanted[i]));
  CHECK(rcs_camera_warning(camera, NULL, 0) == 0);

  /* P counts from the centre of the first pixel, unlike rviz. */
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_EXACT, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(is_near(view.clip_from_view[2], -1.0 / 640) && is_near(view.clip_from_view[6], 1.0 / 480));
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, -3, &view) == RCS_RESULT_OK && view.near_m > 0);
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, 1e300, &view) == RCS_RESULT_OK && view.near_m < 100);
}

static void test_warnings(RcsCamera *camera)
{
  RcsCameraInfo info = pinhole(640, 480);
  RcsView view;
  char text[600];
  info.p[5] = 400;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(rcs_camera_warning(camera, text, sizeof text) == strlen(text) && strstr(text, "differ by 20.00 %"));
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_EXACT, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(rcs_camera_warning(camera, text, sizeof text) == 0 && text[0] == 0);
  CHECK(rcs_camera_warning(NULL, text, sizeof text) == 0);
}

static void test_lens(RcsCamera *camera)
{
  RcsCameraInfo info = bent(640, 480);
  RcsView view;
  char text[600];
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(view.drawn_width == 640);
  CHECK(rcs_camera_warning(camera, text, sizeof text) > 0 && strstr(text, "Undistort allows for it"));
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  CHECK(view.drawn_width > 650 && view.drawn_height > 490 && view.image_width == 640 && view.image_height == 480);
  CHECK(rcs_camera_warning(camera, text, sizeof text) == 0);

  /* A lens that cannot be corrected: the picture is drawn without it. */
  info.k[8] = 0;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  CHECK(view.drawn_width == 640);
  CHECK(rcs_camera_warning(camera, text, sizeof text) > 0 && strstr(text, "K: its last row"));
  /* A skew is corrected. */
  info = bent(640, 480);
  info.k[1] = 3;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  CHECK(view.drawn_width > 650 && rcs_camera_warning(camera, text, sizeof text) == 0);
  info = bent(640, 480);
  info.distortion_model = "fish\xff";
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  CHECK(rcs_camera_warning(camera, text, sizeof text) > 0 && strstr(text, "distortion_model: 'fish"));
}

static void test_refusals(RcsCamera *camera)
{
  const RcsCameraInfo good = pinhole(640, 480);
  RcsCameraInfo info = good;
  RcsView view, before;
  memset(&view, 77, sizeof view);
  before = view;
#define REFUSED(result, words)                                                                            \
  do                                                                                                      \
  {                                                                                                       \
    CHECK_FAILS(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view), result, words); \
    CHECK(memcmp(&view, &before, sizeof view) == 0);                                                      \
    info = good;                                                                                          \
  } while (0)

  info.width = 0;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "width is 0");
  info.height = UINT32_MAX;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "height is 4294967295, larger than 16384");
  info.p[0] = 0;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "P[0] (a focal length) is 0");
  info.p[6] = NAN;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "P[6] is NaN");
  info.p[0] = info.p[5] = 1e300;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "P is too large");
  info.p[3] = 1e300;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "P is too large");
  info.k[8] = INFINITY;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "K[8] is inf");
  info.r[2] = NAN;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "R[2] is NaN");
  const double nan = NAN;
  info.d = &nan;
  info.d_length = 1;
  REFUSED(RCS_RESULT_BAD_CAMERA_INFO, "D[0] is NaN");
  info.d_length = 1;
  REFUSED(RCS_RESULT_NULL_POINTER, "info.d is NULL");
  const size_t lengths[] = { 1025, SIZE_MAX / 8, SIZE_MAX / 8 + 1, SIZE_MAX };
  for (size_t i = 0; i < 4; ++i)
  {
    info.d = &nan;
    info.d_length = lengths[i];
    REFUSED(RCS_RESULT_BAD_LENGTH, "info.d_length");
  }
  info.d = (const double *)((const char *)&nan + 1);
  info.d_length = 1;
  REFUSED(RCS_RESULT_BAD_VALUE, "info.d is not aligned");
  info.distortion_model = NULL;
  REFUSED(RCS_RESULT_NULL_POINTER, "info.distortion_model is NULL");
#undef REFUSED

  const RcsProjection wrong[] = { (RcsProjection)2, (RcsProjection)-1 };
  for (size_t i = 0; i < 2; ++i)
    CHECK_FAILS(rcs_camera_set_info(camera, &good, wrong[i], false, 0.05, &view), RCS_RESULT_BAD_VALUE, "RcsProjection");
  CHECK_FAILS(rcs_camera_set_info(camera, &good, RCS_PROJECTION_RVIZ, false, NAN, &view), RCS_RESULT_BAD_VALUE, "near");
  CHECK_FAILS(rcs_camera_set_info(NULL, &good, RCS_PROJECTION_RVIZ, false, 1, &view), RCS_RESULT_NULL_POINTER, "camera");
  CHECK_FAILS(rcs_camera_set_info(camera, NULL, RCS_PROJECTION_RVIZ, false, 1, &view), RCS_RESULT_NULL_POINTER, "info");
  CHECK_FAILS(rcs_camera_set_info(camera, &good, RCS_PROJECTION_RVIZ, false, 1, NULL), RCS_RESULT_NULL_POINTER, "view");
  CHECK(memcmp(&view, &before, sizeof view) == 0);
}

/* An invalid CameraInfo leaves none, as clearing does. */
static void test_clearing(RcsCamera *camera)
{
  const RcsCameraInfo good = pinhole(8, 8);
  RcsCameraInfo bad = good;
  bad.width = 0;
  RcsView view;
  float depth[64] = { 0 }, out[64];
  CHECK(rcs_camera_set_info(camera, &good, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(rcs_camera_encode_depth(camera, depth, 64, false, out, 64) == RCS_RESULT_OK);
  rcs_camera_clear_info(camera);
  CHECK_FAILS(rcs_camera_encode_depth(camera, depth, 64, false, out, 64), RCS_RESULT_NO_CAMERA_INFO, "no valid CameraInfo");
  CHECK(rcs_camera_set_info(camera, &good, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_OK);
  CHECK(rcs_camera_set_info(camera, &bad, RCS_PROJECTION_RVIZ, false, 0.05, &view) == RCS_RESULT_BAD_CAMERA_INFO);
  CHECK(rcs_camera_encode_depth(camera, depth, 64, false, out, 64) == RCS_RESULT_NO_CAMERA_INFO);
  CHECK(rcs_camera_warning(camera, NULL, 0) == 0);
  rcs_camera_clear_info(NULL);
}

void test_cameras(void)
{
  RcsCamera *camera = rcs_camera_new();
  CHECK(camera != NULL);
  test_view(camera);
  test_warnings(camera);
  test_lens(camera);
  test_refusals(camera);
  test_clearing(camera);
  rcs_camera_free(camera);
  rcs_camera_free(NULL);
}
