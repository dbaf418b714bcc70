//! JSON output and results of the program match the schemas in docs/schema.

use std::path::Path;

use caustics::vulkan::{DeviceInfo, DeviceKind};
use serde_json::{Value, json};

use crate::test_dir::{Run, TestDir};

/// Checks a value against a part of a schema, for the keywords of JSON Schema 2020-12 that these schemas use. Other
/// keywords are errors.
struct Check<'a> {
    root: &'a Value,
    faults: Vec<String>,
}

impl Check<'_> {
    fn value(&mut self, schema: &Value, value: &Value, at: &str) {
        let schema = schema.as_object().expect("a schema is an object");
        let none = json!({});
        let properties = schema.get("properties").unwrap_or(&none);
        for (keyword, constraint) in schema {
            match keyword.as_str() {
                "$schema" | "title" | "description" | "$defs" | "properties" => {}
                "$ref" => {
                    let pointer = constraint
                        .as_str()
                        .and_then(|constraint| constraint.strip_prefix('#'))
                        .expect("a place in the schema");
                    let schema =
                        self.root.pointer(pointer).unwrap_or_else(|| panic!("there is no {pointer}"));
                    self.value(schema, value, at);
                }
                "type" => {
                    let fits = match constraint {
                        Value::Array(types) => types.iter().any(|one| is_of_type(value, one)),
                        one => is_of_type(value, one),
                    };
                    self.demand(fits, at, &format!("{value} is no {constraint}"));
                }
                "enum" => {
                    let fits = constraint.as_array().expect("values").contains(value);
                    self.demand(fits, at, &format!("{value} is none of {constraint}"));
                }
                "minimum" => {
                    let fits =
                        value.as_f64().is_none_or(|value| value >= constraint.as_f64().expect("a number"));
                    self.demand(fits, at, &format!("{value} is below {constraint}"));
                }
                "items" => {
                    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                        self.value(constraint, item, &format!("{at}/{index}"));
                    }
                }
                "required" => {
                    for key in
                        constraint.as_array().expect("keys").iter().map(|key| key.as_str().expect("a key"))
                    {
                        let fits = value.as_object().is_none_or(|object| object.contains_key(key));
                        self.demand(fits, at, &format!("{key} is missing"));
                    }
                }
                "additionalProperties" => {
                    let others = value.as_object().into_iter().flatten();
                    for (key, other) in others.filter(|(key, _)| properties.get(key).is_none()) {
                        match constraint {
                            Value::Bool(false) => self.demand(false, at, &format!("{key} is not known")),
                            schema => self.value(schema, other, &format!("{at}/{key}")),
                        }
                    }
                }
                other => panic!("{other} is no keyword that is checked"),
            }
        }
        for (key, schema) in properties.as_object().expect("properties") {
            if let Some(value) = value.get(key) {
                self.value(schema, value, &format!("{at}/{key}"));
            }
        }
    }

    fn demand(&mut self, fits: bool, at: &str, fault: &str) {
        if !fits {
            self.faults.push(format!("{at}: {fault}"));
        }
    }
}

fn is_of_type(value: &Value, name: &Value) -> bool {
    match name.as_str().expect("the name of a type") {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        other => panic!("{other} is no type"),
    }
}

fn faults(name: &str, value: &Value) -> Vec<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema").join(format!("{name}.json"));
    let root: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let mut check = Check { root: &root, faults: Vec::new() };
    check.value(&root, value, "");
    check.faults
}

