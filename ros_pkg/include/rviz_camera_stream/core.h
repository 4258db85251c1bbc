/* The Rust core's C interface: what rviz's CameraPub plugin takes from it.
 *
 * Generated from rust_core/capi by cbindgen. To write it again:
 * RCS_WRITE_HEADER=1 cargo test --release -p rcs_capi --test header
 *
 * Handles. An RcsCamera is used by one thread at a time; different ones by different threads at once. All other
 * functions may be called by any thread at any time.
 *
 * Pointers. The caller owns all memory but the handles, and nothing is kept after a call. Each pointer may be NULL:
 * where it is needed, the call fails with RCS_RESULT_NULL_POINTER (or returns 0, false or nothing where it has no
 * result) and writes nothing. Static texts are never freed. Numbers are those of the machine's byte order.
 *
 * Errors. A call that returns an RcsResult says by it whether it succeeded. rcs_last_error has the reason why the
 * last call on the same thread that failed did so, those without a result included. No call ends the process or
 * throws, but for a lack of memory, which ends the process.
 *
 * Linking. The library is librcs_capi.a; beside it: -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc. A shared library
 * that links it should keep its symbols to itself and leave out what it does not call, which makes it 1 MB larger
 * instead of 6: -Wl,--exclude-libs,librcs_capi.a -Wl,--gc-sections.
 */

#ifndef RVIZ_CAMERA_STREAM_CORE_H
#define RVIZ_CAMERA_STREAM_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * What a call came to. After anything but `RCS_RESULT_OK`, `rcs_last_error` has the reason in words, and nothing was
 * written through the call's pointers.
 */
typedef enum RcsResult {
  /**
   * Done.
   */
  RCS_RESULT_OK = 0,
  /**
   * A pointer that is needed is NULL.
   */
  RCS_RESULT_NULL_POINTER,
  /**
   * A length is not what the sizes need, or more than a memory holds.
   */
  RCS_RESULT_BAD_LENGTH,
  /**
   * A number is none of those that it may be, a pointer is not aligned, or two buffers overlap.
   */
  RCS_RESULT_BAD_VALUE,
  /**
   * A field of the CameraInfo makes drawing impossible.
   */
  RCS_RESULT_BAD_CAMERA_INFO,
  /**
   * There is no valid CameraInfo: none was set, the last one was refused, or it was cleared.
   */
  RCS_RESULT_NO_CAMERA_INFO,
  /**
   * The text is no `.rviz` file.
   */
  RCS_RESULT_BAD_CONFIG,
  /**
   * A fault of this library. The handle may be used further; please report it.
   */
  RCS_RESULT_PANIC,
} RcsResult;

/**
 * The encodings of a published picture, by the names of `sensor_msgs/image_encodings`, in the order of the property's
 * menu.
 */
typedef enum RcsEncoding {
  /**
   * Red, green, blue.
   */
  RCS_ENCODING_RGB8 = 0,
  /**
   * Red, green, blue, alpha (always 255).
   */
  RCS_ENCODING_RGBA8,
  /**
   * Blue, green, red.
   */
  RCS_ENCODING_BGR8,
  /**
   * Blue, green, red, alpha (always 255).
   */
  RCS_ENCODING_BGRA8,
  /**
   * The red channel.
   */
  RCS_ENCODING_MONO8,
  /**
   * The red channel in 16 bits, little endian.
   */
  RCS_ENCODING_MONO16,
} RcsEncoding;

/**
 * How P becomes a projection.
 */
typedef enum RcsProjection {
  /**
   * As rviz's CameraPub draws: one focal length for both axes, P[7] upwards.
   */
  RCS_PROJECTION_RVIZ = 0,
  /**
   * As P says, to the pixel.
   */
  RCS_PROJECTION_EXACT,
} RcsProjection;

/**
 * In which order the four bytes of a pixel stand in memory. The fourth is not looked at.
 */
typedef enum RcsPixelOrder {
  /**
   * Red, green, blue, alpha.
   */
  RCS_PIXEL_ORDER_RGBA = 0,
  /**
   * Blue, green, red, alpha.
   */
  RCS_PIXEL_ORDER_BGRA,
} RcsPixelOrder;

/**
 * One for each CameraPub display. It holds no thread and no file, and is used by one thread at a time; different
 * ones by different threads at once.
 */
