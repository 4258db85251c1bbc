/* Conversion of pixels, with and without a lens, and invalid lengths. */
#include "check.h"

enum
{
  WIDTH = 37,
  HEIGHT = 5,
  PADDING = 7,
  ROW = 4 * WIDTH + PADDING
};

static const uint8_t BACKGROUND[3] = { 1, 2, 3 };

/* The red, green and blue of a pixel, row 0 at the top. */
static void color(uint32_t column, uint32_t row, uint8_t rgb[3])
{
  rgb[0] = (uint8_t)(3 * column);
  rgb[1] = (uint8_t)(40 * row);
  rgb[2] = 200;
}

static void fill(uint8_t *data, RcsPixelOrder order, bool bottom_up)
{
  for (uint32_t row = 0; row < HEIGHT; ++row)
    for (uint32_t column = 0; column < WIDTH; ++column)
    {
      uint8_t rgb[3];
      color(column, row, rgb);
      uint8_t *pixel = data + (bottom_up ? HEIGHT - 1 - row : row) * ROW + 4 * column;
      for (int channel = 0; channel < 3; ++channel)
        pixel[order == RCS_PIXEL_ORDER_BGRA ? 2 - channel : channel] = rgb[channel];
      pixel[3] = 9;
    }
}

static void expect(const uint8_t *pixel, RcsEncoding encoding, const uint8_t rgb[3])
{
  switch (encoding)
  {
    case RCS_ENCODING_RGB8:
    case RCS_ENCODING_RGBA8:
      CHECK(memcmp(pixel, rgb, 3) == 0);
      break;
    case RCS_ENCODING_BGR8:
    case RCS_ENCODING_BGRA8:
      CHECK(pixel[0] == rgb[2] && pixel[1] == rgb[1] && pixel[2] == rgb[0]);
      break;
    default:
      CHECK(pixel[0] == rgb[0]);
  }
  if (encoding == RCS_ENCODING_RGBA8 || encoding == RCS_ENCODING_BGRA8)
    CHECK(pixel[3] == 255);
  if (encoding == RCS_ENCODING_MONO16)
    CHECK(pixel[1] == rgb[0]);
}

static void test_encodings(RcsCamera *camera)
{
  const RcsCameraInfo info = pinhole(WIDTH, HEIGHT);
  RcsView view;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  /* Without the padding after the last row. */
  const size_t length = (HEIGHT - 1) * ROW + 4 * WIDTH;
  uint8_t *data = guarded(length);
  for (int kind = 0; kind < 4 * 6; ++kind)
  {
    const RcsEncoding encoding = (RcsEncoding)(kind / 4);
    RcsPixels pixels = { data, length, WIDTH, HEIGHT, ROW, (RcsPixelOrder)(kind % 2), kind / 2 % 2 == 1 };
    fill(data, pixels.order, pixels.bottom_up);
    const size_t bytes = rcs_encoding_bytes_per_pixel(encoding), out_length = WIDTH * HEIGHT * bytes;
    uint8_t *out = guarded(out_length);
    CHECK(rcs_camera_encode(camera, &pixels, encoding, BACKGROUND, out, out_length) == RCS_RESULT_OK);
    for (uint32_t at = 0; at < WIDTH * HEIGHT; ++at)
    {
      uint8_t rgb[3];
      color(at % WIDTH, at / WIDTH, rgb);
      expect(out + at * bytes, encoding, rgb);
    }
    guarded_free(out, out_length);
  }
  guarded_free(data, length);
}

