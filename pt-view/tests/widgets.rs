//! The panel, driven through its widgets.

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pt_view::knob_sheet::{Knob, KnobKind, Profile};
use pt_view::panel::{Panel, PanelContent};
use pt_view::protocol::{Request, Status, TruthView};

fn knob(key: &str, kind: KnobKind, default: &str) -> Knob {
    Knob {
        key: key.into(),
        kind,
        optional: false,
        default: default.into(),
        takes: "0 to 10 pixels".into(),
        doc: format!("What {key} does (Somebody 2020)."),
        structural: false,
    }
}

fn content() -> PanelContent {
    let choice = KnobKind::Choice(vec![("none".into(), "No jitter.".into()), ("halton".into(), "Halton.".into())]);
    PanelContent {
        knobs: vec![
            knob("gbuffer.jitter", choice, "none"),
            knob("lights.sun", KnobKind::Boolean, "true"),
            knob("post.ev100", KnobKind::Number([-32.0, 32.0]), "0"),
        ],
        values: vec!["none".into(), "true".into(), "2.5".into()],
        profiles: vec![Profile {
            name: "realtime".into(),
            doc: "as a game".into(),
            values: vec!["halton".into(), "true".into(), "0".into()],
        }],
        cameras: vec!["front".into(), "back".into()],
        duration: 10.0,
    }
}

struct State {
    panel: Panel,
    status: Status,
    requests: Vec<Request>,
}

fn harness<'a>() -> Harness<'a, State> {
    let state = State { panel: Panel::new(content()), status: Status::default(), requests: Vec::new() };
    let draw = |context: &egui::Context, state: &mut State| {
        state.requests.extend(state.panel.ui(context, &state.status));
    };
    Harness::builder().with_size(egui::vec2(1200.0, 700.0)).build_state(draw, state)
}

/// Clicks what has this label, and what the panel asked for since.
fn click(harness: &mut Harness<'_, State>, label: &str) -> Vec<Request> {
    harness.get_by_label(label).click();
    harness.run_steps(8);
    std::mem::take(&mut harness.state_mut().requests)
}

fn one_knob(key: &str, value: &str) -> Vec<Request> {
    vec![Request::Knobs(vec![(key.into(), value.into())])]
}

#[test]
fn a_knob_is_turned_marked_reset_and_undone() {
    let mut harness = harness();
    assert_eq!(click(&mut harness, "lights"), []);
    // Its checkbox has the name of the knob as its label.
    harness.get_by_role_and_label(egui::accesskit::Role::CheckBox, "sun").click();
    harness.run_steps(8);
    let requests = std::mem::take(&mut harness.state_mut().requests);
    assert_eq!(requests, one_knob("lights.sun", "false"));
    assert!(harness.query_by_label("lights (1 changed)").is_some(), "the stage is marked");
    assert_eq!(click(&mut harness, "reset"), one_knob("lights.sun", "true"));
    assert_eq!(click(&mut harness, "Undo"), one_knob("lights.sun", "false"));
    assert_eq!(click(&mut harness, "Redo"), one_knob("lights.sun", "true"));
}

#[test]
fn what_differs_from_its_default_at_the_start_is_marked_and_not_sent() {
    let mut harness = harness();
    harness.run_steps(3);
    assert!(harness.query_by_label("post (1 changed)").is_some());
    assert!(harness.state().requests.is_empty(), "{:?}", harness.state().requests);
}

#[test]
fn a_profile_sets_what_it_says() {
    let mut harness = harness();
    click(&mut harness, "Profile");
    let requests = click(&mut harness, "realtime");
    let both = vec![("gbuffer.jitter".into(), "halton".into()), ("post.ev100".into(), "0".into())];
    assert_eq!(requests, [Request::Knobs(both)]);
}

#[test]
fn the_bar_asks_for_time_and_files() {
    let mut harness = harness();
    assert_eq!(click(&mut harness, "Play"), [Request::Play(true)]);
    assert_eq!(click(&mut harness, "Step"), [Request::Step]);
    assert_eq!(click(&mut harness, "Reset"), [Request::ResetHistories]);
    assert_eq!(click(&mut harness, "Copy command"), [Request::HandOut]);
    assert_eq!(click(&mut harness, "Save"), [Request::Save]);
    assert_eq!(click(&mut harness, "Record path"), [Request::Record(true)]);
    harness.state_mut().status = Status { playing: true, recording: true, ..Status::default() };
    harness.run_steps(2);
    assert_eq!(click(&mut harness, "Pause"), [Request::Play(false)]);
    assert_eq!(click(&mut harness, "Write path"), [Request::Record(false)]);
}

#[test]
fn ground_truth_and_cameras_are_asked_for() {
    let mut harness = harness();
    click(&mut harness, "Look");
    assert_eq!(click(&mut harness, "split"), [Request::Truth(TruthView::Split)]);
    assert_eq!(click(&mut harness, "difference"), [Request::Truth(TruthView::Difference)]);
    click(&mut harness, "Keys");
    assert_eq!(click(&mut harness, "back"), [Request::SceneCamera(1)]);
}