typedef struct RcsCamera RcsCamera;

/**
 * The fields of a `sensor_msgs/CameraInfo` that say how a camera projects. The caller owns what is pointed to;
 * nothing of it is kept after the call.
 */
typedef struct RcsCameraInfo {
  /**
   * Pixels in a row, 1 to 16384.
   */
  uint32_t width;
  /**
   * Rows, 1 to 16384.
   */
  uint32_t height;
  /**
   * The model of D, such as `"plumb_bob"`; ends with a NUL, not NULL.
   */
  const char *distortion_model;
  /**
   * The coefficients D; may be NULL where `d_length` is 0.
   */
  const double *d;
  /**
   * How many coefficients there are, 1024 at most.
   */
  size_t d_length;
  /**
   * K, 3×3 row by row, pixels.
   */
  double k[9];
  /**
   * R, 3×3 row by row; all 0: not set.
   */
  double r[9];
  /**
   * P, 3×4 row by row, pixels.
   */
  double p[12];
  /**
   * `binning_x`. Binning and region of interest are not applied, and `rcs_camera_warning` says so: the picture is
   * the whole one, and so must be the CameraInfo that is published with it (these fields 0).
   */
  uint32_t binning_x;
  /**
   * `binning_y`.
   */
  uint32_t binning_y;
  /**
   * `roi.x_offset`.
   */
  uint32_t roi_x_offset;
  /**
   * `roi.y_offset`.
   */
  uint32_t roi_y_offset;
  /**
   * `roi.width`; 0 for the whole picture.
   */
  uint32_t roi_width;
  /**
   * `roi.height`; 0 for the whole picture.
   */
  uint32_t roi_height;
} RcsCameraInfo;

/**
 * The view to be drawn for a CameraInfo. Where that describes a mirrored picture (negative focal lengths), the texture
 * has none of it: `rcs_camera_encode` and `rcs_camera_encode_depth` flip what was drawn.
 */
typedef struct RcsView {
  /**
   * Width of the texture to draw, pixels: that of the picture, or another where a lens is allowed for. At most
   * 16384.
   */
  uint32_t drawn_width;
  /**
   * Its height, pixels.
   */
  uint32_t drawn_height;
  /**
   * Width of the picture that is published, pixels: that of the CameraInfo.
   */
  uint32_t picture_width;
  /**
   * Its height, pixels.
   */
  uint32_t picture_height;
  /**
   * The projection of the texture, as OpenGL's, row by row: from the view frame (x right, y up, looking along -z,
   * metres) to clip coordinates with depths from -w to w.
   */
  double clip_from_view[16];
  /**
   * The eye in the CameraInfo's optical frame (x right, y down, z forward), metres: not 0 where P has Tx or Ty.
   */
  double optical_from_eye[3];
  /**
   * Nearer than this nothing is drawn, metres along the optical axis: the near clip distance that was given, moved
   * into what is possible.
   */
  double near_m;
  /**
   * Farther than this nothing is drawn, metres.
   */
  double far_m;
} RcsView;

/**
 * A drawn picture as it was read back, four bytes for each pixel. The caller owns it; nothing is kept after the call.
 */
typedef struct RcsPixels {
  /**
   * The first pixel of the first row in memory.
   */
  const uint8_t *data;
  /**
   * How many bytes there are from `data` on; those after the last row's last pixel are not read.
   */
  size_t length;
  /**
   * Pixels of a row: the view's `drawn_width`.
   */
  uint32_t width;
  /**
   * Rows: the view's `drawn_height`.
   */
  uint32_t height;
  /**
   * Bytes from the beginning of a row to that of the next one in memory, at least four for each pixel.
   */
  size_t row_bytes;
  /**
   * The order of a pixel's bytes.
   */
  enum RcsPixelOrder order;
  /**
   * The first row in memory is the picture's lowest one, as OpenGL reads back.
   */
  bool bottom_up;
} RcsPixels;

/**
 * When the steps of one picture were done: nanoseconds of the clock that is used with `rcs_camera_due`.
 */
