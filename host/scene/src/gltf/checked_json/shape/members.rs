//! Members of a document that are read, and their types.

use self::Kind::{Code, Flag, Index, Number, Numbers, Size, Text, Word};

/// Type of a value.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// String.
    Text,
    /// String out of a list.
    Word(&'static [&'static str]),
    /// Integer out of a list.
    Code(&'static [u64]),
    /// Index, below 2^32 - 1.
    Index,
    /// Non-negative integer.
    Size,
    /// Number of any kind.
    Number,
    /// Array of this number of numbers.
    Numbers(usize),
    /// Bool.
    Flag,
}

/// Members of a reference to a texture.
pub const TEXTURE: &[(&str, Kind)] = &[
    ("index", Index),
    ("texCoord", Index),
    ("scale", Number),
    ("strength", Number),
    ("extensions.KHR_texture_transform.offset", Numbers(2)),
    ("extensions.KHR_texture_transform.rotation", Number),
    ("extensions.KHR_texture_transform.scale", Numbers(2)),
    ("extensions.KHR_texture_transform.texCoord", Index),
];

/// Paths of references to textures.
pub const TEXTURES: [&str; 7] = [
    "materials[].pbrMetallicRoughness.baseColorTexture",
    "materials[].pbrMetallicRoughness.metallicRoughnessTexture",
    "materials[].normalTexture",
    "materials[].emissiveTexture",
    "materials[].occlusionTexture",
    "materials[].extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture",
    "materials[].extensions.KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture",
];

