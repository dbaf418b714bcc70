//! Errors of a scene: they name the file, the part of it, and the remedy.

use caustics_files::memory::shown;

/// Error of a scene: a fault of its file, or a request that it cannot meet.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Unknown scene.
    #[error(
        "no scene {argument:?}: give a .gltf or .glb file, a folder with a scene.gltf, or one of: {known}"
    )]
    Unknown {
        /// Argument of the user.
        argument: String,
        /// Names of the known scenes.
        known: String,
    },
    /// A scene that must be made first.
    #[error("scene {name} is made on demand: run `caustics scene make {name}` first")]
    NotMade {
        /// Name of the scene.
        name: String,
    },
    /// A file cannot be read.
    #[error("{file}: cannot be read ({source}); check the path and its permissions")]
    Unreadable {
        /// The file.
        file: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A .glb container is damaged.
    #[error("{file}: not a whole binary glTF 2.0 file ({what}); export or download it again")]
    Container {
        /// The file.
        file: String,
        /// Description of the fault.
        what: String,
    },
    /// The JSON is no glTF document.
    #[error("{file}: not a glTF 2.0 document ({what}); check it with the Khronos glTF validator")]
    Document {
        /// The file.
        file: String,
        /// Description of the fault.
        what: String,
    },
    /// The file requires an extension that is not supported.
    #[error("{file}: requires the extension {extension:?}, which is not supported; {remedy}")]
    RequiredExtension {
        /// The file.
        file: String,
        /// Name of the extension.
        extension: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The file requires an extension that is not supported, and is not readable without it either.
    #[error(
        "{file}: requires the extension {extension:?}, which is not supported; {remedy} (without it {source})"
    )]
    WithoutExtension {
        /// The file.
        file: String,
        /// Name of the extension.
        extension: String,
        /// Remedy.
        remedy: &'static str,
        /// Error without the extension.
        source: Box<SceneError>,
    },
    /// The file is glTF 1.0.
    #[error("{file}: is glTF 1.0, which is not read; convert it: npx gltf-pipeline -i OLD.gltf -o NEW.gltf")]
    OldVersion {
        /// The file.
        file: String,
    },
    /// An environment cannot be used.
    #[error("environment {file}: {what}")]
    Environment {
        /// Path of the environment, or name of the scene.
        file: String,
        /// Description of the fault and remedy.
        what: String,
    },
    /// A buffer is missing, too short or not available.
    #[error("{file}: buffer {buffer} {what}; restore the file beside the .gltf or export the scene again")]
    Buffer {
        /// The file.
        file: String,
        /// Index of the buffer.
        buffer: usize,
        /// Description of the fault.
        what: String,
    },
    /// Compressed data cannot be decompressed.
    #[error("{file}: {what}; decompress it: npx @gltf-transform/cli copy IN.glb OUT.glb")]
    Compressed {
        /// The file.
        file: String,
        /// Name of the data, and description of the fault.
        what: String,
    },
    /// An accessor fits neither its buffer nor its use.
    #[error("{file}: accessor {accessor} ({owner}) {what}; export the scene again")]
    Accessor {
        /// The file.
        file: String,
        /// Index of the accessor.
        accessor: usize,
        /// Mesh and primitive that use it.
        owner: String,
        /// Description of the fault.
        what: String,
    },
    /// A mesh has values that cannot be rendered.
    #[error("{file}: {mesh}: {what}; repair the mesh and export the scene again")]
    Mesh {
        /// The file.
        file: String,
        /// Mesh and primitive.
        mesh: String,
        /// Description of the fault.
        what: String,
    },
    /// A node has no usable transform.
    #[error("{file}: {node}: {what}; repair the node and export the scene again")]
    Node {
        /// The file.
        file: String,
        /// The node.
        node: String,
        /// Description of the fault.
        what: String,
    },
    /// An animation cannot be played.
    #[error("{file}: {animation} {what}; repair the animation and export the scene again")]
    Animation {
        /// The file.
        file: String,
        /// The animation and its channel.
        animation: String,
        /// Description of the fault.
        what: String,
    },
    /// A material has values out of range.
    #[error("{file}: material {material:?} has {what}; set it to a value that glTF allows")]
    Material {
        /// The file.
        file: String,
        /// The material.
        material: String,
        /// Description of the fault.
        what: String,
    },
    /// An index is out of range.
    #[error("{file}: {owner} refers to {kind} {index}, but there are {count}; export the scene again")]
    Index {
        /// The file.
        file: String,
        /// Object that holds the index.
        owner: String,
        /// Kind of object that it refers to.
        kind: &'static str,
        /// The index.
        index: usize,
        /// Number of these objects.
        count: usize,
    },
    /// Tables of a library user do not fit together.
    #[error("{file}: {what}")]
    Tables {
        /// Name of the scene.
        file: String,
        /// Description of the fault.
        what: String,
    },
    /// The textures have more texels than the kernels' buffers hold.
    #[error("{file}: its textures have {count} texels with all levels, but {limit} fit; make them smaller")]
    Texels {
        /// The file.
        file: String,
        /// Number of texels.
        count: u64,
        /// Maximum number of texels.
        limit: u64,
    },
    /// Loading takes more memory than is available.
    #[error(
        "{file}: {what} would take {} of memory, but {} are available; make the scene smaller, or more memory available",
        shown(*.needed), shown(*.available)
    )]
    Memory {
        /// The file.
        file: String,
        /// Object that takes the memory.
        what: String,
        /// Estimated size (bytes).
        needed: u64,
        /// Available memory (bytes).
        available: u64,
    },
    /// An image is not available.
    #[error(
        "{file}: image {image} {what}; give it as a PNG, JPEG, WebP or KTX 2.0 file beside the .gltf or inside of it"
    )]
    Image {
        /// The file.
        file: String,
        /// Index of the image.
        image: usize,
        /// Description of the fault.
        what: String,
    },
    /// The file has no scene to show.
    #[error("{file}: {what}; {remedy}")]
    NothingToSee {
        /// The file.
        file: String,
        /// Description of the fault.
        what: String,
        /// Remedy.
        remedy: &'static str,
    },
    /// The scene has no geometry.
    #[error(
        "{file}: no geometry ({dropped} triangles without an area were dropped); add a mesh of triangles"
    )]
    NoGeometry {
        /// The file.
        file: String,
        /// Number of dropped triangles.
        dropped: usize,
    },
    /// The scene has no light.
    #[error(
        "{file}: no light; give a material an emissiveFactor above zero or add a punctual light, or leave \
         --no-default-light out"
    )]
    NoLight {
        /// The file.
        file: String,
    },
    /// Unknown camera.
    #[error("scene {scene} has no camera {camera}; it has {known}")]
    UnknownCamera {
        /// The scene.
        scene: String,
        /// Requested name.
        camera: String,
        /// Names of the cameras.
        known: String,
    },
    /// Unknown material variant.
    #[error("{file}: there is no variant {variant:?} of its materials; there are: {known}")]
    UnknownVariant {
        /// The file.
        file: String,
        /// Requested name.
        variant: String,
        /// Names of the variants.
        known: String,
    },
    /// Unknown animation.
    #[error("{file}: there is no animation {animation:?}; there are: {known}")]
    UnknownAnimation {
        /// The file.
        file: String,
        /// Requested name.
        animation: String,
        /// Names of the animations.
        known: String,
    },
    /// The scene has no perspective camera.
    #[error(
        "scene {scene} has no perspective camera; add one to the file, or place one (Scene::place_camera)"
    )]
    NoCamera {
        /// The scene.
        scene: String,
    },
    /// Edits cannot be read, or are of another scene.
    #[error("{file}: {what}")]
    Edits {
        /// File of the edits, or of the scene.
        file: String,
        /// Description of the fault and remedy.
        what: String,
    },
    /// A camera cannot be placed.
    #[error("the camera {viewpoint} {what}; give --from, --look-at or an orbit otherwise")]
    Viewpoint {
        /// Options that place the camera.
        viewpoint: String,
        /// Description of the fault.
        what: &'static str,
    },
}

impl SceneError {
    /// Whether the caller requested something that the scene does not have, and the scene itself is valid.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            SceneError::Unknown { .. }
                | SceneError::NotMade { .. }
                | SceneError::UnknownCamera { .. }
                | SceneError::UnknownVariant { .. }
                | SceneError::UnknownAnimation { .. }
                | SceneError::Viewpoint { .. }
        )
    }
}