typedef struct RcsTimes {
  /**
   * Drawing began.
   */
  uint64_t begun_ns;
  /**
   * It was drawn.
   */
  uint64_t drawn_ns;
  /**
   * Its pixels were read back.
   */
  uint64_t read_ns;
  /**
   * It was converted and published.
   */
  uint64_t published_ns;
} RcsTimes;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of this library, such as `"1.0.0"`; static, never NULL.
 */
const char *rcs_version(void);

/**
 * Writes why the last call on this thread that failed did so: one line in UTF-8. `buffer` gets at most `length`
 * bytes, the NUL at the end included, cut where a character ends; it may be NULL where `length` is 0. Returns the
 * length of the whole text without its NUL, as `snprintf` does: 0 if no call has failed yet. Calls that succeed
 * leave the text alone.
 */
size_t rcs_last_error(char *buffer, size_t length);

/**
 * Bytes of one pixel in an encoding; 0 for a number that is none.
 */
size_t rcs_encoding_bytes_per_pixel(enum RcsEncoding encoding);

/**
 * The name of an encoding, such as `"rgb8"`; static, NULL for a number that is none.
 */
const char *rcs_encoding_name(enum RcsEncoding encoding);

/**
 * Writes the encoding of a name. `RCS_RESULT_BAD_VALUE` for any other text than the six names.
 */
enum RcsResult rcs_encoding_from_name(const char *name, enum RcsEncoding *encoding);

/**
 * A camera without a CameraInfo, for which a picture is due at each call. The caller gives it back to
 * `rcs_camera_free`. NULL only after a fault of this library.
 */
struct RcsCamera *rcs_camera_new(void);

/**
 * Frees a camera; NULL is allowed. No pointer to it may be used afterwards.
 */
void rcs_camera_free(struct RcsCamera *camera);

/**
 * Sets the camera's CameraInfo: checks it as the node does, and writes what is to be drawn for it to `view`.
 * `undistort`: where D is not 0, or the lens is equidistant, the picture is bent so that it is right after the lens of
 * K and D; the texture is larger then, and P is taken exactly whatever `projection` says. A lens that cannot be
 * allowed for is no error: the picture is drawn without it, and `rcs_camera_warning` says why. `near_clip_m`: metres,
 * moved into what is possible (1e-6 to 99.9).
 *
 * A lens takes up to some tenths of a second, once: the same CameraInfo again costs less than a microsecond.
 *
 * `RCS_RESULT_BAD_CAMERA_INFO`: `rcs_last_error` names the field and what is wrong, such as "P[0] (a focal length)
 * is 0". After any failure but a camera that is NULL, the camera has no CameraInfo, as after
 * `rcs_camera_clear_info`.
 */
enum RcsResult rcs_camera_set_info(struct RcsCamera *camera,
                                   const struct RcsCameraInfo *info,
                                   enum RcsProjection projection,
                                   bool undistort,
                                   double near_clip_m,
                                   struct RcsView *view);

/**
 * Forgets the CameraInfo: pictures cannot be encoded until the next one is set. NULL is allowed.
 */
void rcs_camera_clear_info(struct RcsCamera *camera);

/**
 * Writes what makes a projection of the picture miss its objects, as the node's status Camera Info warns: fx ≠ fy,
 * P[7] ≠ 0, skews, a mirror and a third row of P where rviz's projection is drawn, D ≠ 0 where the lens is not allowed
 * for, each with its size in pixels; why a lens could not be allowed for; and that binning and a region of interest
 * are not applied. Empty where nothing does, and without a CameraInfo. Buffer and returned length are as those of
 * `rcs_last_error`.
 */
size_t rcs_camera_warning(const struct RcsCamera *camera,
                          char *buffer,
                          size_t length);

/**
 * Sets how often a picture is due, in pictures a second. Below 0: at each call of `rcs_camera_due`, which is made
 * once per frame of rviz's window. 0, or NaN: only when triggered. Above 0: in the long run exactly that often, or
 * at each call if there are fewer calls. NULL is allowed.
 */
void rcs_camera_set_frame_rate(struct RcsCamera *camera, float frame_rate_hz);

/**
 * Makes one picture due at the next call of `rcs_camera_due`, whatever the frame rate and whether anybody watches,
 * and at those after it until `rcs_camera_begin`. NULL is allowed.
 */
void rcs_camera_trigger(struct RcsCamera *camera);

