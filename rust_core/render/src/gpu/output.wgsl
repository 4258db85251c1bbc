// What the fragments of all kinds of primitives write. See `Output` in pipeline.rs.

// Colours are written, or depths.
override WRITES_DEPTH: bool = false;
// The depth is the fragment's, else that of the far plane.
override IS_LISTED: bool = true;
// Fainter fragments of a blended drawable leave the depth that is there.
override LEAST_ALPHA: f32 = -1.0;

// The depth in steps of 24 bits, of which red has the lowest ones. Blending takes all or nothing of it.
fn written(color: vec4f, depth: f32) -> vec4f {
    if !WRITES_DEPTH {
        return color;
    }
    const FARTHEST = 0xffffffu;
    let steps = select(FARTHEST, u32(round(saturate(depth) * f32(FARTHEST))), IS_LISTED);
    let bytes = (vec3u(steps) >> vec3u(0u, 8u, 16u)) & vec3u(255u);
    return vec4f(vec3f(bytes) / 255.0, select(0.0, 1.0, color.a >= LEAST_ALPHA));
}