static void test_lengths(RcsCamera *camera)
{
  const size_t length = HEIGHT * ROW, out_length = WIDTH * HEIGHT * 3;
  uint8_t *data = guarded(length), *out = guarded(out_length);
  memset(data, 50, length);
  memset(out, 99, out_length);
  const RcsPixels good = { data, length, WIDTH, HEIGHT, ROW, RCS_PIXEL_ORDER_RGBA, true };
  RcsPixels pixels = good;
#define REFUSED(result, words)                                                                                        \
  do                                                                                                                  \
  {                                                                                                                   \
    CHECK_FAILS(rcs_camera_encode(camera, &pixels, RCS_ENCODING_RGB8, BACKGROUND, out, out_length), result, words); \
    pixels = good;                                                                                                    \
  } while (0)

  pixels.data = NULL;
  REFUSED(RCS_RESULT_NULL_POINTER, "pixels.data is NULL");
  pixels.width = WIDTH + 1;
  REFUSED(RCS_RESULT_BAD_LENGTH, "pixels are 38x5, where the view draws 37x5");
  pixels.height = UINT32_MAX;
  REFUSED(RCS_RESULT_BAD_LENGTH, "where the view draws 37x5");
  pixels.width = pixels.height = 0;
  REFUSED(RCS_RESULT_BAD_LENGTH, "pixels are 0x0");
  const size_t rows[] = { 0, 4 * WIDTH - 1, SIZE_MAX, SIZE_MAX / 4, SIZE_MAX / 4 + 1, SIZE_MAX / 8 };
  for (size_t i = 0; i < 6; ++i)
  {
    pixels.row_bytes = rows[i];
    REFUSED(RCS_RESULT_BAD_LENGTH, "pixels: ");
  }
  const size_t lengths[] = { 0, 1, (HEIGHT - 1) * ROW + 4 * WIDTH - 1 };
  for (size_t i = 0; i < 3; ++i)
  {
    pixels.length = lengths[i];
    REFUSED(RCS_RESULT_BAD_LENGTH, "need at least");
  }
  pixels.order = (RcsPixelOrder)2;
  REFUSED(RCS_RESULT_BAD_VALUE, "2 is no RcsPixelOrder");
#undef REFUSED
  const size_t outs[] = { 0, 1, out_length - 1, out_length + 1, SIZE_MAX };
  for (size_t i = 0; i < 5; ++i)
    CHECK_FAILS(rcs_camera_encode(camera, &good, RCS_ENCODING_RGB8, BACKGROUND, out, outs[i]), RCS_RESULT_BAD_LENGTH,
                "out_length is");
  CHECK_FAILS(rcs_camera_encode(NULL, &good, RCS_ENCODING_RGB8, BACKGROUND, out, out_length), RCS_RESULT_NULL_POINTER,
              "camera is NULL");
  CHECK_FAILS(rcs_camera_encode(camera, NULL, RCS_ENCODING_RGB8, BACKGROUND, out, out_length), RCS_RESULT_NULL_POINTER,
              "pixels is NULL");
  CHECK_FAILS(rcs_camera_encode(camera, &good, RCS_ENCODING_RGB8, NULL, out, out_length), RCS_RESULT_NULL_POINTER,
              "background_rgb is NULL");
  CHECK_FAILS(rcs_camera_encode(camera, &good, RCS_ENCODING_RGB8, BACKGROUND, NULL, out_length), RCS_RESULT_NULL_POINTER,
              "out is NULL");
  CHECK_FAILS(rcs_camera_encode(camera, &good, (RcsEncoding)77, BACKGROUND, out, out_length), RCS_RESULT_BAD_VALUE,
              "77 is no RcsEncoding");
  CHECK_FAILS(rcs_camera_encode(camera, &good, RCS_ENCODING_RGB8, BACKGROUND, data + 5, out_length), RCS_RESULT_BAD_VALUE,
              "overlaps");
  for (size_t i = 0; i < out_length; ++i)
    CHECK(out[i] == 99);
  /* A claimed length beyond the needed one is not read. */
  pixels.length = SIZE_MAX;
  CHECK(rcs_camera_encode(camera, &pixels, RCS_ENCODING_RGB8, BACKGROUND, out, out_length) == RCS_RESULT_BAD_LENGTH);
  guarded_free(data, length);
  guarded_free(out, out_length);
}

/* A lens does not change an even surface. */
static void test_lens(RcsCamera *camera)
{
  const RcsCameraInfo info = bent(64, 48);
  RcsView view;
  CHECK(rcs_camera_set_info(camera, &info, RCS_PROJECTION_RVIZ, true, 0.05, &view) == RCS_RESULT_OK);
  const size_t length = (size_t)4 * view.drawn_width * view.drawn_height, out_length = 64 * 48 * 3;
  uint8_t *data = guarded(length), *out = guarded(out_length);
  for (size_t i = 0; i < length; ++i)
    data[i] = (uint8_t)(10 * (i % 4));
  const RcsPixels pixels = { data,  length, view.drawn_width, view.drawn_height, (size_t)4 * view.drawn_width,
                             RCS_PIXEL_ORDER_BGRA, true };
  CHECK(rcs_camera_encode(camera, &pixels, RCS_ENCODING_RGB8, BACKGROUND, out, out_length) == RCS_RESULT_OK);
  const uint8_t surface[3] = { 20, 10, 0 };
  for (size_t i = 0; i < out_length; i += 3)
    CHECK(memcmp(out + i, surface, 3) == 0 || memcmp(out + i, BACKGROUND, 3) == 0);
  CHECK(memcmp(out + 3 * (24 * 64 + 32), surface, 3) == 0);
  guarded_free(data, length);
  guarded_free(out, out_length);
}

void test_pictures(void)
{
  RcsCamera *camera = rcs_camera_new();
  const RcsPixels none = { 0 };
  uint8_t out[3];
  CHECK_FAILS(rcs_camera_encode(camera, &none, RCS_ENCODING_RGB8, BACKGROUND, out, 3), RCS_RESULT_NO_CAMERA_INFO, "CameraInfo");
  test_encodings(camera);
  test_lengths(camera);
  test_lens(camera);
  rcs_camera_free(camera);
}
