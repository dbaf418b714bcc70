//! A triangle's corner in f64, before and after its transform to the world.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3, Vec4};

/// A triangle's corner in the world.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Position (m), not recentred.
    pub position: DVec3,
    /// Unit normal; `None`: the face normal.
    pub normal: Option<Vec3>,
    /// Texture coordinates of the material; zero without textures.
    pub uv: Vec2,
    /// Unit tangent and sign of the bitangent, if the file has them and a normal map needs them.
    pub tangent: Option<Vec4>,
}

impl Corner {
    /// Transforms the corner to the world; `turn` transforms normals.
    pub fn placed(&self, to_world: &DAffine3, turn: &DMat3) -> Corner {
        Corner {
            position: to_world.transform_point3(self.position),
            normal: self.normal.and_then(|normal| turned(turn, normal.to_array()).ok().flatten()),
            uv: self.uv,
            tangent: self.tangent.and_then(|tangent| placed(to_world, tangent.to_array())),
        }
    }

    /// Midpoint of two corners; the order does not matter.
    pub fn middle(&self, other: &Corner) -> Corner {
        let unit = |a: Vec3, b: Vec3| (a + b).try_normalize();
        Corner {
            position: 0.5 * (self.position + other.position),
            normal: self.normal.zip(other.normal).and_then(|(a, b)| unit(a, b)),
            uv: 0.5 * (self.uv + other.uv),
            tangent: self
                .tangent
                .zip(other.tangent)
                .and_then(|(a, b)| Some(unit(a.truncate(), b.truncate())?.extend(a.w))),
        }
    }
}

/// Transforms a tangent to the world; `None` if it has no direction. A mirrored mesh flips the bitangent's sign.
pub fn placed(to_world: &DAffine3, [x, y, z, sign]: [f32; 4]) -> Option<Vec4> {
    let along = (to_world.matrix3 * DVec3::new(x.into(), y.into(), z.into())).try_normalize()?.as_vec3();
    let is_mirrored = to_world.matrix3.determinant() < 0.0;
    let sign = if (sign < 0.0) != is_mirrored { -1.0 } else { 1.0 };
    Some(along.extend(sign))
}

/// Transforms a normal to the world; `None` if the file's normal has no length.
pub fn turned(turn: &DMat3, normal: [f32; 3]) -> Result<Option<Vec3>, &'static str> {
    let normal = Vec3::from(normal).as_dvec3();
    if !normal.is_finite() {
        return Err("is not finite");
    }
    Ok(normal
        .try_normalize()
        .and_then(|normal| (*turn * normal).try_normalize())
        .map(|normal| normal.as_vec3()))
}
