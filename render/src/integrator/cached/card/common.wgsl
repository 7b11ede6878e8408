// What records of every kind share: tiles of surfaces, each with the records that may reach it, in order.

struct Tile {
    first_surface: u32,
    surfaces: u32,
    first_record: u32,
    records: u32,
}

@group(0) @binding(0) var<storage, read> tiles: array<Tile>;
// Indices of records, tile after tile.
@group(0) @binding(1) var<storage, read> near: array<u32>;
@group(0) @binding(2) var<storage, read> surfaces: array<Surface>;
@group(0) @binding(3) var<storage, read> records: array<Record>;
// Sums of the surfaces, to which each run adds some of the records, in order.
@group(0) @binding(4) var<storage, read_write> sums: array<Sums>;
// The first record of its tile that a run adds.
@group(0) @binding(5) var<storage, read> first: array<u32>;

fn tile_of(group: vec3u) -> Tile {
    let i = group.x + group.y * {{ROW}};
    if i < arrayLength(&tiles) {
        return tiles[i];
    }
    return Tile(0u, 0u, 0u, 0u);
}

// The records of a tile that this run adds.
fn run_of(tile: Tile) -> vec2u {
    return tile.first_record + min(vec2u(first[0], first[0] + {{RUN}}), vec2u(tile.records));
}

// Weight of a record at a point of a hemisphere, 0 where it does not count.
fn weight(position: vec3f, hemisphere: vec3f, center: vec3f, normal: vec3f, radius: f32) -> f32 {
    let offset = position - center;
    let distance2 = dot(offset, offset);
    if distance2 >= radius * radius || dot(offset, hemisphere + normal) < {{BEHIND}} * radius {
        return 0.0;
    }
    let turned = sqrt(max(1.0 - dot(hemisphere, normal), 0.0));
    return (1.0 - sqrt(distance2) / radius) * max(1.0 - turned * {{OVER_SPREAD}}, 0.0);
}
