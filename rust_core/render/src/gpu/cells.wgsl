// Cells: a byte each, in the layers of an array texture, coloured by a palette. See cells.rs.

struct Sheet {
    clip_from_object: mat4x4f,
    size: vec2f,            // cells in a row, rows
    layer_side: u32,        // cells on a side of a layer
    layer_columns: u32,     // layers side by side
    alpha: f32,
}

@group(0) @binding(0) var<uniform> sheet: Sheet;
@group(1) @binding(0) var values: texture_2d_array<u32>;
@group(1) @binding(1) var palette: texture_2d<f32>;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) place: vec2f,
}

@vertex
fn vertex_cells(@location(0) place: vec2f) -> Corner {
    return Corner(sheet.clip_from_object * vec4f(place, 0.0, 1.0), place);
}

@fragment
fn fragment_cells(corner: Corner) -> @location(0) vec4f {
    // The cells repeat outside of 0 to 1, which shows where an edge runs through a pixel.
    let count = vec2i(sheet.size);
    let cell = vec2u((vec2i(floor(corner.place * sheet.size)) % count + count) % count);
    let layer = cell / sheet.layer_side;
    let value = textureLoad(values, cell % sheet.layer_side, layer.y * sheet.layer_columns + layer.x, 0).r;
    let color = textureLoad(palette, vec2u(value, 0u), 0);
    return written(vec4f(color.rgb, color.a * sheet.alpha), corner.clip.z);
}
