// Triangles: meshes, wide lines and text. Light is computed for each vertex. See triangles.rs; constants and formulas
// of shading come from shading.rs.

struct Surface {
    clip_from_object: mat4x4f,
    view_from_normal: mat3x3f,
    to_light: vec3f,        // unit vector in the view frame, zero when there is no light
    diffuse: vec4f,
    emissive: vec3f,
    flags: u32,
}

@group(0) @binding(0) var<uniform> surface: Surface;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
    @location(1) uv: vec2f,
}

fn is(flag: u32) -> bool {
    return (surface.flags & flag) != 0u;
}

// The fixed-function light of one directional source.
fn lit(vertex: Vertex) -> vec4f {
    let normal = surface.view_from_normal * vertex.normal;
    let normal_length = select(1.0, length(normal), is(NORMALIZE));
    var light = 0.0;
    if normal_length > 0.0 {
        light = light_on_surface(dot(normal, surface.to_light), normal_length);
    }
    let diffuse = select(surface.diffuse, vertex.color, is(VERTEX_COLORS));
    return vec4f(
        lit_channel(surface.emissive.r, diffuse.r, light),
        lit_channel(surface.emissive.g, diffuse.g, light),
        lit_channel(surface.emissive.b, diffuse.b, light),
        clamp(diffuse.a, 0.0, 1.0),
    );
}

@vertex
fn vertex_triangle(vertex: Vertex) -> Corner {
    var color = vec4f(1.0);
    if is(LIT) {
        color = lit(vertex);
    } else if is(VERTEX_COLORS) {
        color = vertex.color;
    }
    return Corner(surface.clip_from_object * vec4f(vertex.position, 1.0), color, vertex.uv);
}

@fragment
fn fragment_triangle(corner: Corner) -> @location(0) vec4f {
    return corner.color * textureSample(image, image_sampler, corner.uv);
}
