/* The Rust core's C interface for rviz's CameraPub plugin.
 *
 * Generated from rust_core/capi by cbindgen. To write it again:
 * RCS_WRITE_HEADER=1 cargo test --release -p rcs_capi --test header
 *
 * Handles. An RcsCamera is used by one thread at a time; different cameras by different threads at once. All other
 * functions may be called by any thread at any time.
 *
 * Pointers. The caller owns all memory except handles, and it is not used after a call. Each pointer may be NULL: if
 * it is required, the call fails with RCS_RESULT_NULL_POINTER (or returns 0, false or nothing if it has no result
 * code) and writes nothing. Static texts are never freed. Numbers have the machine's byte order.
 *
 * Errors. A call fails if it returns an RcsResult other than RCS_RESULT_OK. rcs_last_error has the error of the last
 * failed call on the same thread, also of calls without a result code. No call ends the process or throws, except that
 * a lack of memory ends the process.
 *
 * Linking. The library is librcs_capi.a, with -lgcc_s -lutil -lrt -lpthread -lm -ldl -lc. A shared library that links
 * it should hide its symbols and drop unused code, which makes it 1 MB larger instead of 6:
 * -Wl,--exclude-libs,librcs_capi.a -Wl,--gc-sections.
 */

#ifndef RVIZ_CAMERA_STREAM_CORE_H
#define RVIZ_CAMERA_STREAM_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * Result code of a call. After every code except `RCS_RESULT_OK`, `rcs_last_error` has the reason as text, and nothing
 * was written through the call's pointers.
 */
typedef enum RcsResult {
  /**
   * Success.
   */
  RCS_RESULT_OK = 0,
  /**
   * A required pointer is NULL.
   */
  RCS_RESULT_NULL_POINTER,
  /**
   * A length does not match the sizes, or is larger than memory.
   */
  RCS_RESULT_BAD_LENGTH,
  /**
   * A number is out of range, a buffer is not aligned, or two buffers overlap.
   */
  RCS_RESULT_BAD_VALUE,
  /**
   * A field of the CameraInfo is invalid.
   */
  RCS_RESULT_BAD_CAMERA_INFO,
  /**
   * There is no valid CameraInfo: none was set, the last one was invalid, or it was cleared.
   */
  RCS_RESULT_NO_CAMERA_INFO,
  /**
   * The text is no `.rviz` file.
   */
  RCS_RESULT_BAD_CONFIG,
  /**
   * A bug of this library; please report it. The handle can still be used.
   */
  RCS_RESULT_PANIC,
} RcsResult;

/**
 * The encodings of a published image, by the names of `sensor_msgs/image_encodings`, in the order of the property's
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
 * Rule for the projection of P.
 */
typedef enum RcsProjection {
  /**
   * As in rviz's CameraPub: one focal length for both axes, P[7] upwards.
   */
  RCS_PROJECTION_RVIZ = 0,
  /**
   * Exactly P, to the pixel.
   */
  RCS_PROJECTION_EXACT,
} RcsProjection;

/**
 * Order of the four bytes of a pixel in memory. The fourth is ignored.
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
 * The camera of a CameraPub display. It holds no thread and no file, and is used by one thread at a time; different
 * cameras by different threads at once.
 */
typedef struct RcsCamera RcsCamera;

/**
 * The fields of a `sensor_msgs/CameraInfo` that define the projection. The caller owns the memory behind its pointers,
 * which is not used after the call.
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
   * Number of coefficients, 1024 at most.
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
   * `binning_x`. Binning and region of interest are not applied, as `rcs_camera_warning` reports: publish the whole
   * image's CameraInfo with it (these fields 0).
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
   * `roi.width`; 0 for the whole image.
   */
  uint32_t roi_width;
  /**
   * `roi.height`; 0 for the whole image.
   */
  uint32_t roi_height;
} RcsCameraInfo;

/**
 * The view to draw for a CameraInfo. For a mirrored image (negative focal lengths) the texture is drawn unmirrored:
 * `rcs_camera_encode` and `rcs_camera_encode_depth` flip it.
 */
typedef struct RcsView {
  /**
   * Width of the texture to draw, pixels, at most 16384: the image's, or another one for a lens.
   */
  uint32_t drawn_width;
  /**
   * Height of the texture, pixels.
   */
  uint32_t drawn_height;
  /**
   * Width of the published image, pixels: the CameraInfo's.
   */
  uint32_t image_width;
  /**
   * Height of the published image, pixels.
   */
  uint32_t image_height;
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
   * Near clip distance along the optical axis, metres, clamped to the possible range.
   */
  double near_m;
  /**
   * Far clip distance, metres.
   */
  double far_m;
} RcsView;

