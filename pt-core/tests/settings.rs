//! Settings by dotted name.

use pt_core::knobs;
use pt_core::settings::{
    InvalidValue, Knobs, SettingsError, apply_profile, apply_sets, apply_toml, check_range, close_to,
};
use pt_shaders::named_enum;
use serde_json::{Value, json};

named_enum! {
    /// Tone curve.
    pub enum Operator {
        /// A fit.
        Aces = "aces",
        /// Nothing.
        None = "none",
        /// A quotient.
        Reinhard = "reinhard",
    }
}

knobs! {
    /// A table.
    pub struct Post {
        /// Factor.
        pub exposure: f32 = 0.1, in 0.0..=100.0;
        /// Least
        /// exposure.
        pub min_ev: f32 = -4.0, in -20.0..=20.0, unit "EV", source "Someone 1999, section 3";
        /// Greatest exposure.
        pub max_ev: f32 = 4.0, in -20.0..=f32::MAX, unit "EV";
        /// Curve.
        pub operator: Operator = Operator::Aces => structural;
        /// Whether there is bloom.
        pub bloom: bool = true;
        /// Limit.
        pub clamp: Option<f32> = None, in 1.0..=10.0 => structural;
        check Self::check_together;
    }
}

impl Post {
    fn check_together(&self) -> Result<(), InvalidValue> {
        check_range("min_ev", self.min_ev, -20.0..=self.max_ev, "EV")
    }
}

knobs! {
    /// Another table.
    pub struct Camera {
        /// Factor.
        pub exposure: f32 = 1.0, in 0.0..=2.0;
    }
}

knobs! {
    /// The tree.
    pub struct Params {
        /// Bounces.
        pub bounces: u32 = 2, in 0..=255;
        /// Camera.
        pub camera: Camera;
        /// Seed.
        pub seed: u32 = 0, in 0..=u32::MAX;
        /// Post.
        pub post: Post;
    }
}

fn set(assignment: &str) -> Params {
    let mut params = Params::default();
    apply_sets(&mut params, &[assignment]).unwrap();
    params
}

/// The message for a setting that must be refused and change nothing.
fn refused(assignment: &str) -> String {
    let mut params = Params::default();
    let error = apply_sets(&mut params, &[assignment]).unwrap_err();
    assert_eq!(params, Params::default(), "{assignment} was refused, yet something changed");
    let text = error.to_string();
    assert!(!text.contains('\n'), "one line: {text}");
    text
}

#[test]
fn every_kind_of_leaf_is_set() {
    assert_eq!(set("bounces=7").bounces, 7);
    assert_eq!(set("seed=4294967295").seed, u32::MAX);
    assert_eq!(set("post.exposure=2").post.exposure, 2.0);
    assert_eq!(set("post.exposure = 1e-3").post.exposure, 1e-3);
    assert!(!set("post.bloom=false").post.bloom);
    assert_eq!(set("post.operator=reinhard").post.operator, Operator::Reinhard);
    assert_eq!(set("post.operator=none").post.operator, Operator::None);
    assert_eq!(set("post.clamp=3").post.clamp, Some(3.0));
}

