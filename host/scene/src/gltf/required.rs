//! Extensions that a file requires and that are not supported. glTF would have such a file refused; what can be read without
//! them is rendered all the same, with a warning.

use serde_json::Value;

use super::options::LoadOptions;
use super::unsupported;
use super::warning::Warnings;
use crate::SceneError;
use caustics_files::text::cut;

/// A required extension that is not supported: the first of a file.
#[derive(Clone, Debug)]
pub struct Lack {
    file: String,
    extension: String,
    remedy: &'static str,
}

impl Lack {
    /// What a document lacks; an error where it is read strictly.
    pub fn find(
        file: &str,
        document: &Value,
        options: &LoadOptions,
        warnings: &mut Warnings,
    ) -> Result<Option<Lack>, SceneError> {
        let mut first = None;
        let required = document["extensionsRequired"].as_array().into_iter().flatten();
        for name in required.filter_map(Value::as_str).filter(|name| !unsupported::EXTENSIONS.contains(name))
        {
            let (extension, remedy) = (cut(name, 80), unsupported::remedy(name));
            if options.strict {
                return Err(SceneError::RequiredExtension { file: file.into(), extension, remedy });
            }
            warnings.note(
                "",
                format_args!(
                    "requires the extension {extension:?}, which is not supported; rendered without it, which may \
                     show another thing than the file means ({remedy})"
                ),
            );
            first.get_or_insert(Lack { file: file.into(), extension, remedy });
        }
        Ok(first)
    }
}

/// An error of a file that is read without what it requires: that may be why.
pub fn without(lack: Option<Lack>, error: SceneError) -> SceneError {
    match lack {
        None => error,
        Some(Lack { file, extension, remedy }) => {
            SceneError::WithoutExtension { file, extension, remedy, source: error.into() }
        }
    }
}
