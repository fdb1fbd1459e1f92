//! A wavy sheet: its coarse mesh with the picture looks as the fine one does.

use glam::Mat3;

use super::texels::each_texel;
use super::*;
use crate::outfit::Material;
use crate::test_meshes::sheet;

const SIDE: u32 = 41;
const TEXELS: usize = 256;

/// A garment of one sheet of 40 cm, split along its middle in UVs, which repeat a fabric many times.
fn shirt() -> Outfit {
    let (positions, triangles) = sheet(SIDE);
    let (half, count) = (SIDE / 2, SIDE * SIDE);
    let right = |t: &[u32; 3]| t.iter().any(|&i| i % SIDE > half);
    // Vertices on the seam are drawn twice: the second time for the right half, moved on by seven repeats.
    let seam: Vec<u32> = (0..SIDE).map(|row| row * SIDE + half).collect();
    let uv = |i: u32| Vec2::new(30.0 * positions[i as usize].x, 10.0 * positions[i as usize].z);
    let shift = |i: u32| if i % SIDE > half { Vec2::new(7.0, 0.0) } else { Vec2::ZERO };
    let mut uvs: Vec<Vec2> = (0..count).map(|i| uv(i) + shift(i)).collect();
    uvs.extend(seam.iter().map(|&i| uv(i) + Vec2::new(7.0, 0.0)));
    let twin = |i: u32| if i % SIDE == half { count + i / SIDE } else { i };
    let drawn = triangles.iter().map(|t| if right(t) { t.map(twin) } else { *t }).collect();
    let garment = Garment {
        name: "shirt".into(),
        vertices: 0..count,
        drawn_vertices: 0..count + SIDE,
        parts: vec![Part { material: 0, triangles: 0..triangles.len() as u32 }],
        ..Garment::default()
    };
    let surface = Surface { vertex_of: (0..count).chain(seam).collect(), uvs, triangles: drawn };
    let materials = vec![Material::default()];
    Outfit { positions, triangles, garments: vec![garment], surface, materials, ..Outfit::default() }
}

/// The sheet bent over an arm and folded, with its normals.
fn draped(outfit: &Outfit) -> (Vec<Vec3>, Vec<Vec3>) {
    let fold = |p: &Vec3| {
        let radius = 0.15 + 0.004 * (60.0 * p.x).sin() + 0.003 * (45.0 * p.z).sin();
        Vec3::new(radius * (5.0 * p.x).sin(), radius * (5.0 * p.x).cos(), p.z)
    };
    let positions: Vec<Vec3> = outfit.positions.iter().map(fold).collect();
    let normals = toile_geometry::normals::vertex_normals(&positions, &outfit.triangles);
    (positions, normals)
}

/// What a renderer sees at a texel of the coarse mesh: the tangent frame and the picture, put together.
fn seen(shading: &Shading, coarse: &CoarseOutfit, drawn: [u32; 3], weights: Vec3, colour: [u8; 3]) -> Vec3 {
    let mix =
        |corners: [Vec3; 3]| (Mat3::from_cols(corners[0], corners[1], corners[2]) * weights).normalize();
    let tangents = drawn.map(|i| shading.tangents[i as usize]);
    let normals = drawn.map(|i| shading.normals[coarse.outfit.surface.vertex_of[i as usize] as usize]);
    let bitangents = [0, 1, 2].map(|k| normals[k].cross(tangents[k].truncate()) * tangents[k].w);
    let local = Vec3::from_array(colour.map(|c| f32::from(c) / 127.5 - 1.0));
    let frame = Mat3::from_cols(mix(tangents.map(|t| t.truncate())), mix(bitangents), mix(normals));
    (frame * local).normalize()
}

/// Angles in degrees between the fine normals and those seen on the coarse mesh, sorted, with and without picture.
fn angles(outfit: &Outfit, coarse: &CoarseOutfit) -> [Vec<f32>; 2] {
    let (positions, normals) = draped(outfit);
    let shading = coarse.shade(&positions);
    let picture = &coarse.bake(&normals, &shading, Some(TEXELS))[0];
    let mut fine = vec![Vec3::ZERO; TEXELS * TEXELS];
    let source = &coarse.sources[0];
    for triangle in &source.triangles {
        let [a, b, c] = triangle.map(|i| normals[source.welded[i as usize] as usize]);
        each_texel(TEXELS, triangle.map(|i| source.uvs[i as usize]), |texel, w| {
            fine[texel] = (a * w.x + b * w.y + c * w.z).normalize();
        });
    }
    let mut out = [Vec::new(), Vec::new()];
    for &drawn in &coarse.outfit.surface.triangles {
        each_texel(TEXELS, drawn.map(|i| coarse.uvs[i as usize]), |texel, weights| {
            let colours = [picture.texels[texel], [128, 128, 255]];
            for (list, colour) in out.iter_mut().zip(colours) {
                let angle = seen(&shading, coarse, drawn, weights, colour).angle_between(fine[texel]);
                list.extend((fine[texel] != Vec3::ZERO).then_some(angle.to_degrees()));
            }
        });
    }
    out.iter_mut().for_each(|list| list.sort_by(f32::total_cmp));
    out
}

