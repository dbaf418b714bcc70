//! Mutable access to the elements of a document.

use serde_json::Value;

/// Elements of a section.
pub fn elements<'a>(document: &'a mut Value, section: &str) -> impl Iterator<Item = &'a mut Value> {
    document.get_mut(section).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Removes an extension from an element and returns it.
pub fn take_extension(element: &mut Value, name: &str) -> Option<Value> {
    element.get_mut("extensions")?.as_object_mut()?.remove(name).filter(|extension| !extension.is_null())
}
