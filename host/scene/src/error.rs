//! What can be wrong with a scene: the file, the part of it, and what to do.

use caustics_files::memory::shown;

/// Why a scene cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// No such scene.
    #[error(
        "no scene {argument:?}: give a .gltf or .glb file, a folder with a scene.gltf, or one of: {known}"
    )]
    Unknown {
        /// What was asked for.
        argument: String,
        /// Scenes that can be named.
        known: String,
    },
    /// A scene that is made on demand, and was not yet.
    #[error("scene {name} is made on demand: run `caustics scene make {name}` first")]
    NotMade {
        /// The scene.
        name: String,
    },
    /// A file cannot be read.
    #[error("{file}: cannot be read ({source}); check the path and its permissions")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A .glb container is damaged.
    #[error("{file}: not a whole binary glTF 2.0 file ({what}); export or download it again")]
    Container {
        /// The file.
        file: String,
        /// What is wrong.
        what: String,
    },
    /// The JSON is no glTF.
    #[error("{file}: not a glTF 2.0 document ({what}); check it with the Khronos glTF validator")]
    Document {
        /// The file.
        file: String,
        /// What is wrong.
        what: String,
    },
    /// The file cannot be shown without an extension that is not supported.
    #[error("{file}: requires the extension {extension:?}, which is not supported; {remedy}")]
    RequiredExtension {
        /// The file.
        file: String,
        /// The extension.
        extension: String,
        /// What to do.
        remedy: &'static str,
    },
    /// A file that requires an extension which is not supported cannot be read without it either.
    #[error(
        "{file}: requires the extension {extension:?}, which is not supported; {remedy} (without it {source})"
    )]
    WithoutExtension {
        /// The file.
        file: String,
        /// The extension.
        extension: String,
        /// What to do.
        remedy: &'static str,
        /// What is wrong without it.
        source: Box<SceneError>,
    },
    /// The file is of the first version of glTF.
    #[error("{file}: is glTF 1.0, which is not read; convert it: npx gltf-pipeline -i OLD.gltf -o NEW.gltf")]
    OldVersion {
        /// The file.
        file: String,
    },
    /// An environment cannot be used.
    #[error("environment {file}: {what}")]
    Environment {
        /// Its file, or the scene.
        file: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A buffer is missing, too short, or not to be had.
    #[error("{file}: buffer {buffer} {what}; restore the file beside the .gltf or export the scene again")]
    Buffer {
        /// The file.
        file: String,
        /// Index of the buffer.
        buffer: usize,
        /// What is wrong.
        what: String,
    },
    /// What is compressed cannot be decompressed.
    #[error("{file}: {what}; decompress it: npx @gltf-transform/cli copy IN.glb OUT.glb")]
    Compressed {
        /// The file.
        file: String,
        /// What is wrong with what.
        what: String,
    },
    /// An accessor does not fit its buffer or its use.
    #[error("{file}: accessor {accessor} ({owner}) {what}; export the scene again")]
    Accessor {
        /// The file.
        file: String,
        /// Index of the accessor.
        accessor: usize,
        /// Mesh and primitive that it serves.
        owner: String,
        /// What is wrong.
        what: String,
    },
    /// A mesh holds values that no image can come from.
    #[error("{file}: {mesh}: {what}; repair the mesh and export the scene again")]
    Mesh {
        /// The file.
        file: String,
        /// Mesh and primitive.
        mesh: String,
        /// What is wrong.
        what: String,
    },
    /// A node cannot be placed.
    #[error("{file}: {node}: {what}; repair the node and export the scene again")]
    Node {
        /// The file.
        file: String,
        /// The node.
        node: String,
        /// What is wrong.
        what: String,
    },
    /// An animation cannot be played.
    #[error("{file}: {animation} {what}; repair the animation and export the scene again")]
    Animation {
        /// The file.
        file: String,
        /// The animation and its channel.
        animation: String,
        /// What is wrong.
        what: String,
    },
    /// A material has values out of range.
    #[error("{file}: material {material:?} has {what}; set it to a value that glTF allows")]
    Material {
        /// The file.
        file: String,
        /// The material.
        material: String,
        /// What is wrong.
        what: String,
    },
    /// An index points at nothing.
    #[error("{file}: {owner} refers to {kind} {index}, but there are {count}; export the scene again")]
    Index {
        /// The file.
        file: String,
        /// Who refers.
        owner: String,
        /// What it refers to.
        kind: &'static str,
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// Tables given by a program do not belong together.
    #[error("{file}: {what}")]
    Tables {
        /// The scene's name.
        file: String,
        /// What is wrong.
        what: String,
    },
    /// More texels than the kernels' buffers hold.
    #[error("{file}: its textures have {count} texels with all levels, but {limit} fit; make them smaller")]
    Texels {
        /// The file.
        file: String,
        /// Texels.
        count: u64,
        /// Texels at most.
        limit: u64,
    },
    /// More memory than there is.
    #[error(
        "{file}: {what} would take {} of memory, but {} are available; make the scene smaller, or more memory available",
        shown(*.needed), shown(*.available)
    )]
    Memory {
        /// The file.
        file: String,
        /// What takes it.
        what: String,
        /// By an estimate (bytes).
        needed: u64,
        /// What is left (bytes).
        available: u64,
    },
    /// An image cannot be had.
    #[error(
        "{file}: image {image} {what}; give it as a PNG, JPEG, WebP or KTX 2.0 file beside the .gltf or inside of it"
    )]
    Image {
        /// The file.
        file: String,
        /// Index of the image.
        image: usize,
        /// What is wrong.
        what: String,
    },
    /// Nothing to see in the whole file.
    #[error("{file}: {what}; {remedy}")]
    NothingToSee {
        /// The file.
        file: String,
        /// Why.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Nothing to see.
    #[error(
        "{file}: no geometry ({dropped} triangles without an area were dropped); add a mesh of triangles"
    )]
    NoGeometry {
        /// The file.
        file: String,
        /// Dropped triangles.
        dropped: usize,
    },
    /// Nothing to see it by.
    #[error(
        "{file}: no light; give a material an emissiveFactor above zero or add a punctual light, or leave \
         --no-default-light out"
    )]
    NoLight {
        /// The file.
        file: String,
    },
    /// No camera of this name.
    #[error("scene {scene} has no camera {camera}; it has {known}")]
    UnknownCamera {
        /// The scene.
        scene: String,
        /// What was asked for.
        camera: String,
        /// Cameras that there are.
        known: String,
    },
    /// No variant of this name.
    #[error("{file}: there is no variant {variant:?} of its materials; there are: {known}")]
    UnknownVariant {
        /// The file.
        file: String,
        /// What was asked for.
        variant: String,
        /// Variants that there are.
        known: String,
    },
    /// No animation of this name.
    #[error("{file}: there is no animation {animation:?}; there are: {known}")]
    UnknownAnimation {
        /// The file.
        file: String,
        /// What was asked for.
        animation: String,
        /// Animations that there are.
        known: String,
    },
    /// Nobody to see it.
    #[error(
        "scene {scene} has no perspective camera; add one to the file, or place one (Scene::place_camera)"
    )]
    NoCamera {
        /// The scene.
        scene: String,
    },
    /// Edits that cannot be read, or are of another scene.
    #[error("{file}: {what}")]
    Edits {
        /// The file of the edits, or that of the scene.
        file: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A camera that cannot be placed.
    #[error("the camera {viewpoint} {what}; give --from, --look-at or an orbit otherwise")]
    Viewpoint {
        /// The options that say where it is.
        viewpoint: String,
        /// What is wrong.
        what: &'static str,
    },
}

impl SceneError {
    /// Whether the caller asked for what the scene does not have, rather than the scene being wrong.
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
