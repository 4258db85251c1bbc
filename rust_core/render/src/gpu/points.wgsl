// A cloud's points, each an instance. See points.rs; constants and formulas of shading come from shading.rs.

struct Cloud {
    clip_from_object: mat4x4f,
    eye: vec3f,             // in the object's frame
    auto_size: f32,         // 1 when sizes are multiplied by the point's z, else 0
    size: vec3f,            // metres, pixels for sprites
    alpha: f32,
    right: vec3f,           // of tiles, in the object's frame
    up: vec3f,
    size_px: vec2f,         // of the picture
    range_m: vec2f,         // of the rainbow: its lowest coordinate, and how far it reaches
    rainbow: vec4f,         // coefficients of its coordinate
    color: u32,             // of all points
    color_rule: u32,
}

@group(0) @binding(0) var<uniform> cloud: Cloud;

struct StoredPoint {
    @location(0) position: vec3f,
    @location(1) color: vec4f,
}

struct Point {
    position: vec3f,
    color: vec4f,
    is_finite: bool,
}

struct Splat {
    @builtin(position) place: vec4f,
    @location(0) @interpolate(flat, either) color: vec4f,
    @location(1) from_center: vec2f,    // -0.5 to 0.5
}

struct Sprite {
    @builtin(position) place: vec4f,
    @location(0) @interpolate(flat, either) color: vec4f,
    @location(1) @interpolate(flat, either) center_px: vec2f,
}

const NOWHERE = vec4f(0.0, 0.0, -1.0, 1.0);

// rviz's rainbow: magenta at 0 over blue, cyan, green and yellow to red at 1. Levels are truncated to bytes.
fn rainbow(share: f32) -> vec4f {
    let place = clamp(share, 0.0, 1.0) * 5.0 + 1.0;
    let falling = 1.0 - fract(place);
    let rising = 1.0 - falling;
    var color = vec3f(1.0, 0.0, 0.0);
    switch u32(place) {
        case 1u: { color = vec3f(falling, 0.0, 1.0); }
        case 2u: { color = vec3f(0.0, rising, 1.0); }
        case 3u: { color = vec3f(0.0, 1.0, falling); }
        case 4u: { color = vec3f(rising, 1.0, 0.0); }
        case 5u: { color = vec3f(1.0, falling, 0.0); }
        default: {}
    }
    return vec4f(floor(color * 255.0) / 255.0, 1.0);
}

fn color_of(position: vec3f, stored: vec4f) -> vec4f {
    switch cloud.color_rule {
        case 1u: { return vec4f(stored.bgr, 1.0); }
        case 2u: { return unpack4x8unorm(cloud.color); }
        case 3u: {
            let coordinate_m = dot(cloud.rainbow.xyz, position) + cloud.rainbow.w;
            return rainbow(1.0 - (coordinate_m - cloud.range_m.x) / cloud.range_m.y);
        }
        default: { return stored; }
    }
}

// By the bits, since shaders need not know NaN.
fn decoded(stored: StoredPoint) -> Point {
    const EXPONENT = vec3u(0x7f800000u);
    let is_finite = all((bitcast<vec3u>(stored.position) & EXPONENT) != EXPONENT);
    let position = select(vec3f(0.0), stored.position, is_finite);
    return Point(position, color_of(position, stored.color), is_finite);
}

// Of a strip of two triangles that meet where x = y, as rviz's do.
fn corner(index: u32) -> vec2f {
    return vec2f(f32(index >> 1u), 1.0 - f32(index & 1u)) - 0.5;
}

fn scale(position: vec3f) -> f32 {
    return mix(1.0, position.z, cloud.auto_size);
}

// A triangle around a circle of diameter 1.
const AROUND_DISC = array(vec2f(0.0, 1.0), vec2f(-0.866025404, -0.5), vec2f(0.866025404, -0.5));

// A triangle of pixels with the depth of its centre. A point is dropped when its centre is off the picture. The circle
// in the triangle is a pixel too large, so that the fragment shader decides which pixels are drawn.
@vertex
fn vertex_sprite(@builtin(vertex_index) index: u32, stored: StoredPoint) -> Sprite {
    let point = decoded(stored);
    let clip = cloud.clip_from_object * vec4f(point.position, 1.0);
    if !(point.is_finite && all(abs(clip.xy) <= vec2f(clip.w)) && clip.z >= 0.0 && clip.z <= clip.w && clip.w > 0.0) {
        return Sprite(NOWHERE, point.color, vec2f(0.0));
    }
    let on_picture = clip.xy / clip.w;
    let center_px = (on_picture * vec2f(0.5, -0.5) + 0.5) * cloud.size_px;
    var corners = AROUND_DISC;
    let offset = corners[index] * (cloud.size.x + 1.0) * 2.0 / cloud.size_px;
    return Sprite(vec4f(on_picture + offset, clip.z / clip.w, 1.0), point.color, center_px);
}

fn billboard(at: vec2f, point: Point) -> Splat {
    let towards_eye = normalize(cloud.eye - point.position);
    let across = cross(vec3f(0.0, 1.0, 0.0), towards_eye);
    if !(point.is_finite && dot(across, across) > 0.0) {
        return Splat(NOWHERE, point.color, at);
    }
    let right = normalize(across);
    let up = normalize(cross(towards_eye, across));
    let offset = at * cloud.size.xy * scale(point.position);
    let position = point.position + offset.x * right + offset.y * up;
    return Splat(cloud.clip_from_object * vec4f(position, 1.0), point.color, at);
}

