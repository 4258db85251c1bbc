// Text: a quad for each glyph. See text.rs.

struct Caption {
    clip_from_text: mat4x4f,
    color: vec4f,
}

@group(0) @binding(0) var<uniform> caption: Caption;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

struct Glyph {
    @location(0) edges: vec4f,      // left, top, right, bottom in metres
    @location(1) uv: vec4f,         // the same edges in the texture
}

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

// The corners of a strip: upper left, lower left, upper right, lower right.
@vertex
fn vertex_text(@builtin(vertex_index) corner: u32, glyph: Glyph) -> Corner {
    let is_right = (corner & 2u) != 0u;
    let is_low = (corner & 1u) != 0u;
    let place = vec2f(select(glyph.edges.x, glyph.edges.z, is_right), select(glyph.edges.y, glyph.edges.w, is_low));
    let uv = vec2f(select(glyph.uv.x, glyph.uv.z, is_right), select(glyph.uv.y, glyph.uv.w, is_low));
    return Corner(caption.clip_from_text * vec4f(place, 0.0, 1.0), uv);
}

@fragment
fn fragment_text(corner: Corner) -> @location(0) vec4f {
    return written(caption.color * textureSample(image, image_sampler, corner.uv), corner.clip.z);
}