/**
 * Whether a picture is due now; to be called once per frame of the window, because how often it is called counts.
 * `watched`: somebody subscribes to the picture; if nobody does, only a triggered one is due. After a pause a
 * picture is due at once, and no burst follows. False for NULL.
 */
bool rcs_camera_due(struct RcsCamera *camera, uint64_t now_ns, bool watched);

/**
 * Says that a picture is being drawn: takes the trigger, and times the next picture. NULL is allowed.
 */
void rcs_camera_begin(struct RcsCamera *camera, uint64_t now_ns);

/**
 * Writes a drawn picture in an encoding of `sensor_msgs/Image` to `out`: rows from the top, without padding. Where the
 * view has a lens, the picture is bent by it, and what the lens does not show has the background's colour. Where the
 * CameraInfo describes a mirrored picture, it is flipped.
 *
 * `pixels` has the size that the view says is drawn; `out_length` is exactly the picture's width · height ·
 * `rcs_encoding_bytes_per_pixel`, else `RCS_RESULT_BAD_LENGTH`. `background_rgb` points to three bytes. `out` must not
 * overlap `pixels` (`RCS_RESULT_BAD_VALUE`). `RCS_RESULT_NO_CAMERA_INFO` without a CameraInfo.
 */
enum RcsResult rcs_camera_encode(struct RcsCamera *camera,
                                 const struct RcsPixels *pixels,
                                 enum RcsEncoding encoding,
                                 const uint8_t *background_rgb,
                                 uint8_t *out,
                                 size_t out_length);

/**
 * Writes what a depth buffer holds as metres along the optical axis, as a `32FC1` image: rows from the top; NaN
 * where nothing was drawn, as on the node's depth topic. Where the view has a lens, each pixel has the depth of the
 * one that is nearest to where the lens sends it. It is flipped as the picture is.
 *
 * `depth` has the view's drawn width · height values without padding, 0 at the view's `near_m` and 1 at its `far_m`,
 * with the lowest row first if `bottom_up`; `out_count` is the picture's width · height. Other counts are
 * `RCS_RESULT_BAD_LENGTH`, buffers that overlap or are not aligned `RCS_RESULT_BAD_VALUE`.
 */
enum RcsResult rcs_camera_encode_depth(struct RcsCamera *camera,
                                       const float *depth,
                                       size_t depth_count,
                                       bool bottom_up,
                                       float *out,
                                       size_t out_count);

/**
 * Records a published picture. `RCS_RESULT_BAD_VALUE` if a step is before the one that precedes it.
 */
enum RcsResult rcs_camera_record(struct RcsCamera *camera, const struct RcsTimes *times);

/**
 * Writes one line about the last hundred recorded pictures: how many a second, and of each step and of all together
 * the median and the 95th percentile in milliseconds. Empty before the first one. Buffer and returned length are as
 * those of `rcs_last_error`.
 */
size_t rcs_camera_statistics(const struct RcsCamera *camera, uint64_t now_ns, char *buffer, size_t length);

/**
 * Says what the node could not draw of a config, and how to start it.
 *
 * `yaml`, `yaml_length`: the text of a `.rviz` file in UTF-8 (64 MiB at most, else `RCS_RESULT_BAD_LENGTH`), which
 * need not end with a NUL. `path`: where the file is or will be; ends with a NUL. `report`: one line for each
 * display or setting that the node does not draw as rviz does, in the words of `camera_stream check`, separated by
 * newlines; empty if it draws all. `launch_line`: the roslaunch command that draws the config without rviz. Buffers
 * are filled as that of `rcs_last_error`, and the whole texts' lengths without NUL are written to `report_needed`
 * and `launch_line_needed`; `displays_not_drawn` gets the number of enabled displays that the node cannot draw. Each
 * of these pointers may be NULL (a buffer with the length 0). `RCS_RESULT_BAD_CONFIG` if the text is no `.rviz`
 * file.
 */
enum RcsResult rcs_config_report(const char *yaml,
                                 size_t yaml_length,
                                 const char *path,
                                 char *report,
                                 size_t report_length,
                                 size_t *report_needed,
                                 char *launch_line,
                                 size_t launch_line_length,
                                 size_t *launch_line_needed,
                                 uint32_t *displays_not_drawn);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RVIZ_CAMERA_STREAM_CORE_H */
