//! Which key and which button does what.

use crate::camera::Held;
use winit::keyboard::KeyCode;

/// What a key does when it is pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    Camera(usize),
    PlayOrPause,
    Step,
    ResetHistories,
    NextTruth,
    RecordOrWrite,
    HandOut,
    Save,
    Capture,
    HidePanel,
    Close,
    Undo,
    Redo,
}

/// What `key` does.
pub(crate) fn action(key: KeyCode, control: bool) -> Option<Action> {
    Some(match key {
        KeyCode::KeyZ if control => Action::Undo,
        KeyCode::KeyY if control => Action::Redo,
        KeyCode::KeyQ if control => Action::Close,
        _ if control => return None,
        KeyCode::Space => Action::PlayOrPause,
        KeyCode::Period => Action::Step,
        KeyCode::KeyR => Action::ResetHistories,
        KeyCode::KeyT => Action::NextTruth,
        KeyCode::KeyK => Action::RecordOrWrite,
        KeyCode::KeyC => Action::HandOut,
        KeyCode::KeyP => Action::Save,
        KeyCode::KeyG => Action::Capture,
        KeyCode::KeyH => Action::HidePanel,
        KeyCode::Digit1 => Action::Camera(0),
        KeyCode::Digit2 => Action::Camera(1),
        KeyCode::Digit3 => Action::Camera(2),
        KeyCode::Digit4 => Action::Camera(3),
        KeyCode::Digit5 => Action::Camera(4),
        KeyCode::Digit6 => Action::Camera(5),
        KeyCode::Digit7 => Action::Camera(6),
        KeyCode::Digit8 => Action::Camera(7),
        KeyCode::Digit9 => Action::Camera(8),
        _ => return None,
    })
}

/// Keys that move the camera while they are held.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct HeldKeys {
    keys: [bool; 6],
    pub(crate) shift: bool,
}

impl HeldKeys {
    /// A key is pressed or released.
    pub(crate) fn set(&mut self, key: KeyCode, is_pressed: bool) {
        let keys = [KeyCode::KeyD, KeyCode::KeyA, KeyCode::KeyE, KeyCode::KeyQ, KeyCode::KeyW, KeyCode::KeyS];
        if let Some(index) = keys.iter().position(|known| *known == key) {
            self.keys[index] = is_pressed;
        }
    }

    /// As the camera takes them.
    pub(crate) fn held(&self) -> Held {
        let axis =
            |plus: usize| f32::from(u8::from(self.keys[plus])) - f32::from(u8::from(self.keys[plus + 1]));
        Held { right: axis(0), up: axis(2), forward: axis(4), fast: self.shift }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_held_move_and_opposite_ones_cancel() {
        let mut keys = HeldKeys::default();
        keys.set(KeyCode::KeyW, true);
        keys.set(KeyCode::KeyA, true);
        assert_eq!(keys.held(), Held { forward: 1.0, right: -1.0, ..Held::default() });
        keys.set(KeyCode::KeyD, true);
        keys.set(KeyCode::KeyW, false);
        assert!(!keys.held().is_any());
    }

    #[test]
    fn control_is_for_undo_and_the_end() {
        assert_eq!(action(KeyCode::KeyQ, true), Some(Action::Close));
        assert_eq!(action(KeyCode::KeyQ, false), None, "it flies");
        assert_eq!(action(KeyCode::KeyZ, true), Some(Action::Undo));
        assert_eq!(action(KeyCode::KeyZ, false), None);
        assert_eq!(action(KeyCode::KeyC, true), None, "the panel's own copy");
        assert_eq!(action(KeyCode::KeyC, false), Some(Action::HandOut));
    }
}
