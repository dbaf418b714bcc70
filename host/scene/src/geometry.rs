//! Checks of triangles and materials, areas, normals, curvature.

use caustics_kernels::interface::material::Material;
use caustics_kernels::interface::triangle::{Triangle, TriangleSurface};
use caustics_kernels::surface::media::MAX_MATERIALS;
use glam::{BVec3, DVec3, Vec3};

use super::SceneError;

/// Largest coordinate (m) whose squares and cross products stay finite in the kernels' f32.
pub const MAX_COORDINATE: f64 = 1e9;

/// Refuses tables that do not fit together, and values that no kernel can use.
pub fn check(
    file: &str,
    triangles: &[Triangle],
    surfaces: &[TriangleSurface],
    materials: &[Material],
    names: &[String],
) -> Result<(), SceneError> {
    if triangles.len() != surfaces.len() || materials.len() != names.len() {
        let what = "as many surfaces as triangles and as many names as materials are needed".into();
        return Err(SceneError::Tables { file: file.into(), what });
    }
    for (id, (triangle, surface)) in triangles.iter().zip(surfaces).enumerate() {
        let corners = [triangle.a, triangle.b, triangle.c];
        let normals = [surface.normal_a, surface.normal_b, surface.normal_c];
        let usable = |p: Vec3| p.is_finite() && f64::from(p.abs().max_element()) <= MAX_COORDINATE;
        let what = if !corners.into_iter().all(usable) {
            format!("triangle {id} has a corner that is not finite or beyond {MAX_COORDINATE:e} m")
        } else if !normals.into_iter().all(|n| (n.length() - 1.0).abs() < 1e-3) {
            format!("triangle {id} has a normal that is not of unit length")
        } else if surface.material as usize >= materials.len() {
            format!("triangle {id} has material {}, but there are {}", surface.material, materials.len())
        } else {
            continue;
        };
        return Err(SceneError::Tables { file: file.into(), what });
    }
    for (id, (material, name)) in materials.iter().zip(names).enumerate() {
        check_material(file, name, material)?;
        if id >= MAX_MATERIALS && material.is_medium() {
            let what =
                format!("{name} is a medium, and material {id}: put media among the first {MAX_MATERIALS}");
            return Err(SceneError::Tables { file: file.into(), what });
        }
    }
    Ok(())
}

/// Refuses factors out of glTF's ranges. The comparisons refuse NaN too.
fn check_material(file: &str, name: &str, material: &Material) -> Result<(), SceneError> {
    let shares = [material.roughness, material.metallic, material.transmission, material.specular];
    let range = |values: &[f32], max: f32| values.iter().all(|value| (0.0..=max).contains(value));
    let what = if !range(&shares, 1.0) || !range(&material.base_color.to_array(), 1.0) {
        "a factor out of the range 0 to 1"
    } else if !range(&material.emission.to_array(), 1e30) {
        "an emission that is negative, infinite or not a number"
    } else if !range(&material.absorption.to_array(), f32::MAX) {
        "an attenuation that is negative, infinite or not a number"
    } else if !(1.0..=100.0).contains(&material.ior) {
        "an index of refraction out of the range 1 to 100"
    } else if !range(&[material.dispersion], 1000.0) {
        "a dispersion out of the range 0 to 1000"
    } else {
        return Ok(());
    };
    Err(SceneError::Material { file: file.into(), material: name.into(), what: what.into() })
}

/// Keeps the records whose flag is set. The table may be empty.
pub fn retain<T>(records: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    records.retain(|_| *flags.next().unwrap());
}

/// Whether f32 distinguishes the triangle from a line, relative to its longest edge.
pub fn has_area(triangle: &Triangle) -> bool {
    let [a, b, c] = corners(triangle);
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length() > 1e-7 * longest
}

/// Corners in f64 (m).
pub fn corners(triangle: &Triangle) -> [DVec3; 3] {
    [triangle.a, triangle.b, triangle.c].map(|p| p.as_dvec3())
}

/// The eight corners of a box. Bit `axis` of a corner's index is set on the upper side.
pub fn corners_of_box([lower, upper]: [DVec3; 2]) -> [DVec3; 8] {
    std::array::from_fn(|id| {
        DVec3::select(BVec3::from_array([0, 1, 2].map(|axis| id >> axis & 1 == 1)), upper, lower)
    })
}

/// The box around points. Without points the lower corner is above the upper one.
pub fn box_around(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::MAX, DVec3::MIN], |[lower, upper], p| [lower.min(p), upper.max(p)])
}

/// Unit normal of the front face; arbitrary for a triangle without an area.
pub fn face_normal(triangle: &Triangle) -> Vec3 {
    let [a, b, c] = corners(triangle);
    (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y).as_vec3()
}

/// Area (m^2).
pub fn area(triangle: &Triangle) -> f64 {
    let [a, b, c] = corners(triangle);
    0.5 * (b - a).cross(c - a).length()
}

/// Computes the curvature, and clears normals that equal the face normal, so that kernels use that one, to the bit.
pub fn complete(triangle: &Triangle, surface: &mut TriangleSurface) {
    surface.curvature = curvature(triangle, surface);
    if !is_smooth(triangle, surface) {
        (surface.normal_a, surface.normal_b, surface.normal_c) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
    }
}

/// Whether the normals differ from the face normal.
fn is_smooth(triangle: &Triangle, surface: &TriangleSurface) -> bool {
    let face = face_normal(triangle);
    let normals = [surface.normal_a, surface.normal_b, surface.normal_c];
    normals.into_iter().any(|normal| (normal - face).length() > 1e-6)
}

/// Mean over the edges of the normal's change along each edge (1/m).
fn curvature(triangle: &Triangle, surface: &TriangleSurface) -> f32 {
    if !is_smooth(triangle, surface) {
        return 0.0;
    }
    let p = corners(triangle);
    let n = [surface.normal_a, surface.normal_b, surface.normal_c].map(|n| n.as_dvec3());
    let along = |from: usize, to: usize| {
        let edge = p[to] - p[from];
        (n[to] - n[from]).dot(edge) / edge.length_squared()
    };
    ((along(0, 1) + along(1, 2) + along(2, 0)) / 3.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curvature_of_a_sphere_is_one_over_its_radius() {
        let n = [Vec3::new(1.0, 0.1, 0.0), Vec3::new(1.0, 0.0, 0.1), Vec3::new(1.0, -0.1, -0.1)];
        let [normal_a, normal_b, normal_c] = n.map(Vec3::normalize);
        let surface = TriangleSurface { normal_a, normal_b, normal_c, ..TriangleSurface::default() };
        let triangle = Triangle { a: 0.5 * normal_a, b: 0.5 * normal_b, c: 0.5 * normal_c };
        assert!((curvature(&triangle, &surface) - 2.0).abs() < 1e-4);
    }

    #[test]
    fn media_ids_must_fit_half_a_word() {
        let of_last = |transmission| {
            let mut materials = vec![Material { ior: 1.5, ..Material::default() }; MAX_MATERIALS + 1];
            materials[MAX_MATERIALS].transmission = transmission;
            check("many", &[], &[], &materials, &vec![String::new(); MAX_MATERIALS + 1])
        };
        assert!(of_last(0.0).is_ok());
        assert!(of_last(1.0).is_err_and(|error| error.to_string().contains("material 65535")));
    }
}
