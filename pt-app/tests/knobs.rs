//! The knobs that are listed, those that can be set, and those that the READMEs show are the same.

mod book;

use pt_app::params::{FrameParams, ReferenceSettings, all_knobs, resolve, resolve_reference};
use pt_core::settings::Knob;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::{Command, Output};

fn pt(line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pt")).args(line.split_whitespace()).output().unwrap()
}

fn listed(line: &str) -> Vec<Value> {
    let done = pt(line);
    assert!(done.status.success(), "pt {line}: {done:?}");
    serde_json::from_slice(&done.stdout).unwrap()
}

/// Dotted names of the leaves: what serde takes, and so `--set`.
fn leaves(prefix: &str, tree: &Value, keys: &mut BTreeSet<String>) {
    match tree {
        Value::Object(table) => {
            for (name, inner) in table {
                let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
                leaves(&key, inner, keys);
            }
        }
        _ => assert!(keys.insert(prefix.into()), "{prefix} twice"),
    }
}

#[test]
fn every_key_that_can_be_set_is_listed_with_all_that_there_is_to_say() {
    let mut keys = BTreeSet::new();
    leaves("", &serde_json::to_value(FrameParams::default()).unwrap(), &mut keys);
    leaves("", &serde_json::to_value(ReferenceSettings::default()).unwrap(), &mut keys);
    let knobs = listed("knobs --json");
    let said: BTreeSet<_> = knobs.iter().map(|knob| knob["key"].as_str().unwrap().to_owned()).collect();
    assert_eq!(said, keys);
    assert_eq!(knobs.len(), keys.len());
    for knob in &knobs {
        let fields: Vec<_> = knob.as_object().unwrap().keys().map(String::as_str).collect();
        let contract = ["default", "doc", "key", "range", "source", "structural", "type", "unit", "values"];
        assert_eq!(fields, contract, "{knob}");
        let doc = knob["doc"].as_str().unwrap();
        assert!(doc.ends_with('.') && doc.len() > 10, "{knob}");
        assert!(!doc.trim_end_matches('.').contains(". "), "one sentence: {knob}");
        let kind = knob["type"].as_str().unwrap();
        let is_number = kind.ends_with("number") || kind.ends_with("integer");
        assert_eq!(knob["range"].is_array(), is_number, "{knob}");
        assert_eq!(knob["values"].is_array(), !is_number, "{knob}");
        if let (Some(value), Some([least, greatest])) =
            (knob["default"].as_f64(), knob["range"].as_array().map(Vec::as_slice))
        {
            assert!((least.as_f64().unwrap()..=greatest.as_f64().unwrap()).contains(&value), "{knob}");
        }
    }
}

/// What is listed as the default can be set and changes nothing; the ends of a range can be set unless another knob forbids it.
#[test]
fn every_knob_takes_what_it_says() {
    let set = |knob: &Knob, value: &str| {
        let sets = [format!("{}={value}", knob.key)];
        if knob.key.starts_with("reference.") {
            resolve_reference(ReferenceSettings::default(), None, &sets)
                .map(|p| p == ReferenceSettings::default())
        } else {
            resolve(None, &sets, false).map(|p| p == FrameParams::default())
        }
    };
    for knob in all_knobs() {
        assert!(set(&knob, &knob.default_text()).unwrap(), "{}", knob.key);
        for value in knob.values {
            set(&knob, value.name).unwrap();
        }
        let Some(ends) = &knob.range else { continue };
        for end in ends {
            knob.check(&end.to_string()).unwrap();
        }
        let Some(greatest) = ends[1].as_f64().filter(|greatest| *greatest < f64::from(u32::MAX)) else {
            continue;
        };
        let beyond = (greatest + 1.0).to_string();
        assert!(knob.check(&beyond).is_err(), "{}={beyond}", knob.key);
        let error = set(&knob, &beyond).unwrap_err().to_string();
        assert!(error.contains(&knob.key) && error.contains("out of range"), "{error}");
    }
}

#[test]
fn a_stage_can_be_asked_for() {
    let keys: Vec<_> = listed("knobs checkerboard --json").iter().map(|knob| knob["key"].clone()).collect();
    assert_eq!(keys, ["checkerboard.blend_split"]);
    let text = String::from_utf8(pt("knobs post").stdout).unwrap();
    assert!(text.contains("post.bloom.sigma = 0.037  [0 to 0.5 heights]"), "{text}");
    let refused = pt("knobs sound");
    assert_eq!(refused.status.code(), Some(2));
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(message.contains("sound") && message.contains("gbuffer, lights") && message.lines().count() == 1);
}

/// The stages whose READMEs have a table of knobs.
const STAGES: [&str; 7] = ["gbuffer", "lights", "indirect", "denoise", "checkerboard", "post", "reference"];

fn table(stage: &str) -> String {
    let mut text =
        String::from("| knob | default | range or values | what it does |\n| --- | --- | --- | --- |\n");
    for knob in all_knobs() {
        let Some(name) = knob.key.strip_prefix(stage).and_then(|rest| rest.strip_prefix('.')) else {
            continue;
        };
        let cells = [format!("`{name}`"), knob.default_text(), knob.takes(), knob.description()];
        text.push_str(&format!("| {} |\n", cells.map(|cell| cell.replace('|', "\\|")).join(" | ")));
    }
    text
}

/// `PT_BLESS=1` writes the tables anew.
#[test]
fn readmes_show_the_knobs_as_they_are() {
    const BEGIN: &str = "<!-- knobs: generated, see pt-app/tests/knobs.rs -->\n";
    const END: &str = "<!-- end of knobs -->\n";
    for stage in STAGES {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../pt-{stage}/README.md"));
        let text = std::fs::read_to_string(&path).unwrap();
        let (before, rest) = text.split_once(BEGIN).unwrap_or_else(|| panic!("{stage}: no table of knobs"));
        let (shown, after) = rest.split_once(END).unwrap_or_else(|| panic!("{stage}: no end of the table"));
        let table = table(stage);
        if std::env::var_os("PT_BLESS").is_some() {
            std::fs::write(&path, format!("{before}{BEGIN}{table}{END}{after}")).unwrap();
        } else {
            assert!(shown == table, "{}: the table of knobs is stale, PT_BLESS=1 writes it", path.display());
        }
    }
}
