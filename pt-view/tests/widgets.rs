//! The panel, driven through its widgets as egui_kittest finds them: by role and label, as a screen reader does.

use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};
use pt_view::knob_sheet::{Knob, KnobKind, Profile};
use pt_view::panel::{Panel, PanelContent};
use pt_view::protocol::{PassTime, Request, Status, TruthView};

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
    let choice =
        KnobKind::Choice(vec![("none".into(), "No jitter.".into()), ("halton".into(), "Halton.".into())]);
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

/// What the widgets act on.
struct Driven {
    panel: Panel,
    status: Status,
    requests: Vec<Request>,
}

/// A panel in a window, and a pointer.
struct Driver(Harness<'static, Driven>);

impl Driver {
    fn new() -> Self {
        let driven = Driven { panel: Panel::new(content()), status: Status::default(), requests: Vec::new() };
        let ui = |ui: &mut egui::Ui, driven: &mut Driven| {
            let requests = driven.panel.ui(ui, &driven.status);
            driven.requests.extend(requests);
        };
        let mut driver = Self(Harness::builder().with_size([1200.0, 700.0]).build_ui_state(ui, driven));
        assert_eq!(driver.rest(), [], "nothing is asked for at the start");
        driver
    }

    /// Until the panel is at rest; what it asks for.
    fn rest(&mut self) -> Vec<Request> {
        self.0.run();
        std::mem::take(&mut self.0.state_mut().requests)
    }

    fn set_status(&mut self, status: Status) {
        self.0.state_mut().status = status;
        self.rest();
    }

    fn shows(&self, label: &str) -> bool {
        self.0.query_all_by_label(label).next().is_some()
    }

    /// The one widget of this role and label.
    fn widget<'a>(&'a self, role: Role, label: &'a str) -> Node<'a> {
        self.0.get_by_role_and_label(role, label)
    }

    /// Clicks a widget; what the panel asks for then.
    fn click(&mut self, role: Role, label: &str) -> Vec<Request> {
        self.widget(role, label).click();
        self.rest()
    }

    fn press(&mut self, label: &str) -> Vec<Request> {
        self.click(Role::Button, label)
    }

    /// Drags a widget by `points` to the right.
    fn drag(&mut self, role: Role, label: &str, points: f32) -> Vec<Request> {
        let from = self.widget(role, label).rect().center();
        self.0.drag_at(from);
        let mut requests = self.rest();
        for share in [0.25, 0.5, 0.75, 1.0] {
            self.0.hover_at(from + egui::vec2(points * share, 0.0));
            requests.extend(self.rest());
        }
        self.0.drop_at(from + egui::vec2(points, 0.0));
        requests.extend(self.rest());
        requests
    }
}

fn one_knob(key: &str, value: &str) -> Vec<Request> {
    vec![Request::Knobs(vec![(key.into(), value.into())])]
}

#[test]
fn a_knob_is_turned_marked_reset_and_undone() {
    let mut driver = Driver::new();
    assert_eq!(driver.press("lights"), []);
    assert_eq!(driver.click(Role::CheckBox, "sun"), one_knob("lights.sun", "false"));
    assert!(driver.shows("lights (1 changed)"), "the stage is marked");
    assert_eq!(driver.press("reset"), one_knob("lights.sun", "true"));
    assert!(driver.shows("lights"));
    assert_eq!(driver.press("Undo"), one_knob("lights.sun", "false"));
    assert_eq!(driver.press("Redo"), one_knob("lights.sun", "true"));
    assert!(driver.widget(Role::Button, "Redo").accesskit_node().is_disabled(), "there is no more to redo");
}

#[test]
fn a_number_is_dragged_within_its_range_and_the_drag_is_one_change() {
    let mut driver = Driver::new();
    driver.press("post (1 changed)");
    let requests = driver.drag(Role::SpinButton, "ev100", 160.0);
    assert!(requests.len() > 1, "it changes while it is dragged");
    assert_eq!(requests.last(), one_knob("post.ev100", "32").first(), "and ends at its range");
    assert_eq!(driver.press("Undo"), one_knob("post.ev100", "2.5"));
}

#[test]
fn a_choice_is_made_from_its_list() {
    let mut driver = Driver::new();
    driver.press("gbuffer");
    assert_eq!(driver.click(Role::ComboBox, "jitter"), []);
    assert_eq!(driver.press("halton"), one_knob("gbuffer.jitter", "halton"));
    assert!(!driver.shows("halton"), "the list is closed");
    assert_eq!(driver.widget(Role::ComboBox, "jitter").value().as_deref(), Some("halton"));
}

#[test]
fn what_differs_from_its_default_at_the_start_is_marked_and_a_search_lists_what_it_names() {
    let mut driver = Driver::new();
    assert!(driver.shows("post (1 changed)"));
    let search = driver.0.get_by_role(Role::TextInput);
    search.focus();
    driver.rest();
    driver.0.get_by_role(Role::TextInput).type_text("JITTER");
    assert_eq!(driver.rest(), []);
    assert!(driver.shows("gbuffer") && driver.shows("jitter"), "open at once");
    assert!(!driver.shows("lights"));
}

#[test]
fn only_what_differs_is_listed_on_request() {
    let mut driver = Driver::new();
    driver.click(Role::CheckBox, "changed");
    assert!(driver.shows("ev100") && !driver.shows("lights") && !driver.shows("gbuffer"));
}

#[test]
fn a_knob_tells_what_it_does() {
    let mut driver = Driver::new();
    driver.press("lights");
    driver.0.get_all_by_label("sun").next().unwrap().hover();
    // Tooltips wait.
    driver.0.run_steps(4);
    assert!(driver.shows("What lights.sun does (Somebody 2020)."));
    assert!(driver.shows("0 to 10 pixels; default true"));
}

#[test]
fn a_profile_sets_what_it_says() {
    let mut driver = Driver::new();
    driver.press("Profile");
    let requests = driver.press("realtime");
    let both = vec![("gbuffer.jitter".into(), "halton".into()), ("post.ev100".into(), "0".into())];
    assert_eq!(requests, [Request::Knobs(both)]);
}

#[test]
fn the_bar_asks_for_time_and_files() {
    let mut driver = Driver::new();
    assert_eq!(driver.press("Play"), [Request::Play(true)]);
    assert_eq!(driver.press("Step"), [Request::Step]);
    assert_eq!(driver.press("Reset"), [Request::ResetHistories]);
    assert_eq!(driver.press("Copy command"), [Request::HandOut]);
    assert_eq!(driver.press("Save"), [Request::Save]);
    assert_eq!(driver.press("Record path"), [Request::Record(true)]);
    assert_eq!(driver.press("Capture"), [Request::Capture(true)]);
    let sought = driver.0.get_by_role(Role::Slider).rect().center();
    driver.0.drag_at(sought);
    driver.0.drop_at(sought);
    assert!(matches!(driver.rest()[..], [Request::Seek(time), ..] if time > 2.0 && time < 8.0));
    driver.set_status(Status { playing: true, recording: true, capture: Some([3, 16]), ..Status::default() });
    assert_eq!(driver.press("Pause"), [Request::Play(false)]);
    assert_eq!(driver.press("Write path"), [Request::Record(false)]);
    assert!(driver.shows("captured 3 of 16"));
    assert_eq!(driver.press("End capture"), [Request::Capture(false)]);
}

#[test]
fn ground_truth_and_cameras_are_asked_for() {
    let mut driver = Driver::new();
    driver.press("Look");
    assert_eq!(driver.press("split"), [Request::Truth(TruthView::Split)]);
    assert_eq!(driver.press("flip"), [Request::Truth(TruthView::Flip)]);
    assert_eq!(driver.press("difference"), [Request::Truth(TruthView::Difference)]);
    driver.press("Keys");
    assert_eq!(driver.press("back"), [Request::SceneCamera(1)]);
}

#[test]
fn images_are_looked_at_and_the_pixel_under_the_cursor_is_listed() {
    let mut driver = Driver::new();
    let status = Status {
        images: vec!["depth".into(), "normal".into()],
        pixel: vec![("depth".into(), "2.5000".into())],
        ..Status::default()
    };
    driver.set_status(status);
    driver.press("Look");
    assert!(driver.shows("2.5000"));
    driver.click(Role::ComboBox, "image");
    assert_eq!(driver.press("normal"), [Request::Look(Some("normal".into()))]);
}

#[test]
fn passes_are_listed_with_their_medians() {
    let mut driver = Driver::new();
    for ms in [1.0, 9.0, 2.0] {
        let pass = PassTime { name: "primary rays".into(), ms, rays: 2_500_000, bytes: 0 };
        let status = Status { frame_ms: ms, passes: vec![pass], ..Status::default() };
        driver.0.state_mut().panel.frame_done(&status);
    }
    driver.press("Passes");
    for text in ["frame: 2.00 ms (median of the last frames)", "primary rays", "2.000", "2.50"] {
        assert!(driver.shows(text), "{text}");
    }
}
