//! Cameras: removes members that are not read.

use serde_json::{Value, json};

use super::element::elements;

/// Removes everything but the field of view of perspective cameras.
pub fn reduce(document: &mut Value) {
    for camera in elements(document, "cameras") {
        let Some(members) = camera.as_object_mut() else { continue };
        members.remove("orthographic");
        let perspective = members.remove("perspective").filter(|lens| lens["yfov"].is_number());
        if let Some(lens) =
            perspective.filter(|_| members.get("type").is_none_or(|kind| kind == "perspective"))
        {
            let lens = json!({ "yfov": lens["yfov"], "aspectRatio": lens["aspectRatio"], "znear": 0.01 });
            members.insert("perspective".into(), lens);
        }
        members.entry("type").or_insert(json!("perspective"));
    }
}
