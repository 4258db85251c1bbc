/* The version, the last error, and encodings by name and number. */
#include "check.h"

static void test_encodings(void)
{
  static const char *const names[] = { "rgb8", "rgba8", "bgr8", "bgra8", "mono8", "mono16" };
  static const size_t bytes[] = { 3, 4, 3, 4, 1, 2 };
  for (int number = RCS_ENCODING_RGB8; number <= RCS_ENCODING_MONO16; ++number)
  {
    const RcsEncoding encoding = (RcsEncoding)number;
    RcsEncoding found = RCS_ENCODING_RGB8;
    CHECK(strcmp(rcs_encoding_name(encoding), names[number]) == 0);
    CHECK(rcs_encoding_bytes_per_pixel(encoding) == bytes[number]);
    CHECK(rcs_encoding_from_name(names[number], &found) == RCS_RESULT_OK && found == encoding);
  }
  const int numbers[] = { 6, 1000000, -1 };
  for (size_t i = 0; i < 3; ++i)
  {
    CHECK(rcs_encoding_name((RcsEncoding)numbers[i]) == NULL);
    CHECK(rcs_encoding_bytes_per_pixel((RcsEncoding)numbers[i]) == 0);
  }
  RcsEncoding untouched = RCS_ENCODING_BGRA8;
  CHECK_FAILS(rcs_encoding_from_name("yuv422", &untouched), RCS_RESULT_BAD_VALUE, "unknown encoding 'yuv422'");
  CHECK_FAILS(rcs_encoding_from_name(NULL, &untouched), RCS_RESULT_NULL_POINTER, "name is NULL");
  CHECK_FAILS(rcs_encoding_from_name("rgb8", NULL), RCS_RESULT_NULL_POINTER, "encoding is NULL");
  CHECK(untouched == RCS_ENCODING_BGRA8);
}

/* Long texts are cut at the end of a character. */
static void test_buffers(void)
{
  RcsEncoding encoding = RCS_ENCODING_RGB8;
  CHECK(rcs_encoding_from_name("\xe2\x89\xa0\xe2\x89\xa0", &encoding) == RCS_RESULT_BAD_VALUE);
  char whole[200];
  const size_t length = rcs_last_error(whole, sizeof whole);
  CHECK(length == strlen(whole) && strncmp(whole, "unknown encoding '\xe2\x89\xa0\xe2\x89\xa0'", 24) == 0);
  CHECK(rcs_last_error(NULL, 0) == length);
  for (size_t room = 1; room <= length + 2; ++room)
  {
    char *buffer = guarded(room);
    memset(buffer, '#', room);
    CHECK(rcs_last_error(buffer, room) == length);
    CHECK(strncmp(buffer, whole, strlen(buffer)) == 0);
    /* At most the two other bytes of a character are missing. */
    CHECK(strlen(buffer) < room && (strlen(buffer) + 3 >= room || strlen(buffer) == length));
    CHECK(((unsigned char)whole[strlen(buffer)] & 0xc0) != 0x80);
    guarded_free(buffer, room);
  }
  char *exact = guarded(length + 1);
  CHECK(rcs_last_error(exact, SIZE_MAX) == length && strcmp(exact, whole) == 0);
  guarded_free(exact, length + 1);
  CHECK(rcs_last_error(NULL, 20) == 0);
  CHECK(strcmp(last_error(), "buffer is NULL") == 0);
}

void test_texts(void)
{
  CHECK(strcmp(last_error(), "") == 0);
  CHECK(strlen(rcs_version()) >= 5 && rcs_version() == rcs_version());
  test_encodings();
  test_buffers();
}
