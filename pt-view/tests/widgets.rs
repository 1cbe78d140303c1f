//! The panel, driven through its widgets.

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

/// A panel with a pointer. Widgets are found by the text that is drawn.
struct Harness {
    context: egui::Context,
    panel: Panel,
    status: Status,
    shapes: Vec<egui::epaint::ClippedShape>,
    time: f64,
}

impl Harness {
    fn new() -> Self {
        let (context, panel) = (egui::Context::default(), Panel::new(content()));
        let mut harness = Self { context, panel, status: Status::default(), shapes: Vec::new(), time: 0.0 };
        assert_eq!(harness.rest(), [], "nothing is asked for at the start");
        harness
    }

    fn step(&mut self, events: Vec<egui::Event>) -> Vec<Request> {
        let mut requests = Vec::new();
        self.time += 0.1;
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1200.0, 700.0))),
            time: Some(self.time),
            events,
            ..Default::default()
        };
        let output = self.context.run(input, |context| requests.extend(self.panel.ui(context, &self.status)));
        self.shapes = output.shapes;
        requests
    }

    /// Until what opens with a movement is open.
    fn rest(&mut self) -> Vec<Request> {
        (0..8).flat_map(|_| self.step(Vec::new())).collect()
    }

    /// Where this text is drawn.
    fn find(&self, text: &str) -> Option<egui::Rect> {
        let place = |shape: &egui::Shape| match shape {
            egui::Shape::Text(drawn) if drawn.galley.text() == text => Some(drawn.visual_bounding_rect()),
            _ => None,
        };
        self.shapes.iter().find_map(|clipped| place(&clipped.shape))
    }

    /// Clicks; what the panel asks for then.
    fn click_at(&mut self, at: egui::Pos2) -> Vec<Request> {
        let button = |pressed| egui::Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let mut requests = self.step(vec![egui::Event::PointerMoved(at)]);
        requests.extend(self.step(vec![button(true)]));
        requests.extend(self.step(vec![button(false)]));
        requests.extend(self.rest());
        requests
    }

    fn click(&mut self, text: &str) -> Vec<Request> {
        let at = self.find(text).unwrap_or_else(|| panic!("{text} is not drawn")).center();
        self.click_at(at)
    }

    /// Drags from a text by `points` to the right.
    fn drag(&mut self, text: &str, points: f32) -> Vec<Request> {
        let from = self.find(text).unwrap_or_else(|| panic!("{text} is not drawn")).center();
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let to = |share: f32| from + egui::vec2(points * share, 0.0);
        let mut requests = self.step(vec![egui::Event::PointerMoved(from)]);
        requests.extend(self.step(vec![button(from, true)]));
        for share in [0.25, 0.5, 0.75, 1.0] {
            requests.extend(self.step(vec![egui::Event::PointerMoved(to(share))]));
        }
        requests.extend(self.step(vec![button(to(1.0), false)]));
        requests
    }
}

fn one_knob(key: &str, value: &str) -> Vec<Request> {
    vec![Request::Knobs(vec![(key.into(), value.into())])]
}

#[test]
fn a_knob_is_turned_marked_reset_and_undone() {
    let mut harness = Harness::new();
    assert_eq!(harness.click("lights"), []);
    // Its checkbox is behind its name.
    let name = harness.find("sun").unwrap();
    assert_eq!(
        harness.click_at(name.right_center() + egui::vec2(16.0, 0.0)),
        one_knob("lights.sun", "false")
    );
    assert!(harness.find("lights (1 changed)").is_some(), "the stage is marked");
    assert_eq!(harness.click("reset"), one_knob("lights.sun", "true"));
    assert!(harness.find("lights").is_some());
    assert_eq!(harness.click("Undo"), one_knob("lights.sun", "false"));
    assert_eq!(harness.click("Redo"), one_knob("lights.sun", "true"));
}

#[test]
fn a_number_is_dragged_within_its_range_and_the_drag_is_one_change() {
    let mut harness = Harness::new();
    harness.click("post (1 changed)");
    let requests = harness.drag("2.5", 160.0);
    assert!(requests.len() > 1, "it changes while it is dragged");
    assert_eq!(requests.last(), one_knob("post.ev100", "32").first(), "and ends at its range");
    assert_eq!(harness.click("Undo"), one_knob("post.ev100", "2.5"));
}

#[test]
fn what_differs_from_its_default_at_the_start_is_marked_and_a_search_lists_what_it_names() {
    let mut harness = Harness::new();
    assert!(harness.find("post (1 changed)").is_some());
    harness.panel.search("JITTER");
    harness.rest();
    assert!(harness.find("gbuffer").is_some() && harness.find("jitter").is_some(), "open at once");
    assert!(harness.find("lights").is_none());
}

#[test]
fn a_profile_sets_what_it_says() {
    let mut harness = Harness::new();
    harness.click("Profile");
    let requests = harness.click("realtime");
    let both = vec![("gbuffer.jitter".into(), "halton".into()), ("post.ev100".into(), "0".into())];
    assert_eq!(requests, [Request::Knobs(both)]);
}

#[test]
fn the_bar_asks_for_time_and_files() {
    let mut harness = Harness::new();
    assert_eq!(harness.click("Play"), [Request::Play(true)]);
    assert_eq!(harness.click("Step"), [Request::Step]);
    assert_eq!(harness.click("Reset"), [Request::ResetHistories]);
    assert_eq!(harness.click("Copy command"), [Request::HandOut]);
    assert_eq!(harness.click("Save"), [Request::Save]);
    assert_eq!(harness.click("Record path"), [Request::Record(true)]);
    assert_eq!(harness.click("Capture"), [Request::Capture(true)]);
    harness.status = Status { playing: true, recording: true, capture: Some([3, 16]), ..Status::default() };
    harness.rest();
    assert_eq!(harness.click("Pause"), [Request::Play(false)]);
    assert_eq!(harness.click("Write path"), [Request::Record(false)]);
    assert!(harness.find("captured 3 of 16").is_some());
    assert_eq!(harness.click("End capture"), [Request::Capture(false)]);
}

#[test]
fn ground_truth_and_cameras_are_asked_for() {
    let mut harness = Harness::new();
    harness.click("Look");
    assert_eq!(harness.click("split"), [Request::Truth(TruthView::Split)]);
    assert_eq!(harness.click("flip"), [Request::Truth(TruthView::Flip)]);
    assert_eq!(harness.click("difference"), [Request::Truth(TruthView::Difference)]);
    harness.click("Keys");
    assert_eq!(harness.click("back"), [Request::SceneCamera(1)]);
}