#[test]
fn the_picture_gives_the_coarse_mesh_the_fine_normals_back() {
    let outfit = shirt();
    let coarse = CoarseOutfit::new(&outfit, &outfit.positions).unwrap();
    let (few, many) = (coarse.outfit.triangles.len(), outfit.triangles.len());
    assert!(few * 4 <= many + 8, "{few} of {many} triangles");
    let [with, without] = angles(&outfit, &coarse).map(|list| list[list.len() * 99 / 100]);
    assert!(with < 3.0 && without > 12.0, "{with}° with, {without}° without the picture");
}

#[test]
fn islands_that_overlap_in_the_file_lie_apart_in_the_square() {
    let mut outfit = shirt();
    outfit.surface.uvs.iter_mut().for_each(|uv| uv.x = uv.x.rem_euclid(13.0));
    let coarse = CoarseOutfit::new(&outfit, &outfit.positions).unwrap();
    assert_eq!(coarse.sources[0].boxes.len(), 2);
    assert!(coarse.uvs.iter().all(|uv| uv.min_element() > 0.0 && uv.max_element() < 1.0));
    assert!(angles(&outfit, &coarse)[0].last().unwrap() < &8.0);
}

#[test]
fn an_island_that_lies_over_itself_is_cut() {
    let mut outfit = shirt();
    // Folded over: the sheet's far half lies on its near half in the file's picture.
    outfit.surface.uvs.iter_mut().for_each(|uv| uv.y = (uv.y - 2.03).abs());
    let coarse = CoarseOutfit::new(&outfit, &outfit.positions).unwrap();
    assert_eq!(coarse.sources[0].boxes.len(), 4);
    let [with, without] = angles(&outfit, &coarse).map(|list| list[list.len() * 99 / 100]);
    assert!(with < 3.0 && without > 12.0, "{with}° with, {without}° without the picture");
}

#[test]
fn every_coarse_vertex_is_a_fine_one_with_its_uv_and_seams_hold() {
    let outfit = shirt();
    let coarse = CoarseOutfit::new(&outfit, &outfit.positions).unwrap();
    let fine: Vec<(u32, Vec2)> =
        outfit.surface.vertex_of.iter().copied().zip(outfit.surface.uvs.iter().copied()).collect();
    let surface = &coarse.outfit.surface;
    assert!(surface.vertex_of.iter().zip(&surface.uvs).all(|(v, uv)| fine.contains(&(*v, *uv))));
    // An open edge of the welded coarse mesh lies on the sheet's own border: nothing gapes along the seam.
    let border =
        |i: u32| i.is_multiple_of(SIDE) || i % SIDE == SIDE - 1 || i / SIDE == 0 || i / SIDE == SIDE - 1;
    let mut sides: Vec<[u32; 2]> =
        coarse.outfit.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.iter_mut().for_each(|side| side.sort_unstable());
    sides.sort_unstable();
    let open = sides.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]);
    assert!(open.flatten().all(border));
}

#[test]
fn uvs_that_do_not_tell_places_apart_are_refused() {
    let refused = |change: fn(&mut Outfit)| {
        let mut outfit = shirt();
        change(&mut outfit);
        CoarseOutfit::new(&outfit, &outfit.positions).unwrap_err()
    };
    let garment = || "shirt".to_owned();
    let no_uvs = NormalMapError::NoUvs { garment: garment() };
    assert_eq!(refused(|outfit| outfit.surface.uvs.clear()), no_uvs);
    assert_eq!(refused(|outfit| outfit.surface.uvs.fill(Vec2::ONE)), no_uvs);
    assert_eq!(refused(|outfit| outfit.surface.uvs.iter_mut().for_each(|uv| uv.x = 0.0)), no_uvs);
    assert_eq!(refused(|outfit| outfit.surface.uvs[0].x = f32::NAN), no_uvs);
    let loose = refused(|outfit| {
        let uvs = (0..outfit.triangles.len()).flat_map(|k| {
            let at = Vec2::splat(k as f32);
            [at, at + Vec2::X * 0.3, at + Vec2::Y * 0.3]
        });
        outfit.surface.uvs = uvs.collect();
        outfit.surface.vertex_of = outfit.triangles.as_flattened().to_vec();
        outfit.garments[0].drawn_vertices = 0..outfit.surface.vertex_of.len() as u32;
        outfit.surface.triangles =
            (0..outfit.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    });
    assert_eq!(loose, NormalMapError::Fragmented { garment: garment(), islands: 3200 });
}
