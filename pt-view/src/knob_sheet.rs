//! The knobs of the panel with their values: plain data, without a window.

/// The kind of a knob's value.
#[derive(Clone, Debug, PartialEq)]
pub enum KnobKind {
    /// `true` or `false`.
    Boolean,
    /// A whole number.
    Integer([f64; 2]),
    /// A number.
    Number([f64; 2]),
    /// One of these names, each with its sentence.
    Choice(Vec<(String, String)>),
}

/// A knob.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Dotted name; the part before the first dot is the stage.
    pub key: String,
    /// The kind of its value.
    pub kind: KnobKind,
    /// Whether it takes `none` too.
    pub optional: bool,
    /// Default value, as `--set` takes it.
    pub default: String,
    /// The values that it takes, with the unit.
    pub takes: String,
    /// What it does, and where it comes from.
    pub doc: String,
    /// Whether another value makes its stage anew.
    pub structural: bool,
}

impl Knob {
    /// The stage that it belongs to.
    pub fn stage(&self) -> &str {
        self.key.split('.').next().unwrap_or_default()
    }

    /// Its name within the stage.
    pub fn name(&self) -> &str {
        self.key.split_once('.').map_or(self.key.as_str(), |(_, name)| name)
    }
}

/// A named set of values.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Its name.
    pub name: String,
    /// What it is for.
    pub doc: String,
    /// A value for each knob.
    pub values: Vec<String>,
}

/// Value of a knob that has none.
pub const NONE: &str = "none";

/// Knobs with their values, and the way back.
#[derive(Clone, Debug)]
pub struct KnobSheet {
    knobs: Vec<Knob>,
    values: Vec<String>,
    /// Values that the renderer has.
    sent: Vec<String>,
    /// Values before each change.
    undo: Vec<Vec<String>>,
    redo: Vec<Vec<String>>,
    /// The knob that is being dragged: its changes are one.
    dragged: Option<usize>,
}

/// Most changes that can be taken back.
const MOST_UNDO: usize = 256;

impl KnobSheet {
    /// Knobs with the values that the renderer has; a knob without one has its default.
    pub fn new(knobs: Vec<Knob>, values: Vec<String>) -> Self {
        let default =
            |(i, knob): (usize, &Knob)| values.get(i).cloned().unwrap_or_else(|| knob.default.clone());
        let values: Vec<_> = knobs.iter().enumerate().map(default).collect();
        Self { knobs, sent: values.clone(), values, undo: Vec::new(), redo: Vec::new(), dragged: None }
    }

    /// The knobs.
    pub fn knobs(&self) -> &[Knob] {
        &self.knobs
    }

    /// Value of a knob, as `--set` takes it.
    pub fn value(&self, knob: usize) -> &str {
        &self.values[knob]
    }

    /// The stages, in the order of their first knobs.
    pub fn stages(&self) -> Vec<&str> {
        let mut stages: Vec<&str> = self.knobs.iter().map(Knob::stage).collect();
        stages.dedup();
        stages
    }

    /// Whether a knob differs from its default.
    pub fn is_changed(&self, knob: usize) -> bool {
        self.values[knob] != self.knobs[knob].default
    }

    /// How many knobs of a stage differ from their defaults.
    pub fn changed_in(&self, stage: &str) -> usize {
        (0..self.knobs.len()).filter(|&i| self.knobs[i].stage() == stage && self.is_changed(i)).count()
    }

    /// Sets a knob. `drags`: the pointer has not been released, so that this is one change with the last one of the same knob.
    pub fn set(&mut self, knob: usize, value: String, drags: bool) {
        if self.values[knob] == value {
            return;
        }
        if self.dragged != Some(knob) {
            self.remember();
        }
        self.dragged = drags.then_some(knob);
        self.values[knob] = value;
    }

    /// The pointer is released: the next change is another one.
    pub fn release(&mut self) {
        self.dragged = None;
    }

    /// Puts a knob back to its default.
    pub fn reset(&mut self, knob: usize) {
        self.set(knob, self.knobs[knob].default.clone(), false);
    }

