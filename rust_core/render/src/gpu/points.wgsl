// A cloud's points, each an instance. See points.rs.

struct Cloud {
    clip_from_object: mat4x4f,
    clip_from_view: mat4x4f,
    eye: vec3f,             // in the object's frame
    auto_size: f32,         // 1 when sizes are multiplied by the point's z, else 0
    size: vec3f,            // metres, pixels for sprites
    alpha: f32,
    right: vec3f,           // of tiles, in the object's frame
    up: vec3f,
    size_px: vec2f,         // of the picture
}

@group(0) @binding(0) var<uniform> cloud: Cloud;

struct Point {
    @location(0) position: vec3f,
    @location(1) color: vec4f,
}

struct Splat {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
    @location(1) from_center: vec2f,    // -0.5 to 0.5
}

fn corner(index: u32) -> vec2f {
    return vec2f(f32(index & 1u), f32(index >> 1u)) - 0.5;
}

fn scale(position: vec3f) -> f32 {
    return mix(1.0, position.z, cloud.auto_size);
}

// A square of pixels with the depth of its centre.
@vertex
fn vertex_sprite(@builtin(vertex_index) index: u32, point: Point) -> Splat {
    let at = corner(index);
    var clip = cloud.clip_from_object * vec4f(point.position, 1.0);
    clip += vec4f(at * cloud.size.x * 2.0 / cloud.size_px * clip.w, 0.0, 0.0);
    return Splat(clip, point.color, at);
}

// A square parallel to the picture plane.
@vertex
fn vertex_billboard(@builtin(vertex_index) index: u32, point: Point) -> Splat {
    let at = corner(index);
    let offset = at * cloud.size.xy * scale(point.position);
    let center = cloud.clip_from_object * vec4f(point.position, 1.0);
    return Splat(center + cloud.clip_from_view * vec4f(offset, 0.0, 0.0), point.color, at);
}

// A square along two directions of the object's frame.
@vertex
fn vertex_tile(@builtin(vertex_index) index: u32, point: Point) -> Splat {
    let at = corner(index);
    let position = point.position + at.x * cloud.size.x * cloud.right + at.y * cloud.size.y * cloud.up;
    return Splat(cloud.clip_from_object * vec4f(position, 1.0), point.color, at);
}

// The three sides of a box that can be seen, two triangles each. An eye between two opposite sides sees neither.
@vertex
fn vertex_box(@builtin(vertex_index) index: u32, point: Point) -> Splat {
    let axis = index / 6u;
    let in_side = index % 6u;
    let at = corner(select(in_side - 2u, in_side, in_side < 3u));
    let half_size = cloud.size * scale(point.position) * 0.5;
    let to_eye = cloud.eye - point.position;
    let towards = select(-1.0, 1.0, to_eye[axis] > 0.0);
    var offset = vec3f(0.0);
    offset[axis] = towards * half_size[axis];
    offset[(axis + 1u) % 3u] = 2.0 * at.x * half_size[(axis + 1u) % 3u];
    offset[(axis + 2u) % 3u] = 2.0 * at.y * half_size[(axis + 2u) % 3u];
    var clip = cloud.clip_from_object * vec4f(point.position + offset, 1.0);
    if to_eye[axis] * towards <= half_size[axis] {
        clip = vec4f(0.0, 0.0, -1.0, 1.0);
    }
    var front = vec3f(0.5, 0.6, 0.9);
    var back = vec3f(1.0, 0.4, 0.6);
    let shade = select(back[axis], front[axis], towards > 0.0);
    return Splat(clip, vec4f(point.color.rgb * shade, point.color.a), at);
}

fn drawn(color: vec3f, alpha: f32) -> vec4f {
    if alpha < 1.0 / 255.0 {
        discard;
    }
    return vec4f(color, alpha);
}

@fragment
fn fragment_flat(splat: Splat) -> @location(0) vec4f {
    return drawn(splat.color.rgb, splat.color.a * cloud.alpha);
}

@fragment
fn fragment_disc(splat: Splat) -> @location(0) vec4f {
    let inside = ceil((0.25 - dot(splat.from_center, splat.from_center)) * 4.0);
    return drawn(splat.color.rgb, splat.color.a * cloud.alpha * inside);
}

// Four fifths as bright at its edge as at its centre.
@fragment
fn fragment_sphere(splat: Splat) -> @location(0) vec4f {
    let height = (0.25 - dot(splat.from_center, splat.from_center)) * 4.0;
    let color = mix(splat.color.rgb * 0.8, splat.color.rgb, height);
    return drawn(color, splat.color.a * cloud.alpha * ceil(height));
}

// With an edge that is lighter on dark colours and darker on light ones.
fn edged(splat: Splat) -> vec3f {
    let from_edge = vec2f(0.48) - abs(splat.from_center);
    let inner = smoothstep(vec2f(0.0), vec2f(0.03), from_edge);
    let contrast = sign(0.5 - length(splat.color.rgb)) * 0.2;
    return splat.color.rgb + contrast * (1.0 - inner.x * inner.y);
}

@fragment
fn fragment_square(splat: Splat) -> @location(0) vec4f {
    return drawn(edged(splat), splat.color.a * cloud.alpha);
}

// Boxes draw what is transparent, too.
@fragment
fn fragment_box(splat: Splat) -> @location(0) vec4f {
    return vec4f(edged(splat), splat.color.a * cloud.alpha);
}
