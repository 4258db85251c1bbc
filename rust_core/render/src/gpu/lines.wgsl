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
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
}

@vertex
fn vertex_line(@builtin(vertex_index) index: u32, segment: Segment) -> Corner {
    var start = Corner(chain.clip_from_object * vec4f(segment.start, 1.0), segment.start_color);
    var end = Corner(chain.clip_from_object * vec4f(segment.end, 1.0), segment.end_color);
    if start.clip.z < 0.0 && end.clip.z < 0.0 {
        return Corner(vec4f(0.0, 0.0, -1.0, 1.0), start.color);
    }
    // What lies before the near plane is cut off here: it has no place on the picture from which to widen it.
    let cut = start.clip.z / (start.clip.z - end.clip.z);
    let cut_clip = mix(start.clip, end.clip, cut);
    let cut_color = mix(start.color, end.color, cut);
    if start.clip.z < 0.0 {
        start = Corner(cut_clip, cut_color);
    } else if end.clip.z < 0.0 {
        end = Corner(cut_clip, cut_color);
    }
    let along_px = (end.clip.xy / end.clip.w - start.clip.xy / start.clip.w) * chain.size_px;
    let steep = abs(along_px.y) > abs(along_px.x);
    let half_width_px = select(vec2f(0.0, 0.5), vec2f(0.5, 0.0), steep);
    let side = f32(index & 1u) * 2.0 - 1.0;
    var corner = start;
    if index >= 2u {
        corner = end;
    }
    corner.clip += vec4f(side * half_width_px * 2.0 / chain.size_px * corner.clip.w, 0.0, 0.0);
    return corner;
}

@fragment
fn fragment_line(corner: Corner) -> @location(0) vec4f {
    return corner.color;
}