    /// Sets all knobs.
    pub fn set_all(&mut self, values: &[String]) {
        if values.len() == self.values.len() && values != self.values {
            self.remember();
            self.values = values.to_vec();
        }
    }

    /// Whether there is a change to take back.
    pub fn can_undo(&self) -> bool {
        !self.undo.is_empty()
    }

    /// Whether there is a change that was taken back.
    pub fn can_redo(&self) -> bool {
        !self.redo.is_empty()
    }

    /// Takes the last change back.
    pub fn undo(&mut self) {
        if let Some(values) = self.undo.pop() {
            self.redo.push(std::mem::replace(&mut self.values, values));
        }
        self.release();
    }

    /// Makes the change again that was taken back last.
    pub fn redo(&mut self) {
        if let Some(values) = self.redo.pop() {
            self.undo.push(std::mem::replace(&mut self.values, values));
        }
        self.release();
    }

    /// Keys and values of the knobs that have changed since the last call.
    pub fn take_changes(&mut self) -> Vec<(String, String)> {
        let changed =
            self.knobs.iter().zip(&self.values).zip(&self.sent).filter(|((_, now), sent)| now != sent);
        let changes = changed.map(|((knob, now), _)| (knob.key.clone(), now.clone())).collect();
        self.sent.clone_from(&self.values);
        changes
    }

    fn remember(&mut self) {
        self.redo.clear();
        self.undo.push(self.values.clone());
        if self.undo.len() > MOST_UNDO {
            self.undo.remove(0);
        }
        self.release();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knob(key: &str, default: &str) -> Knob {
        Knob {
            key: key.into(),
            kind: KnobKind::Number([0.0, 10.0]),
            optional: false,
            default: default.into(),
            takes: String::new(),
            doc: String::new(),
            structural: false,
        }
    }

    fn sheet() -> KnobSheet {
        let knobs = vec![knob("a.x", "1"), knob("a.y", "2"), knob("b.z.w", "3")];
        KnobSheet::new(knobs, vec!["1".into(), "5".into(), "3".into()])
    }

    fn values(sheet: &KnobSheet) -> Vec<&str> {
        (0..3).map(|i| sheet.value(i)).collect()
    }

    #[test]
    fn changes_are_told_once_and_only_what_changed() {
        let mut sheet = sheet();
        assert!(sheet.take_changes().is_empty(), "the renderer has the first values");
        sheet.set(0, "4".into(), false);
        assert_eq!(sheet.take_changes(), [("a.x".to_owned(), "4".to_owned())]);
        assert!(sheet.take_changes().is_empty());
        sheet.undo();
        assert_eq!(sheet.take_changes(), [("a.x".to_owned(), "1".to_owned())], "undone is a change too");
    }

    #[test]
    fn a_drag_is_one_change() {
        let mut sheet = sheet();
        for value in ["2", "3", "4"] {
            sheet.set(0, value.into(), true);
        }
        sheet.release();
        sheet.set(0, "9".into(), true);
        sheet.undo();
        assert_eq!(sheet.value(0), "4");
        sheet.undo();
        assert_eq!(sheet.value(0), "1");
        assert!(!sheet.can_undo());
        sheet.redo();
        sheet.redo();
        assert_eq!(sheet.value(0), "9");
        assert!(!sheet.can_redo());
        sheet.undo();
        sheet.set(1, "7".into(), false);
        assert!(!sheet.can_redo(), "another change ends what could be made again");
    }

    #[test]
    fn reset_profile_and_marks() {
        let mut sheet = sheet();
        assert_eq!((sheet.is_changed(0), sheet.is_changed(1), sheet.changed_in("a")), (false, true, 1));
        sheet.reset(1);
        assert_eq!(sheet.changed_in("a"), 0);
        sheet.set_all(&["7".into(), "8".into(), "9".into()]);
        assert_eq!(values(&sheet), ["7", "8", "9"]);
        sheet.undo();
        assert_eq!(values(&sheet), ["1", "2", "3"]);
        assert_eq!(sheet.stages(), ["a", "b"]);
        assert_eq!(sheet.knobs()[2].name(), "z.w");
    }
}
