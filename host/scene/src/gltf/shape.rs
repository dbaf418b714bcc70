//! The shape of a document: which JSON type stands where [glTF 2.0, JSON schemas]. What is of another type is refused
//! with its path, since a default in its stead would render another scene. Ranges of numbers are checked where they are
//! used; `null` is taken for a member that is not there, as serializers write it.

use serde_json::Value;

use self::Kind::{Code, Flag, Index, Number, Numbers, Size, Text, Word};
use caustics_files::text::cut;

/// What a value must be.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A string.
    Text,
    /// One of these strings.
    Word(&'static [&'static str]),
    /// One of these integers.
    Code(&'static [u64]),
    /// An index of a list, below 2^32 - 1.
    Index,
    /// A whole number from 0 on.
    Size,
    /// Any number.
    Number,
    /// A list of so many numbers.
    Numbers(usize),
    /// true or false.
    Flag,
}

/// Members of a reference to a texture.
const TEXTURE: &[(&str, Kind)] = &[
    ("index", Index),
    ("texCoord", Index),
    ("scale", Number),
    ("strength", Number),
    ("extensions.KHR_texture_transform.offset", Numbers(2)),
    ("extensions.KHR_texture_transform.rotation", Number),
    ("extensions.KHR_texture_transform.scale", Numbers(2)),
    ("extensions.KHR_texture_transform.texCoord", Index),
];

/// Where materials have one.
const TEXTURES: [&str; 7] = [
    "materials[].pbrMetallicRoughness.baseColorTexture",
    "materials[].pbrMetallicRoughness.metallicRoughnessTexture",
    "materials[].normalTexture",
    "materials[].emissiveTexture",
    "materials[].occlusionTexture",
    "materials[].extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture",
    "materials[].extensions.KHR_materials_pbrSpecularGlossiness.specularGlossinessTexture",
];

/// Everything that is read: `[]` is every element of a list, `*` every member of an object.
const DOCUMENT: &[(&str, Kind)] = &[
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
const COMPRESSIONS: [&str; 2] =
    ["bufferViews[].extensions.EXT_meshopt_compression", "bufferViews[].extensions.KHR_meshopt_compression"];

/// Members of a compressed buffer view.
const COMPRESSED: &[(&str, Kind)] = &[
    ("buffer", Index),
    ("byteOffset", Size),
    ("byteLength", Size),
    ("byteStride", Size),
    ("count", Size),
    ("mode", Word(&["ATTRIBUTES", "TRIANGLES", "INDICES"])),
    ("filter", Word(&["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"])),
];

/// Clamped, mirrored, repeated.
const WRAPS: &[u64] = &[33071, 33648, 10497];

/// Refuses a document with a value of a wrong type: its path, what it is and what it should be.
pub fn check(document: &Value) -> Result<(), String> {
    let found = |fault: String| fault.trim_start_matches('.').to_string();
    for (path, kind) in DOCUMENT {
        walk(document, path, *kind).map_err(found)?;
    }
    for (paths, members) in [(&TEXTURES[..], TEXTURE), (&COMPRESSIONS[..], COMPRESSED)] {
        for path in paths {
            for (member, kind) in members {
                walk(document, &format!("{path}.{member}"), *kind).map_err(found)?;
            }
        }
    }
    Ok(())
}

/// Checks what stands at a path below a value. The fault begins with the path.
fn walk(value: &Value, path: &str, kind: Kind) -> Result<(), String> {
    if path.is_empty() {
        return check_value(value, kind);
    }
    let wrong = |should: &str| Err(format!(" is {} and should be {should}", shown(value)));
    if let Some(rest) = path.strip_prefix("[]") {
        let Value::Array(elements) = value else { return wrong("a list") };
        let rest = rest.strip_prefix('.').unwrap_or(rest);
        let mut elements = elements.iter().enumerate();
        return elements.try_for_each(|(index, element)| {
            walk(element, rest, kind).map_err(|fault| format!("[{index}]{fault}"))
        });
    }
    let Value::Object(members) = value else { return wrong("an object") };
    let (key, rest) = path.split_at(path.find(['.', '[']).unwrap_or(path.len()));
    let rest = rest.strip_prefix('.').unwrap_or(rest);
    let check = |(key, member): (&String, &Value)| match member {
        Value::Null => Ok(()),
        member => walk(member, rest, kind).map_err(|fault| format!(".{}{fault}", cut(key, 80))),
    };
    match key {
        "*" => members.iter().try_for_each(check),
        key => members.get_key_value(key).map_or(Ok(()), check),
    }
}

fn check_value(value: &Value, kind: Kind) -> Result<(), String> {
    let whole = value.as_u64();
    let (fits, should) = match kind {
        Text => (value.is_string(), "a string".into()),
        Word(words) => {
            (value.as_str().is_some_and(|text| words.contains(&text)), format!("one of {}", words.join(", ")))
        }
        Code(codes) => {
            let known: Vec<_> = codes.iter().map(u64::to_string).collect();
            (whole.is_some_and(|code| codes.contains(&code)), format!("one of {}", known.join(", ")))
        }
        Index => (whole.is_some_and(|index| index < u64::from(u32::MAX)), "an index below 2^32 - 1".into()),
        Size => (whole.is_some(), "a whole number from 0 on".into()),
        Number => (value.is_number(), "a number".into()),
        Numbers(count) => {
            let fits = |list: &Vec<Value>| list.len() == count && list.iter().all(Value::is_number);
            (value.as_array().is_some_and(fits), format!("a list of {count} numbers"))
        }
        Flag => (value.is_boolean(), "true or false".into()),
    };
    if fits { Ok(()) } else { Err(format!(" is {} and should be {should}", shown(value))) }
}

/// A value in a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(elements) => format!("a list of {}", elements.len()),
        Value::Object(_) => "an object".into(),
        Value::String(text) => format!("{:?}", cut(text, 80)),
        value => value.to_string(),
    }
}
