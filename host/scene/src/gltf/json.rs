//! Stage 1, the text: parses JSON into a tree of values. Content that glTF leaves open does not end the parser.

use serde_json::Value;

/// Maximum depth of brackets. The JSON parser stops at 128; glTF needs a dozen.
const MAX_DEPTH: usize = 100;

/// Parses a text. `extras` and unknown extensions may nest to any depth and hold any number: if the parser refuses them, the text
/// is read without them.
pub fn parse(json: &[u8]) -> Result<Value, serde_json::Error> {
    let mut value = serde_json::from_slice(json).or_else(|_| {
        // Find errors of the text without recursion and without building values.
        serde_json::from_slice::<serde::de::IgnoredAny>(json)?;
        serde_json::from_slice(&tamed(json))
    })?;
    make_whole(&mut value);
    Ok(value)
}

/// Text that the parser accepts: numbers beyond f64 become very large ones, and lists and objects at the maximum depth become
/// empty.
fn tamed(json: &[u8]) -> Vec<u8> {
    let mut depth = 0_usize;
    let mut kept = Vec::with_capacity(json.len());
    for token in tokens(json) {
        if matches!(token, b"]" | b"}") {
            depth = depth.saturating_sub(1);
        }
        if depth < MAX_DEPTH {
            let number = std::str::from_utf8(token).ok().and_then(|token| token.parse::<f64>().ok());
            kept.extend_from_slice(match number {
                Some(f64::INFINITY) => b"1e308",
                Some(f64::NEG_INFINITY) => b"-1e308",
                _ => token,
            });
        }
        if matches!(token, b"[" | b"{") {
            depth += 1;
        }
    }
    kept
}

/// Tokens of a text: strings with their quotes, numbers, and single bytes.
fn tokens(json: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = json;
    std::iter::from_fn(move || {
        let length = match *rest.first()? {
            b'"' => {
                let mut is_escaped = false;
                let is_end = |&byte: &u8| {
                    let is_end = byte == b'"' && !is_escaped;
                    is_escaped = byte == b'\\' && !is_escaped;
                    is_end
                };
                rest[1..].iter().position(is_end).map_or(rest.len(), |at| at + 2)
            }
            _ => {
                let is_of_number =
                    |byte: &&u8| matches!(byte, b'0'..=b'9' | b'+' | b'-' | b'.' | b'e' | b'E');
                rest.iter().take_while(is_of_number).count().max(1)
            }
        };
        let (token, behind) = rest.split_at(length);
        rest = behind;
        Some(token)
    })
}

/// Converts whole numbers to integers: 3.0 may stand for an integer of glTF.
fn make_whole(value: &mut Value) {
    match value {
        Value::Array(elements) => elements.iter_mut().for_each(make_whole),
        Value::Object(members) => members.values_mut().for_each(make_whole),
        Value::Number(number) if number.is_f64() => {
            let exact = number.as_f64().filter(|x| x.fract() == 0.0 && x.abs() <= (1_u64 << 53) as f64);
            if let Some(whole) = exact.filter(|x| *x != 0.0 || x.is_sign_positive()) {
                *value = (whole as i64).into();
            }
        }
        _ => {}
    }
}

/// Removes all `extras`: they may be any JSON, which the document types do not support.
pub fn remove_extras(value: &mut Value) {
    match value {
        Value::Array(elements) => elements.iter_mut().for_each(remove_extras),
        Value::Object(members) => {
            members.remove("extras");
            members.values_mut().for_each(remove_extras);
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_lists_that_nest_too_deep_are_emptied() {
        let deep = |depth: usize| format!("{}1{}", "[".repeat(depth), "]".repeat(depth));
        let text = |depth: usize| format!(r#"{{"a":{},"b":"[\\\"[","c":[[2]]}}"#, deep(depth));
        let (near, far) = (text(MAX_DEPTH - 2), text(100_000));
        assert_eq!(tamed(near.as_bytes()), near.as_bytes());
        let read = parse(far.as_bytes()).unwrap();
        assert_eq!((&read["b"], &read["c"][0][0]), (&"[\\\"[".into(), &2.into()));
        let mut depth = 0;
        let mut at = &read["a"];
        while let Some(inner) = at.as_array() {
            (depth, at) = (depth + 1, inner.first().unwrap_or(&Value::Null));
        }
        assert_eq!(depth, MAX_DEPTH - 1);
        for broken in ["[".repeat(100_000), format!("{}}}", deep(300)), deep(300).replacen(']', "}", 1)] {
            assert!(parse(broken.as_bytes()).is_err());
        }
    }

    #[test]
    fn numbers_beyond_f64_become_very_large_ones() {
        let text =
            r#"{"1e999":["1e999\\\"1e999",1e999,-1e999,{"a":123456789e400}],"b":[true,false,1.5e3,-0]}"#;
        let read = parse(text.as_bytes()).unwrap();
        assert_eq!(read["1e999"], serde_json::json!(["1e999\\\"1e999", 1e308, -1e308, { "a": 1e308 }]));
        assert_eq!(read["b"], serde_json::json!([true, false, 1500, -0.0]));
        assert!(parse(b"[1e999,1e]").is_err() && parse(b"[1e999").is_err());
    }
}
