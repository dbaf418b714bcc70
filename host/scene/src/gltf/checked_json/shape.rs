//! Shape of a document: the JSON type of each member that is read [glTF 2.0, JSON schemas]. A member of another type is refused
//! with its path, since a default would render another scene. Ranges of numbers are checked where they are used. `null` counts as
//! a missing member, since serializers write it so.

use serde_json::Value;

use self::members::Kind::{Code, Flag, Index, Number, Numbers, Size, Text, Word};
use self::members::{COMPRESSED, COMPRESSIONS, DOCUMENT, Kind, TEXTURE, TEXTURES};
use caustics_files::text::cut;

mod members;

/// Refuses a document with a value of a wrong type. The error names its path, its value and the expected type.
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

/// Checks the members at a path below a value. The fault begins with the path.
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

/// Text of a value in a message.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(elements) => format!("a list of {}", elements.len()),
        Value::Object(_) => "an object".into(),
        Value::String(text) => format!("{:?}", cut(text, 80)),
        value => value.to_string(),
    }
}
