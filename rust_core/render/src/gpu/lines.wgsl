// Lines of one pixel, each an instance of a strip of four vertices. See lines.rs.

struct Chain {
    clip_from_object: mat4x4f,
    size_px: vec2f,         // of the picture
}

@group(0) @binding(0) var<uniform> chain: Chain;

struct Segment {
    @location(0) start: vec3f,
    @location(1) start_color: vec4f,
    @location(2) end: vec3f,
    @location(3) end_color: vec4f,
}

struct Corner {
    @builtin(position) place: vec4f,
    @location(0) color: vec4f,
}

const NOWHERE = Corner(vec4f(0.0, 0.0, -1.0, 1.0), vec4f(0.0));

// Which part of a segment lies in the view volume, from 0 at its start to 1 at its end.
fn visible_part(start: vec4f, end: vec4f) -> vec2f {
    var inside_start = array(start.w + start.x, start.w - start.x, start.w + start.y, start.w - start.y, start.z,
        start.w - start.z);
    var inside_end = array(end.w + end.x, end.w - end.x, end.w + end.y, end.w - end.y, end.z, end.w - end.z);
    var part = vec2f(0.0, 1.0);
    for (var plane = 0; plane < 6; plane++) {
        let a = inside_start[plane];
        let b = inside_end[plane];
        if a < 0.0 && b < 0.0 {
            return vec2f(1.0, 0.0);
        }
        if a < 0.0 {
            part.x = max(part.x, a / (a - b));
        } else if b < 0.0 {
            part.y = min(part.y, a / (a - b));
        }
    }
    return part;
}

// The diamond-exit rule: whether the pixel in which a line begins or ends is drawn. `past` is how far that end lies
// past the pixel's centre, along the line and across it, both in the line's direction; `slope` is not negative. That
// the slope is added, not subtracted, is Mesa's.
fn is_drawn(past: vec2f, slope: f32, is_start: bool) -> bool {
    let is_in_diamond = abs(past.x) + abs(past.y) < 0.5;
    let reaches_diamond = abs(past.y + past.x * slope) < 0.5;
    if is_start {
        return is_in_diamond || (past.x < 0.0 && (past.y <= 0.0 || reaches_diamond));
    }
    return !is_in_diamond && past.x >= 0.0 && (past.y > 0.0 || reaches_diamond);
}

// Moves an end along the line to a side of its pixel where the centre that it covers contradicts the rule. Along
// comes first, then across.
fn end_in_pixels(at: vec2f, delta: vec2f, is_start: bool) -> vec2f {
    let direction = select(vec2f(1.0), vec2f(-1.0), delta < vec2f(0.0));
    let slope = delta.y / delta.x;
    let past = (fract(at) - 0.5) * direction;
    let drawn = is_drawn(past, abs(slope), is_start);
    let is_centre_before = past.x > 0.0 || (past.x == 0.0 && direction.x < 0.0);
    if drawn == (is_centre_before != is_start) {
        return at;
    }
    let side = select(-0.5, 0.5, drawn != is_start);
    let shift = (side - past.x) * direction.x;
    return at + vec2f(shift, shift * slope);
}

@vertex
fn vertex_line(@builtin(vertex_index) index: u32, segment: Segment) -> Corner {
    let start = chain.clip_from_object * vec4f(segment.start, 1.0);
    let end = chain.clip_from_object * vec4f(segment.end, 1.0);
    let part = visible_part(start, end);
    if !(part.x < part.y) {
        return NOWHERE;
    }
    let visible_start = mix(start, end, part.x);
    let visible_end = mix(start, end, part.y);
    var start_px = (visible_start.xy / visible_start.w * vec2f(0.5, -0.5) + 0.5) * chain.size_px;
    var end_px = (visible_end.xy / visible_end.w * vec2f(0.5, -0.5) + 0.5) * chain.size_px;
    let steep = abs(end_px.y - start_px.y) > abs(end_px.x - start_px.x);
    if steep {
        start_px = start_px.yx;
        end_px = end_px.yx;
    }
    let direction = end_px - start_px;
    if direction.x == 0.0 {
        return NOWHERE;
    }
    let is_start = index < 2u;
    var at = end_in_pixels(select(end_px, start_px, is_start), direction, is_start);
    // What is linear in the picture is extended to where the end was moved, so that each pixel keeps its depth and
    // colour.
    let along = (at.x - start_px.x) / direction.x;
    let inverse_w = 1.0 / vec2f(visible_start.w, visible_end.w);
    let depth_there = mix(visible_start.z * inverse_w.x, visible_end.z * inverse_w.y, along);
    // A line that runs towards the eye within a pixel could be extended past it.
    let inverse_w_there = max(mix(inverse_w.x, inverse_w.y, along), 0.5 * min(inverse_w.x, inverse_w.y));
    let start_color = mix(segment.start_color, segment.end_color, part.x);
    let end_color = mix(segment.start_color, segment.end_color, part.y);
    let color = mix(start_color, end_color, along * inverse_w.y / inverse_w_there);

    at.y += f32(index & 1u) - 0.5;
    if steep {
        at = at.yx;
    }
    let w = 1.0 / inverse_w_there;
    let place = vec4f((at / chain.size_px * 2.0 - 1.0) * vec2f(1.0, -1.0), clamp(depth_there, 0.0, 1.0), 1.0) * w;
    return Corner(place, color);
}

@fragment
fn fragment_line(corner: Corner) -> @location(0) vec4f {
    return written(corner.color, corner.place.z);
}