/**
 * A drawn image as it was read back, four bytes for each pixel. The caller owns it; it is not used after the call.
 */
typedef struct RcsPixels {
  /**
   * The first pixel of the first row in memory.
   */
  const uint8_t *data;
  /**
   * Bytes from `data` on; bytes after the last row's last pixel are not read.
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
   * Bytes from the beginning of a row to the next one in memory, at least four for each pixel.
   */
  size_t row_bytes;
  /**
   * The order of a pixel's bytes.
   */
  enum RcsPixelOrder order;
  /**
   * True if the first row in memory is the image's lowest one, as OpenGL reads back.
   */
  bool bottom_up;
} RcsPixels;

/**
 * Times at which the steps of one image ended: nanoseconds of the clock that is used with `rcs_camera_due`.
 */
typedef struct RcsTimes {
  /**
   * Drawing began.
   */
  uint64_t begun_ns;
  /**
   * Drawing ended.
   */
  uint64_t drawn_ns;
  /**
   * The pixels were read back.
   */
  uint64_t read_ns;
  /**
   * The image was converted and published.
   */
  uint64_t published_ns;
} RcsTimes;

/**
 * A buffer of the caller for a text, filled as in `rcs_last_error`.
 */
typedef struct RcsText {
  /**
   * The buffer; may be NULL if `length` is 0.
   */
  char *buffer;
  /**
   * Bytes of the buffer.
   */
  size_t length;
  /**
   * Set by the call: length of the whole text without its NUL.
   */
  size_t needed;
} RcsText;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of this library, such as `"1.0.0"`; static, never NULL.
 */
const char *rcs_version(void);

/**
 * Writes the error of the last failed call on this thread: one line in UTF-8. `buffer` gets at most `length` bytes,
 * including the NUL, cut at the end of a character; it may be NULL if `length` is 0. Returns the length of the whole
 * text without its NUL, as `snprintf` does: 0 if no call has failed yet. Successful calls keep the text.
 */
size_t rcs_last_error(char *buffer, size_t length);

/**
 * Bytes of one pixel in an encoding; 0 for an invalid encoding.
 */
size_t rcs_encoding_bytes_per_pixel(enum RcsEncoding encoding);

/**
 * The name of an encoding, such as `"rgb8"`; static, NULL for an invalid encoding.
 */
const char *rcs_encoding_name(enum RcsEncoding encoding);

/**
 * Writes the encoding of a name. `RCS_RESULT_BAD_VALUE` for an unknown name.
 */
enum RcsResult rcs_encoding_from_name(const char *name, enum RcsEncoding *encoding);

/**
 * A camera without a CameraInfo, for which an image is due at each call. The caller frees it with `rcs_camera_free`.
 * NULL only after a bug of this library.
 */
struct RcsCamera *rcs_camera_new(void);

/**
 * Frees a camera; NULL is allowed. No pointer to it may be used afterwards.
 */
void rcs_camera_free(struct RcsCamera *camera);

/**
 * Sets the camera's CameraInfo: checks it as the node does, and writes the view to draw for it to `view`.
 * `undistort`: where D is not 0, or the lens is equidistant, the image is bent so that it is right after the lens of
 * K and D; the texture is larger then, and P is followed exactly at any `projection`. A lens that cannot be corrected
 * is no error: the image is drawn without it, and `rcs_camera_warning` has the reason. `near_clip_m`: metres,
 * clamped to 1e-6 to 99.9.
 *
 * A lens takes up to some tenths of a second, once: the same CameraInfo again costs less than a microsecond.
 *
 * `RCS_RESULT_BAD_CAMERA_INFO`: `rcs_last_error` names the field and its fault, such as "P[0] (a focal length) is 0".
 * After every failure except a NULL camera, the camera has no CameraInfo, as after `rcs_camera_clear_info`.
 */
enum RcsResult rcs_camera_set_info(struct RcsCamera *camera,
                                   const struct RcsCameraInfo *info,
                                   enum RcsProjection projection,
                                   bool undistort,
                                   double near_clip_m,
                                   struct RcsView *view);

/**
 * Forgets the CameraInfo: images cannot be encoded until the next one is set. NULL is allowed.
 */
