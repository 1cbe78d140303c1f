//! Settings by dotted name.

use pt_core::settings::{
    InvalidValue, SettingsError, Validate, apply_profile, apply_set, apply_sets, apply_toml, check_range,
    list_keys,
};
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Operator {
    Aces,
    None,
    Reinhard,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Post {
    exposure: f32,
    min_ev: f32,
    max_ev: f32,
    operator: Operator,
    bloom: bool,
    clamp: Option<f32>,
    tint: [f32; 3],
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Camera {
    exposure: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Params {
    bounces: u8,
    camera: Camera,
    seed: u64,
    label: String,
    post: Post,
}

impl Default for Params {
    fn default() -> Self {
        let post = Post {
            exposure: 0.1,
            min_ev: -4.0,
            max_ev: 4.0,
            operator: Operator::Aces,
            bloom: true,
            clamp: None,
            tint: [1.0, 1.0, 1.0],
        };
        Self { bounces: 2, camera: Camera { exposure: 1.0 }, seed: 0, label: "plain".into(), post }
    }
}

impl Validate for Post {
    fn validate(&self) -> Result<(), InvalidValue> {
        check_range("exposure", self.exposure, 0.0..=100.0, "")?;
        check_range("min_ev", self.min_ev, -20.0..=self.max_ev, "EV")
    }
}

impl Validate for Params {
    fn validate(&self) -> Result<(), InvalidValue> {
        self.post.validate().map_err(|error| error.within("post"))
    }
}

fn set(assignment: &str) -> Params {
    let mut params = Params::default();
    apply_set(&mut params, assignment).unwrap();
    params
}

/// The message for a setting that must be refused and change nothing.
fn refused(assignment: &str) -> String {
    let mut params = Params::default();
    let error = apply_set(&mut params, assignment).unwrap_err();
    assert_eq!(params, Params::default(), "{assignment} was refused, yet something changed");
    let text = error.to_string();
    assert!(!text.contains('\n'), "one line: {text}");
    text
}

#[test]
fn every_kind_of_leaf_is_set() {
    assert_eq!(set("bounces=7").bounces, 7);
    assert_eq!(set("seed=18446744073709551615").seed, u64::MAX);
    assert_eq!(set("label=two words = fine").label, "two words = fine");
    assert_eq!(set("post.exposure=2").post.exposure, 2.0);
    assert_eq!(set("post.exposure = 1e-3").post.exposure, 1e-3);
    assert!(!set("post.bloom=false").post.bloom);
    assert_eq!(set("post.operator=reinhard").post.operator, Operator::Reinhard);
    assert_eq!(set("post.operator=none").post.operator, Operator::None);
    assert_eq!(set("post.clamp=3").post.clamp, Some(3.0));
    assert_eq!(set("post.tint=[1, 0.5, 0.25]").post.tint, [1.0, 0.5, 0.25]);
}

#[test]
fn optional_values_can_be_taken_away_again() {
    let mut params = set("post.clamp=3");
    apply_set(&mut params, "post.clamp=none").unwrap();
    assert_eq!(params.post.clamp, None);
    apply_toml(&mut params, "[post]\nclamp = 2.5").unwrap();
    assert_eq!(params.post.clamp, Some(2.5));
    apply_toml(&mut params, "[post]\nclamp = \"none\"").unwrap();
    assert_eq!(params.post.clamp, None);
    assert!(refused("post.exposure=none").contains("finite number"));
}

#[test]
fn unknown_keys_name_the_closest_and_the_table() {
    assert_eq!(
        refused("post.expsure=1"),
        r#"unknown key "post.expsure", closest: "post.exposure" ("post" has: bloom, clamp, exposure, max_ev, min_ev, operator, tint)"#
    );
    let without_table = refused("exposure=1");
    assert!(without_table.contains(r#"closest: "post.exposure""#), "{without_table}");
    assert!(
        without_table.contains("the top level has: bounces, camera, label, post, seed"),
        "{without_table}"
    );
    assert!(refused("pots.exposure=1").contains(r#"closest: "post.exposure""#), "the likest table");
    assert!(refused("pots.bloom=true").contains(r#"closest: "post.bloom""#));
    assert!(refused("bounces.deep=1").contains(r#"unknown key "bounces.deep""#));
    assert!(refused("post=1").contains(r#"key "post" is a table, set one of its keys: bloom"#));
    assert!(refused("post.=1").contains("unknown key"));
}

#[test]
fn wrong_types_and_ranges_name_what_is_expected() {
    assert_eq!(
        refused("post.bloom=maybe"),
        r#"key "post.bloom": expected boolean (true or false), got maybe"#
    );
    assert!(refused("bounces=2.5").contains("expected integer, got 2.5"));
    assert!(refused("bounces=many").contains("expected integer, got many"));
    assert!(refused("bounces=256").contains("expected u8"));
    assert!(refused("bounces=-1").contains("expected u8"));
    assert!(refused("post.exposure=bright").contains("expected finite number, got bright"));
    assert!(refused("post.exposure=nan").contains("expected finite number"));
    assert!(refused("post.max_ev=1e300").contains("expected finite number, got 1e300"));
    assert!(refused("post.operator=filmic").contains("expected one of `aces`, `none`, `reinhard`"));
    assert!(refused("post.tint=[1, 2]").contains("post.tint"));
    assert!(refused("post.tint=1").contains("expected array of 3 values like [1.0, 1.0, 1.0]"));
    assert_eq!(refused("post.exposure=-1"), "post.exposure: -1 is out of range, expected 0 to 100");
    assert_eq!(refused("post.min_ev=5"), "post.min_ev: 5 is out of range, expected -20 to 4 EV");
    assert!(refused("post.exposure").contains("not of the form stage.key=value"));
    assert!(refused("=1").contains("not of the form"));
}

#[test]
fn several_keys_may_move_a_range_together() {
    let mut params = Params::default();
    apply_sets(&mut params, &["post.min_ev=5", "post.max_ev=8"]).unwrap();
    assert_eq!((params.post.min_ev, params.post.max_ev), (5.0, 8.0));
    let before = params.clone();
    apply_sets(&mut params, &["bounces=1", "post.min_ev=9"]).unwrap_err();
    assert_eq!(params, before, "all or nothing");
}

#[test]
fn profiles_lie_over_what_is_there() {
    let mut params = set("post.exposure=3");
    apply_toml(&mut params, "bounces = 4\n[post]\nmin_ev = 6\nmax_ev = 7.5\ntint = [0, 0, 1]\n").unwrap();
    let mut expected = set("post.exposure=3");
    expected.bounces = 4;
    expected.post = Post { min_ev: 6.0, max_ev: 7.5, tint: [0.0, 0.0, 1.0], ..expected.post };
    assert_eq!(params, expected);
}

#[test]
fn profile_errors_name_file_and_key() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fast.toml");
    let message = |text: &[u8]| {
        std::fs::write(&path, text).unwrap();
        let mut params = Params::default();
        let error = apply_profile(&mut params, &path).unwrap_err();
        assert_eq!(params, Params::default());
        let message = error.to_string();
        assert!(message.starts_with(&format!("profile {}: ", path.display())), "{message}");
        assert!(!message.contains('\n'), "{message}");
        message
    };
    assert!(message(b"[post]\nexposre = 1").contains(r#"closest: "post.exposure""#));
    assert!(message(b"[pots]\nexposure = 1").contains(r#"unknown key "pots""#));
    assert!(message(b"[pots]").contains(r#"unknown key "pots""#));
    assert!(message(b"post = 3").contains("is a table"));
    assert!(message(b"[bounces]\ndeep = 3").contains("bounces"));
    assert!(message(b"[post]\nbloom = 1").contains(r#"key "post.bloom": expected boolean"#));
    assert!(message(b"[post]\nexposure = 1979-05-27").contains("expected finite number"));
    assert!(message(b"bounces = 1\nseed = = 2").contains("line 2: "));
    assert!(message(b"bounces = 1\nbounces = 2").contains("line 2: "));
    assert!(message(b"\xff\xfe").contains("not UTF-8"));
    let missing = apply_profile(&mut Params::default(), &folder.path().join("none.toml")).unwrap_err();
    assert!(matches!(missing, SettingsError::Profile { .. } | SettingsError::File(_)));
    assert!(missing.to_string().contains("none.toml"), "{missing}");
}

#[test]
fn listing_shows_key_value_and_type() {
    let listed: Vec<_> = list_keys(&Params::default())
        .unwrap()
        .into_iter()
        .map(|info| format!("{} = {} ({})", info.key, info.value, info.kind))
        .collect();
    assert_eq!(
        listed,
        [
            "bounces = 2 (integer)",
            "camera.exposure = 1.0 (number)",
            "label = \"plain\" (string)",
            "post.bloom = true (boolean)",
            "post.clamp = none (optional)",
            "post.exposure = 0.1 (number)",
            "post.max_ev = 4.0 (number)",
            "post.min_ev = -4.0 (number)",
            "post.operator = \"aces\" (string)",
            "post.tint = [1.0, 1.0, 1.0] (array)",
            "seed = 0 (integer)",
        ]
    );
}

/// What is listed can be set: the listing is the documentation of `--set`.
#[test]
fn every_listed_key_takes_its_own_value() {
    for info in list_keys(&Params::default()).unwrap() {
        let value = info.value.trim_matches('"');
        assert_eq!(set(&format!("{}={value}", info.key)), Params::default(), "{}", info.key);
    }
}