/// Asserts that a value matches its schema, and that changed values do not.
#[track_caller]
fn holds(name: &str, value: &Value) {
    assert_eq!(faults(name, value), Vec::<String>::new(), "{name}");
    // Change the first element of a list.
    let (object, pointer) = if value.is_array() { (&value[0], "/0") } else { (value, "") };
    let refused = |key: &str, change: &dyn Fn(&mut serde_json::Map<String, Value>)| {
        let mut other = value.clone();
        change(other.pointer_mut(pointer).unwrap().as_object_mut().unwrap());
        assert!(!faults(name, &other).is_empty(), "{name} without, or with another {key}");
    };
    refused("a key that nobody knows", &|object| drop(object.insert("surprise".into(), json!(1))));
    for key in object.as_object().unwrap().keys() {
        // No key holds a list of lists.
        refused(key, &|object| drop(object.insert(key.clone(), json!([[]]))));
        if key != "note" {
            refused(key, &|object| drop(object.remove(key)));
        }
    }
}

/// Returns the JSON that a run prints, which must succeed.
#[track_caller]
fn printed(dir: &TestDir, arguments: &[&str]) -> Value {
    let mut command = dir.command(arguments);
    let output = command.env("CAUSTICS_CACHE", dir.path("cache")).output().unwrap();
    Run::from_output(output).expect_success(arguments).json()
}

const TINY: [&str; 7] = ["--width", "32", "--height", "18", "--runner", "cpu", "--json"];

#[test]
fn output_on_images_and_scenes_matches_the_schemas() {
    let dir = TestDir::new();
    let run = |arguments: &[&str]| printed(&dir, &[arguments, &TINY].concat());
    holds("render", &run(&["render", "mirror-room", "-o", "a.exr", "--frames", "2"]));
    for other in [
        run(&["render", "mirror-room", "-o", "b.exr", "--preset", "frame", "--no-ledger"]),
        run(&["reference", "mirror-room", "-o", "c.exr", "--spp", "2"]),
    ] {
        assert_eq!(faults("render", &other), Vec::<String>::new());
    }
    holds("animate", &run(&["animate", "animated-camera", "-o", "f/#.exr", "--frames", "0..2"]));
    holds("compare", &printed(&dir, &["compare", "a.exr", "c.exr", "--json"]));
    holds("scene-info", &printed(&dir, &["scene", "info", "animated-camera", "--json"]));
    for method in ["basic", "kim2019", "path"] {
        let inspect = ["inspect", "mirror-room", "--pixel", "12,11", "--light-paths", "20000"];
        holds("inspect", &run(&[&inspect[..], &["--method", method]].concat()));
    }
}

#[test]
fn results_match_the_schema() {
    let dir = TestDir::new();
    let bench =
        ["bench", "animated-camera", "--measure", "time,error", "--frames", "2", "--gather", "photons-grid"];
    let options = ["--light-paths", "500", "--reference-frames", "2", "-o", "results"];
    let list = printed(&dir, &[&bench[..], &options, &TINY].concat());
    holds("result", &list[0]);
    let files = dir.path("results/cells").read_dir().unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "json")).collect();
    assert_eq!(files.len(), 1);
    let file: Value = serde_json::from_slice(&std::fs::read(&files[0]).unwrap()).unwrap();
    assert_eq!(faults("result", &file), Vec::<String>::new());
    // Change a value deep inside too.
    let mut wrong = file.clone();
    *wrong.pointer_mut("/time/total_ms/median").unwrap() = json!("fast");
    assert_eq!(faults("result", &wrong), ["/time/total_ms/median: \"fast\" is no \"number\""]);
}

#[test]
fn output_on_devices_matches_the_schema() {
    for kind in [
        DeviceKind::Discrete,
        DeviceKind::Integrated,
        DeviceKind::Virtual,
        DeviceKind::Other,
        DeviceKind::Cpu,
    ] {
        let device = DeviceInfo {
            index: 0,
            name: "a device".into(),
            driver: "a driver".into(),
            kind,
            api_version: "1.3.280".into(),
            usable: false,
            ray_queries: false,
            missing: vec!["scalar block layout"],
            missing_ray_queries: vec![],
            max_storage_buffer_bytes: 1 << 27,
            timestamps: true,
        };
        holds("device", &serde_json::to_value([device]).unwrap());
    }
}