void rcs_camera_clear_info(struct RcsCamera *camera);

/**
 * Writes the reasons why a projection of the image misses its objects, as in the node's status Camera Info: with
 * rviz's projection fx ≠ fy, P[7] ≠ 0, skews, a mirror and a third row of P; D ≠ 0 without lens correction, each with
 * its size in pixels; why a lens could not be corrected; and binning and regions of interest, which are not applied.
 * Empty without reasons or CameraInfo. Buffer and returned length are as in `rcs_last_error`.
 */
size_t rcs_camera_warning(const struct RcsCamera *camera,
                          char *buffer,
                          size_t length);

/**
 * Sets the rate of images, per second. Below 0: an image is due at each call of `rcs_camera_due`, once per frame of
 * rviz's window. 0, or NaN: only when triggered. Above 0: at that rate on average, or at each call if there are fewer
 * calls. NULL is allowed.
 */
void rcs_camera_set_frame_rate(struct RcsCamera *camera, float frame_rate_hz);

/**
 * Makes one image due, at any frame rate and also without subscribers, from the next call of `rcs_camera_due` until
 * `rcs_camera_begin`. NULL is allowed.
 */
void rcs_camera_trigger(struct RcsCamera *camera);

/**
 * Returns true if an image is due now. Call it exactly once per frame of the window. `watched`: the image has
 * subscribers; without, only a triggered one is due. After a pause an image is due at once, and no burst follows.
 * False for NULL.
 */
bool rcs_camera_due(struct RcsCamera *camera, uint64_t now_ns, bool watched);

/**
 * Records that an image is being drawn: resets the trigger, and schedules the next image. NULL is allowed.
 */
void rcs_camera_begin(struct RcsCamera *camera, uint64_t now_ns);

/**
 * Writes a drawn image in an encoding of `sensor_msgs/Image` to `out`: rows from the top, without padding. With a
 * lens the image is bent, and pixels outside of the drawn image have the background's colour. A mirrored image
 * is flipped.
 *
 * `pixels` has the view's drawn size; `out_length` is exactly the image's width · height ·
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
 * Writes a depth buffer as metres along the optical axis, as a `32FC1` image: rows from the top; NaN where nothing was
 * drawn, as on the node's depth topic. With a lens each pixel has the depth of the nearest drawn pixel. A mirrored
 * image is flipped.
 *
 * `depth` has the view's drawn width · height values without padding, 0 at the view's `near_m` and 1 at its `far_m`,
 * with the lowest row first if `bottom_up`; `out_count` is the image's width · height. Other counts are
 * `RCS_RESULT_BAD_LENGTH`, buffers that overlap or are not aligned `RCS_RESULT_BAD_VALUE`.
 */
enum RcsResult rcs_camera_encode_depth(struct RcsCamera *camera,
                                       const float *depth,
                                       size_t depth_count,
                                       bool bottom_up,
                                       float *out,
                                       size_t out_count);

/**
 * Records a published image. `RCS_RESULT_BAD_VALUE` if a step is before the one that precedes it.
 */
enum RcsResult rcs_camera_record(struct RcsCamera *camera, const struct RcsTimes *times);

/**
 * Writes one line about the last hundred recorded images: their rate, and the median and the 95th percentile of each
 * step and of the whole in milliseconds. Empty before the first one. Buffer and returned length are as in
 * `rcs_last_error`.
 */
size_t rcs_camera_statistics(const struct RcsCamera *camera, uint64_t now_ns, char *buffer, size_t length);

/**
 * Reports what the node cannot draw of a config, and the command that starts the node.
 *
 * `yaml`, `yaml_length`: the text of a `.rviz` file in UTF-8 (64 MiB at most, else `RCS_RESULT_BAD_LENGTH`), without a
 * NUL. `path`: the file's path; ends with a NUL. `report`: one line for each display or setting that the node does not
 * draw as rviz does, in the words of `camera_stream check`, separated by newlines; empty if it draws all.
 * `launch_line`: the roslaunch command that draws the config without rviz. `RCS_RESULT_BAD_CONFIG` if the text is no
 * `.rviz` file.
 */
enum RcsResult rcs_config_report(const char *yaml,
                                 size_t yaml_length,
                                 const char *path,
                                 struct RcsText *report,
                                 struct RcsText *launch_line);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* RVIZ_CAMERA_STREAM_CORE_H */