#[test]
fn optional_values_can_be_taken_away_again() {
    let mut params = set("post.clamp=3");
    apply_sets(&mut params, &["post.clamp=none"]).unwrap();
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
        r#"unknown key "post.expsure", closest: "post.exposure" ("post" has: bloom, clamp, exposure, max_ev, min_ev, operator)"#
    );
    let without_table = refused("exposure=1");
    assert!(without_table.contains(r#"closest: "post.exposure""#), "{without_table}");
    assert!(without_table.contains("the top level has: bounces, camera, post, seed"), "{without_table}");
    assert!(refused("pots.exposure=1").contains(r#"closest: "post.exposure""#), "the likest table");
    assert!(refused("pots.bloom=true").contains(r#"closest: "post.bloom""#));
    assert!(refused("bounces.deep=1").contains(r#"unknown key "bounces.deep""#));
    assert!(refused("post=1").contains(r#"key "post" is a table, set one of its keys: bloom"#));
    assert!(refused("post.=1").contains("unknown key"));
    // What is spelt like nothing is not guessed at.
    for nonsense in ["camera.spp=1", "post.variant=1", "xyz=1", "post.=1"] {
        assert!(!refused(nonsense).contains("closest"), "{nonsense}: {}", refused(nonsense));
    }
    for (slip, meant) in [("post.operator=reinhrad", "reinhard"), ("post.operator=aecs", "aces")] {
        assert!(refused(slip).ends_with(&format!("closest: {meant:?}")), "{}", refused(slip));
    }
    assert!(!refused("post.operator=filmic").contains("closest"));
    assert_eq!(close_to("Galery", ["gallery", "glass"]), ", closest: \"gallery\"");
    assert_eq!(close_to("scene", ["gallery", "glass"]), "");
}

#[test]
fn wrong_types_and_ranges_name_what_is_expected() {
    assert_eq!(
        refused("post.bloom=maybe"),
        r#"key "post.bloom": expected boolean (true or false), got maybe"#
    );
    assert!(refused("bounces=2.5").contains("expected integer, 0 to 255, got 2.5"));
    assert!(refused("bounces=many").contains("expected integer, 0 to 255, got many"));
    assert_eq!(refused("bounces=256"), "bounces: 256 is out of range, expected 0 to 255");
    assert!(
        refused("seed=4294967296").contains("key \"seed\": expected a whole number below 2^32, at least 0")
    );
    assert!(refused("bounces=-1").contains("key \"bounces\": expected a whole number below 2^32, 0 to 255"));
    assert!(refused("post.exposure=bright").contains("expected finite number, 0 to 100, got bright"));
    assert!(refused("post.exposure=nan").contains("expected finite number"));
    assert!(refused("post.max_ev=1e300").contains("expected finite number, at least -20 EV, got 1e300"));
    assert!(refused("post.operator=filmic").contains("expected one of aces, none, reinhard"));
    assert!(refused("post.operator=3").contains("expected one of aces, none, reinhard"));
    assert_eq!(refused("post.exposure=-1"), "post.exposure: -1 is out of range, expected 0 to 100");
    assert_eq!(refused("post.min_ev=5"), "post.min_ev: 5 is out of range, expected -20 to 4 EV");
    assert_eq!(refused("post.min_ev=-21"), "post.min_ev: -21 is out of range, expected -20 to 20 EV");
    assert_eq!(refused("post.clamp=11"), "post.clamp: 11 is out of range, expected 1 to 10");
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
    apply_toml(&mut params, "bounces = 4\n[post]\nmin_ev = 6\nmax_ev = 7.5\n").unwrap();
    let mut expected = set("post.exposure=3");
    expected.bounces = 4;
    expected.post = Post { min_ev: 6.0, max_ev: 7.5, ..expected.post };
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
fn a_declaration_says_everything() {
    let listed = serde_json::to_value(Params::knobs()).unwrap();
    let keys: Vec<_> = Params::knobs().into_iter().map(|knob| knob.key).collect();
    assert_eq!(
        keys,
        [
            "bounces",
            "camera.exposure",
            "seed",
            "post.exposure",
            "post.min_ev",
            "post.max_ev",
            "post.operator",
            "post.bloom",
            "post.clamp"
        ]
    );
    assert_eq!(
        listed[4],
        json!({
            "key": "post.min_ev", "type": "number", "default": -4.0, "range": [-20.0, 20.0], "values": null, "unit": "EV",
            "doc": "Least exposure.", "source": "Someone 1999, section 3", "structural": false,
        })
    );
    assert_eq!(listed[0]["range"], json!([0, 255]));
    assert_eq!((&listed[0]["type"], &listed[0]["source"]), (&json!("integer"), &Value::Null));
    assert_eq!(listed[3]["default"], json!(0.1), "no noise digits of f32");
    assert_eq!(
        (&listed[6]["default"], &listed[6]["values"]),
        (&json!("aces"), &json!(["aces", "none", "reinhard"]))
    );
    assert_eq!((&listed[7]["type"], &listed[7]["values"]), (&json!("boolean"), &json!([false, true])));
    assert_eq!((&listed[8]["type"], &listed[8]["default"]), (&json!("optional number"), &Value::Null));
}

#[test]
fn declarations_in_words() {
    let words: Vec<_> = Params::knobs()
        .iter()
        .map(|k| format!("{} [{}] {}", k.default_text(), k.takes(), k.description()))
        .collect();
    assert_eq!(words[2], "0 [at least 0] Seed.");
    assert_eq!(words[4], "-4 [-20 to 20 EV] Least exposure (Someone 1999, section 3).");
    assert_eq!(words[5], "4 [at least -20 EV] Greatest exposure.");
    assert_eq!(words[6], "aces [aces, none, reinhard] Curve. Structural.");
    assert_eq!(words[7], "true [true, false] Whether there is bloom.");
    assert_eq!(words[8], "none [1 to 10, or none] Limit. Structural.");
}

/// What is listed can be set: the listing is the documentation of `--set`.
#[test]
fn every_listed_key_takes_its_default() {
    for knob in Params::knobs() {
        assert_eq!(set(&format!("{}={}", knob.key, knob.default_text())), Params::default(), "{}", knob.key);
    }
}

#[test]
fn structural_knobs_are_told_from_those_of_a_frame() {
    let default = Params::default();
    for (assignment, key) in [
        ("post.operator=none", Some("post.operator")),
        ("post.clamp=2", Some("post.clamp")),
        ("post.bloom=false", None),
        ("bounces=1", None),
    ] {
        assert_eq!(default.structural_difference(&set(assignment)).as_deref(), key, "{assignment}");
        assert_eq!(set(assignment).structural_difference(&set(assignment)), None);
    }
}
