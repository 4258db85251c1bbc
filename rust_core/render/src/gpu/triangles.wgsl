// Triangles: meshes and wide lines. Light is computed for each vertex. See triangles.rs; constants and formulas of
// shading come from shading.rs.

struct Light {
    to_light: vec3f,        // unit vector in the view frame, zero when there is no light
}

@group(0) @binding(0) var<uniform> light: Light;
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

struct Instance {
    @location(4) clip_x: vec4f,     // clip_from_object, column by column
    @location(5) clip_y: vec4f,
    @location(6) clip_z: vec4f,
    @location(7) clip_origin: vec4f,
    @location(8) normal_x: vec3f,   // view_from_normal, column by column
    @location(9) normal_y: vec3f,
    @location(10) normal_z: vec3f,
    @location(11) diffuse: vec4f,
    @location(12) emissive: vec3f,
    @location(13) flags: u32,
}

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
    @location(1) uv: vec2f,
}

// The fixed-function light of one directional source.
fn lit(vertex: Vertex, instance: Instance) -> vec4f {
    let normal = mat3x3f(instance.normal_x, instance.normal_y, instance.normal_z) * vertex.normal;
    let normal_length = select(1.0, length(normal), (instance.flags & NORMALIZE) != 0u);
    var brightness = 0.0;
    if normal_length > 0.0 {
        brightness = light_on_surface(dot(normal, light.to_light), normal_length);
    }
    let diffuse = select(instance.diffuse, vertex.color, (instance.flags & VERTEX_COLORS) != 0u);
    return vec4f(
        lit_channel(instance.emissive.r, diffuse.r, brightness),
        lit_channel(instance.emissive.g, diffuse.g, brightness),
        lit_channel(instance.emissive.b, diffuse.b, brightness),
        clamp(diffuse.a, 0.0, 1.0),
    );
}

@vertex
fn vertex_triangle(vertex: Vertex, instance: Instance) -> Corner {
    var color = vec4f(1.0);
    if (instance.flags & LIT) != 0u {
        color = lit(vertex, instance);
    } else if (instance.flags & VERTEX_COLORS) != 0u {
        color = vertex.color;
    }
    let clip_from_object = mat4x4f(instance.clip_x, instance.clip_y, instance.clip_z, instance.clip_origin);
    return Corner(clip_from_object * vec4f(vertex.position, 1.0), color, vertex.uv);
}

@fragment
fn fragment_triangle(corner: Corner) -> @location(0) vec4f {
    return written(corner.color * textureSample(image, image_sampler, corner.uv), corner.clip.z);
}
