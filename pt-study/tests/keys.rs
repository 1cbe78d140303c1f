//! The keys of study files: the README shows all of them, and what it says is their default.

use pt_core::settings::Knob;
use pt_study::file::Study;
use pt_study::keys::{AXIS, DefaultValue, Key, LEDGER, STUDY, VARIANT};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const KNOBS: [Knob; 0] = [];

fn parse(text: &str) -> Result<Study, String> {
    Study::parse(Path::new("a/s.toml"), text.into(), &KNOBS, &["lights", "denoise"])
        .map(|study| Study { text: String::new(), ..study })
        .map_err(|error| error.to_string())
}

fn table(title: &str, keys: &[Key]) -> String {
    let mut text = format!("| {title} | takes | default | meaning |\n| --- | --- | --- | --- |\n");
    for Key { name, takes, default, meaning } in keys {
        let default = match default {
            DefaultValue::Required => "required".into(),
            DefaultValue::Toml(value) => format!("`{value}`"),
            DefaultValue::Words(words) => (*words).to_owned(),
        };
        writeln!(text, "| `{name}` | {takes} | {default} | {meaning} |").unwrap();
    }
    text
}

/// `PT_BLESS=1` writes the tables anew.
#[test]
fn the_readme_shows_the_keys_as_they_are() {
    const BEGIN: &str = "<!-- keys: generated, see pt-study/tests/keys.rs -->\n";
    const END: &str = "<!-- end of keys -->\n";
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("README.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, rest) = text.split_once(BEGIN).unwrap();
    let (shown, after) = rest.split_once(END).unwrap();
    let tables = [
        table("key", STUDY),
        table("key of `[[axis]]`", AXIS),
        table("key of `[[variant]]`", VARIANT),
        table("key of `[ledger]`", LEDGER),
    ]
    .join("\n");
    if std::env::var_os("PT_BLESS").is_some() {
        std::fs::write(&path, format!("{before}{BEGIN}{tables}{END}{after}")).unwrap();
    } else {
        assert!(shown == tables, "{}: the keys are stale, PT_BLESS=1 writes them", path.display());
    }
}

/// What is said to be the default changes nothing, and a required key is missed.
#[test]
fn defaults_are_as_they_are_said() {
    // Each table with its required keys, and a place for one more.
    let study = |given: &str| format!("scenes = [\"a\"]\nmetrics = [\"relmse\"]\n{given}");
    let axis = |given: &str| study(&format!("[[axis]]\nname = \"x\"\nvalues = [1, 2]\n{given}"));
    let variant = |given: &str| study(&format!("[[variant]]\nname = \"x\"\n{given}"));
    let ledger = |given: &str| study(&format!("[ledger]\n{given}"));
    type Whole<'a> = &'a dyn Fn(&str) -> String;
    let tables: [(&[Key], Whole); 4] =
        [(STUDY, &study), (AXIS, &axis), (VARIANT, &variant), (LEDGER, &ledger)];
    let mut checked = 0;
    for (keys, whole) in tables {
        let without = format!("{:?}", parse(&whole("")).unwrap());
        for key in keys {
            match key.default {
                DefaultValue::Toml(value) => {
                    let found = parse(&whole(&format!("{} = {value}\n", key.name))).unwrap();
                    assert_eq!(format!("{found:?}"), without, "{}", key.name);
                }
                DefaultValue::Required => {
                    let text: String = whole("")
                        .lines()
                        .filter(|line| !line.starts_with(&format!("{} =", key.name)))
                        .map(|line| format!("{line}\n"))
                        .collect();
                    assert!(parse(&text).unwrap_err().contains(key.name), "{}", key.name);
                }
                DefaultValue::Words(_) => continue,
            }
            checked += 1;
        }
    }
    assert!(checked > 15, "{checked}");
}
