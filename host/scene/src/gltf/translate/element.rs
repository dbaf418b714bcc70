//! Elements of a document, to be changed.

use serde_json::Value;

/// Elements of a section, to be changed.
pub fn elements<'a>(document: &'a mut Value, section: &str) -> impl Iterator<Item = &'a mut Value> {
    document.get_mut(section).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Takes an extension out of an element.
pub fn take_extension(element: &mut Value, name: &str) -> Option<Value> {
    element.get_mut("extensions")?.as_object_mut()?.remove(name).filter(|extension| !extension.is_null())
}