// A square that faces the eye, upright along the object's y.
@vertex
fn vertex_square(@builtin(vertex_index) index: u32, stored: StoredPoint) -> Splat {
    return billboard(corner(index), decoded(stored));
}

// A triangle round the disc in such a square.
@vertex
fn vertex_disc(@builtin(vertex_index) index: u32, stored: StoredPoint) -> Splat {
    var corners = AROUND_DISC;
    return billboard(corners[index], decoded(stored));
}

// A square along two directions of the object's frame.
@vertex
fn vertex_tile(@builtin(vertex_index) index: u32, stored: StoredPoint) -> Splat {
    let point = decoded(stored);
    let at = corner(index);
    let position = point.position + at.x * cloud.size.x * cloud.right + at.y * cloud.size.y * cloud.up;
    let place = cloud.clip_from_object * vec4f(position, 1.0);
    return Splat(select(NOWHERE, place, point.is_finite), point.color, at);
}

// The sides of a box that can be seen, two triangles each: first the three near ones, then the three far ones. An eye
// between two opposite sides sees neither. A box of negative size is mirrored: it shows its insides, which are the far
// sides, and both where the eye is between two.
@vertex
fn vertex_box(@builtin(vertex_index) index: u32, stored: StoredPoint) -> Splat {
    let point = decoded(stored);
    let side = index / 6u;
    let axis = side % 3u;
    let is_far = side >= 3u;
    let in_side = index % 6u;
    let at = corner(select(in_side - 2u, in_side, in_side < 3u));
    let half_size = cloud.size * scale(point.position) * 0.5;
    let is_mirrored = half_size.x * half_size.y * half_size.z < 0.0;
    let to_eye = cloud.eye - point.position;
    let near = select(-1.0, 1.0, to_eye[axis] > 0.0);
    let towards = select(near, -near, is_far);
    let reach = abs(half_size[axis]);
    var offset = vec3f(0.0);
    offset[axis] = towards * reach;
    offset[(axis + 1u) % 3u] = 2.0 * at.x * half_size[(axis + 1u) % 3u];
    offset[(axis + 2u) % 3u] = 2.0 * at.y * half_size[(axis + 2u) % 3u];
    var place = cloud.clip_from_object * vec4f(point.position + offset, 1.0);
    let is_between = to_eye[axis] * near <= reach;
    let is_seen = select(!is_far && !is_between, is_far || is_between, is_mirrored);
    if !(is_seen && point.is_finite) {
        place = NOWHERE;
    }
    var along = BOX_SIDES_ALONG;
    var against = BOX_SIDES_AGAINST;
    let shade = select(against[axis], along[axis], towards * half_size[axis] > 0.0);
    return Splat(place, vec4f(point.color.rgb * shade, point.color.a), at);
}

// A fragment that is too faint is rejected.
fn drawn(color: vec3f, alpha: f32, depth: f32) -> vec4f {
    if alpha <= MAX_REJECTED_ALPHA {
        discard;
    }
    return written(vec4f(color, alpha), depth);
}

@fragment
fn fragment_sprite(sprite: Sprite) -> @location(0) vec4f {
    let from_center = (sprite.place.xy - sprite.center_px) / cloud.size.x;
    if dot(from_center, from_center) >= DISC_RADIUS_SQUARED {
        discard;
    }
    return drawn(sprite.color.rgb, sprite.color.a * cloud.alpha, sprite.place.z);
}

@fragment
fn fragment_flat(splat: Splat) -> @location(0) vec4f {
    return drawn(splat.color.rgb, splat.color.a * cloud.alpha, splat.place.z);
}

// A disc, darker to its rim.
@fragment
fn fragment_sphere(splat: Splat) -> @location(0) vec4f {
    let distance_squared = dot(splat.from_center, splat.from_center);
    if distance_squared >= DISC_RADIUS_SQUARED {
        discard;
    }
    return drawn(splat.color.rgb * disc_brightness(distance_squared), splat.color.a * cloud.alpha, splat.place.z);
}

// With an edge that is lighter on dark colours and darker on light ones.
@fragment
fn fragment_square(splat: Splat) -> @location(0) vec4f {
    let rgb = splat.color.rgb;
    let contrast = edge_contrast(rgb.r, rgb.g, rgb.b);
    let is_inside = inside(splat.from_center.x, splat.from_center.y);
    let color = vec3f(
        with_edge(rgb.r, contrast, is_inside),
        with_edge(rgb.g, contrast, is_inside),
        with_edge(rgb.b, contrast, is_inside),
    );
    return drawn(color, splat.color.a * cloud.alpha, splat.place.z);
}

// With a darker edge; boxes draw transparent fragments, too.
@fragment
fn fragment_box(splat: Splat) -> @location(0) vec4f {
    let color = splat.color.rgb * box_brightness(inside(splat.from_center.x, splat.from_center.y));
    return written(vec4f(color, splat.color.a * cloud.alpha), splat.place.z);
}