/// Members that are read: `[]` is every element of a list, `*` every member of an object.
pub const DOCUMENT: &[(&str, Kind)] = &[
    ("asset.version", Text),
    ("asset.minVersion", Text),
    ("scene", Index),
    ("extensionsRequired[]", Text),
    ("scenes[].name", Text),
    ("scenes[].extensions.EXT_lights_image_based.light", Index),
    ("extensions.EXT_lights_image_based.lights[].intensity", Number),
    ("extensions.EXT_lights_image_based.lights[].rotation", Numbers(4)),
    ("extensions.EXT_lights_image_based.lights[].irradianceCoefficients[]", Numbers(3)),
    ("extensions.EXT_lights_image_based.lights[].specularImages[][]", Index),
    ("scenes[].nodes[]", Index),
    ("nodes[].name", Text),
    ("nodes[].children[]", Index),
    ("nodes[].mesh", Index),
    ("nodes[].camera", Index),
    ("nodes[].skin", Index),
    ("nodes[].translation", Numbers(3)),
    ("nodes[].rotation", Numbers(4)),
    ("nodes[].scale", Numbers(3)),
    ("nodes[].matrix", Numbers(16)),
    ("nodes[].extensions.KHR_lights_punctual.light", Index),
    ("nodes[].extensions.EXT_mesh_gpu_instancing.attributes.*", Index),
    ("extensions.KHR_lights_punctual.lights[].name", Text),
    ("extensions.KHR_lights_punctual.lights[].type", Text),
    ("extensions.KHR_lights_punctual.lights[].color", Numbers(3)),
    ("extensions.KHR_lights_punctual.lights[].intensity", Number),
    ("extensions.KHR_lights_punctual.lights[].range", Number),
    ("extensions.KHR_lights_punctual.lights[].spot.innerConeAngle", Number),
    ("extensions.KHR_lights_punctual.lights[].spot.outerConeAngle", Number),
    ("cameras[].name", Text),
    ("cameras[].type", Text),
    ("cameras[].perspective.yfov", Number),
    ("cameras[].perspective.aspectRatio", Number),
    ("meshes[].name", Text),
    ("meshes[].primitives[].attributes.*", Index),
    ("meshes[].primitives[].indices", Index),
    ("meshes[].primitives[].material", Index),
    ("meshes[].primitives[].mode", Code(&[0, 1, 2, 3, 4, 5, 6])),
    ("accessors[].bufferView", Index),
    ("accessors[].byteOffset", Size),
    ("accessors[].componentType", Code(&[5120, 5121, 5122, 5123, 5125, 5126])),
    ("accessors[].count", Size),
    ("accessors[].normalized", Flag),
    ("accessors[].type", Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
    ("accessors[].sparse.count", Size),
    ("accessors[].sparse.indices.bufferView", Index),
    ("accessors[].sparse.indices.byteOffset", Size),
    ("accessors[].sparse.indices.componentType", Code(&[5121, 5123, 5125])),
    ("accessors[].sparse.values.bufferView", Index),
    ("accessors[].sparse.values.byteOffset", Size),
    ("bufferViews[].buffer", Index),
    ("bufferViews[].byteOffset", Size),
    ("bufferViews[].byteLength", Size),
    ("bufferViews[].byteStride", Size),
    ("meshes[].primitives[].extensions.KHR_draco_mesh_compression.bufferView", Index),
    ("meshes[].primitives[].extensions.KHR_draco_mesh_compression.attributes.*", Index),
    ("buffers[].uri", Text),
    ("buffers[].byteLength", Size),
    ("materials[].name", Text),
    ("materials[].doubleSided", Flag),
    ("materials[].alphaMode", Word(&["OPAQUE", "MASK", "BLEND"])),
    ("materials[].alphaCutoff", Number),
    ("materials[].emissiveFactor", Numbers(3)),
    ("materials[].pbrMetallicRoughness.baseColorFactor", Numbers(4)),
    ("materials[].pbrMetallicRoughness.metallicFactor", Number),
    ("materials[].pbrMetallicRoughness.roughnessFactor", Number),
    ("materials[].extensions.KHR_materials_dispersion.dispersion", Number),
    ("materials[].extensions.KHR_materials_emissive_strength.emissiveStrength", Number),
    ("materials[].extensions.KHR_materials_ior.ior", Number),
    ("materials[].extensions.KHR_materials_specular.specularFactor", Number),
    ("materials[].extensions.KHR_materials_specular.specularColorFactor", Numbers(3)),
    ("materials[].extensions.KHR_materials_transmission.transmissionFactor", Number),
    ("materials[].extensions.KHR_materials_volume.thicknessFactor", Number),
    ("materials[].extensions.KHR_materials_volume.attenuationDistance", Number),
    ("materials[].extensions.KHR_materials_volume.attenuationColor", Numbers(3)),
    ("materials[].extensions.KHR_materials_clearcoat.clearcoatFactor", Number),
    ("materials[].extensions.KHR_materials_clearcoat.clearcoatRoughnessFactor", Number),
    ("materials[].extensions.KHR_materials_pbrSpecularGlossiness.diffuseFactor", Numbers(4)),
    ("materials[].extensions.KHR_materials_pbrSpecularGlossiness.specularFactor", Numbers(3)),
    ("materials[].extensions.KHR_materials_pbrSpecularGlossiness.glossinessFactor", Number),
    ("extensions.KHR_materials_variants.variants[].name", Text),
    ("meshes[].primitives[].extensions.KHR_materials_variants.mappings[].material", Index),
    ("meshes[].primitives[].extensions.KHR_materials_variants.mappings[].variants[]", Index),
    ("textures[].source", Index),
    ("textures[].extensions.EXT_texture_webp.source", Index),
    ("textures[].extensions.KHR_texture_basisu.source", Index),
    ("textures[].sampler", Index),
    ("samplers[].wrapS", Code(WRAPS)),
    ("samplers[].wrapT", Code(WRAPS)),
    ("samplers[].magFilter", Code(&[9728, 9729])),
    ("samplers[].minFilter", Code(&[9728, 9729, 9984, 9985, 9986, 9987])),
    ("images[].uri", Text),
    ("images[].bufferView", Index),
    ("images[].mimeType", Text),
    ("skins[].name", Text),
    ("skins[].joints[]", Index),
    ("skins[].inverseBindMatrices", Index),
    ("animations[].name", Text),
    ("animations[].channels[].sampler", Index),
    ("animations[].channels[].target.node", Index),
    ("animations[].channels[].target.path", Text),
    ("animations[].samplers[].input", Index),
    ("animations[].samplers[].output", Index),
    ("animations[].samplers[].interpolation", Text),
];

/// Extensions of buffer views that have the members below.
pub const COMPRESSIONS: [&str; 2] =
    ["bufferViews[].extensions.EXT_meshopt_compression", "bufferViews[].extensions.KHR_meshopt_compression"];

/// Members of a compressed buffer view.
pub const COMPRESSED: &[(&str, Kind)] = &[
    ("buffer", Index),
    ("byteOffset", Size),
    ("byteLength", Size),
    ("byteStride", Size),
    ("count", Size),
    ("mode", Word(&["ATTRIBUTES", "TRIANGLES", "INDICES"])),
    ("filter", Word(&["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"])),
];

/// Wraps of textures: clamped, mirrored, repeated.
const WRAPS: &[u64] = &[33071, 33648, 10497];
