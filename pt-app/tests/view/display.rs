//! An X server without a screen, and a program on it that gets synthetic input.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConfigureWindowAux, ConnectionExt as _, ImageFormat,
    InputFocus, KEY_PRESS_EVENT, KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Everything is compiled by a CPU, perhaps a busy one.
const PATIENCE: Duration = Duration::from_secs(400);

/// Keys by their codes of an X server: those of evdev and 8.
#[derive(Clone, Copy)]
pub enum Key {
    Escape = 9,
    Q = 24,
    W = 25,
    R = 27,
    T = 28,
    P = 33,
    Control = 37,
    D = 40,
    F = 41,
    G = 42,
    H = 43,
    C = 54,
    Space = 65,
}

/// Xvfb.
pub struct Display {
    server: Child,
    pub name: String,
}

impl Display {
    pub fn start() -> Self {
        // It chooses a free number and prints it. Without -noreset it begins anew when its last client leaves.
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1600x1000x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let name = format!(":{}", line.trim());
        // It prints the number before it answers.
        let begun = Instant::now();
        while RustConnection::connect(Some(&name)).is_err() {
            assert!(begun.elapsed() < PATIENCE, "Xvfb does not answer");
            std::thread::sleep(Duration::from_millis(50));
        }
        Self { server, name }
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// `pt view` in its window.
pub struct Shown {
    program: Child,
    lines: BufReader<ChildStdout>,
    x: RustConnection,
    root: Window,
    window: Window,
}

impl Shown {
    /// Starts `pt view` with these words, and waits for its window.
    pub fn start(display: &Display, words: &[&str]) -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_pt"))
            .arg("view")
            .args(words)
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (x, screen) = RustConnection::connect(Some(&display.name)).unwrap();
        let root = x.setup().roots[screen].root;
        let begun = Instant::now();
        let window = loop {
            if let Some(window) = find(&x, root) {
                break window;
            }
            let ended = program.try_wait().unwrap().is_some();
            if ended || begun.elapsed() > PATIENCE {
                let mut said = String::new();
                let _ = program.kill();
                program.stderr.take().unwrap().read_to_string(&mut said).unwrap();
                panic!("no window: {said}");
            }
            std::thread::sleep(Duration::from_millis(100));
        };
        let lines = BufReader::new(program.stdout.take().unwrap());
        let shown = Self { program, lines, x, root, window };
        shown.x.set_input_focus(InputFocus::PARENT, window, 0u32).unwrap();
        shown.move_to([20, 20]);
        shown
    }

    pub fn press(&self, key: Key) {
        self.fake(KEY_PRESS_EVENT, key as u8, [0, 0]);
    }

    pub fn release(&self, key: Key) {
        self.fake(KEY_RELEASE_EVENT, key as u8, [0, 0]);
    }

    pub fn tap(&self, key: Key) {
        self.press(key);
        self.release(key);
    }

    /// Moves the pointer, pixels of the window.
    pub fn move_to(&self, at: [i16; 2]) {
        self.fake(MOTION_NOTIFY_EVENT, 0, at);
    }

    pub fn click(&self, at: [i16; 2]) {
        self.move_to(at);
        // What is under the pointer is found when the window is drawn next.
        std::thread::sleep(Duration::from_millis(600));
        self.fake(BUTTON_PRESS_EVENT, 1, at);
        std::thread::sleep(Duration::from_millis(600));
        self.fake(BUTTON_RELEASE_EVENT, 1, at);
        std::thread::sleep(Duration::from_millis(600));
    }

    /// Drags with a button.
    pub fn drag(&self, button: u8, from: [i16; 2], to: [i16; 2]) {
        self.move_to(from);
        self.fake(BUTTON_PRESS_EVENT, button, from);
        self.move_to([0, 1].map(|axis| i16::midpoint(from[axis], to[axis])));
        self.move_to(to);
        self.fake(BUTTON_RELEASE_EVENT, button, to);
    }

    /// Input without a plan: keys, drags, the wheel, other sizes, a window that is hidden for a while.
    pub fn play_about(&mut self, seed: u32, duration: Duration) {
        let mut dice = seed;
        let mut draw = |below: u32| {
            dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            ((u64::from(dice) * u64::from(below)) >> 32) as u32
        };
        let keys = [Key::R, Key::T, Key::H, Key::C, Key::P, Key::G, Key::Space];
        let begun = Instant::now();
        while begun.elapsed() < duration {
            let mut place = || [draw(460) as i16, draw(100) as i16];
            let (from, to) = (place(), place());
            match draw(7) {
                0 | 1 => self.tap(keys[draw(keys.len() as u32) as usize]),
                2 => {
                    let held = [Key::W, Key::D, Key::F][draw(3) as usize];
                    self.press(held);
                    std::thread::sleep(Duration::from_millis(100));
                    self.release(held);
                }
                3 => self.drag(1 + draw(3) as u8, from, to),
                4 => self.drag(4 + draw(2) as u8, from, from),
                5 => self.resize([300 + draw(600), 100 + draw(400)]),
                _ => {
                    self.x.unmap_window(self.window).unwrap();
                    self.x.sync();
                    std::thread::sleep(Duration::from_millis(200));
                    self.x.map_window(self.window).unwrap();
                    self.x.sync();
                    self.x.set_input_focus(InputFocus::PARENT, self.window, 0u32).unwrap();
                }
            }
            let ended = self.program.try_wait().unwrap();
            assert!(ended.is_none(), "seed {seed}, after {:?}: {ended:?}", begun.elapsed());
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    fn fake(&self, kind: u8, detail: u8, [x, y]: [i16; 2]) {
        self.x.xtest_fake_input(kind, detail, 0, self.root, x, y, 0).unwrap();
        self.x.sync();
    }

    /// Gives the window another size.
    pub fn resize(&self, [width, height]: [u32; 2]) {
        self.x.configure_window(self.window, &ConfigureWindowAux::new().width(width).height(height)).unwrap();
        self.x.sync();
    }

    /// The pixels of the window: width, height, and red, green, blue of each.
    pub fn pixels(&self) -> ([u32; 2], Vec<[u8; 3]>) {
        let size = self.x.get_geometry(self.window).unwrap().reply().unwrap();
        let image = self
            .x
            .get_image(ImageFormat::Z_PIXMAP, self.window, 0, 0, size.width, size.height, !0)
            .unwrap()
            .reply()
            .unwrap();
        let rgb = image.data.chunks_exact(4).map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        ([size.width.into(), size.height.into()], rgb)
    }

    /// Waits until the window fulfils this.
    pub fn wait_for(&mut self, what: &str, mut is_so: impl FnMut(&Self) -> bool) {
        let begun = Instant::now();
        while !is_so(self) {
            assert!(self.program.try_wait().unwrap().is_none(), "{what}: pt view ended");
            assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    /// The next line that it prints.
    pub fn line(&mut self) -> String {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    /// Closes the window as a window manager does. See [`Shown::ended`].
    pub fn close(self) -> Ended {
        let atom = |name: &str| self.x.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
        let data = [atom("WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event =
            x11rb::protocol::xproto::ClientMessageEvent::new(32, self.window, atom("WM_PROTOCOLS"), data);
        self.x.send_event(false, self.window, x11rb::protocol::xproto::EventMask::NO_EVENT, event).unwrap();
        self.x.sync();
        self.ended()
    }

    /// Closes the window by its key. See [`Shown::ended`].
    pub fn close_by_key(mut self) -> Ended {
        let begun = Instant::now();
        while self.program.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < PATIENCE, "Ctrl Q does not close the window");
            // A field of the panel may have the keys, a menu the pointer.
            self.tap(Key::Escape);
            self.press(Key::Control);
            self.tap(Key::Q);
            self.release(Key::Control);
            std::thread::sleep(Duration::from_millis(500));
        }
        self.ended()
    }

    /// Checks that the program ends well, without a message of the validation layers; what its last line says.
    fn ended(mut self) -> Ended {
        let status = self.program.wait().unwrap();
        let mut said = String::new();
        self.program.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert!(status.success(), "{status}: {said}");
        assert!(!said.contains("validation"), "{said}");
        let mut lines = String::new();
        self.lines.read_to_string(&mut lines).unwrap();
        Ended::of(lines.lines().last().unwrap())
    }
}

/// What the last line says, numbers of frames and milliseconds.
#[derive(Debug)]
pub struct Ended {
    pub frames: f64,
    pub median_frame: f64,
    pub longest_frame: f64,
    pub median_wait: f64,
    pub longest_wait: f64,
}

impl Ended {
    fn of(line: &str) -> Self {
        let after = |words: &str, from: usize| {
            let start =
                from + line[from..].find(words).unwrap_or_else(|| panic!("{words}: {line}")) + words.len();
            let number = line[start..].trim_start().split(' ').next().unwrap();
            (start, number.parse::<f64>().unwrap_or_else(|_| panic!("{number}: {line}")))
        };
        let (frame, median_frame) = after("a frame took ", 0);
        let (_, longest_frame) = after("(median), ", frame);
        let (wait, median_wait) = after("input waited ", 0);
        let (_, longest_wait) = after("(median), ", wait);
        Self { frames: after("", 0).1, median_frame, longest_frame, median_wait, longest_wait }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

trait Sync {
    fn sync(&self);
}

impl Sync for RustConnection {
    /// Waits until the server has done all requests.
    fn sync(&self) {
        self.get_input_focus().unwrap().reply().unwrap();
    }
}

/// The window whose title begins with `pt view`.
fn find(x: &RustConnection, root: Window) -> Option<Window> {
    let children = x.query_tree(root).ok()?.reply().ok()?.children;
    children.into_iter().find(|&window| {
        let title = x.get_property(false, window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 64);
        let title = title.ok().and_then(|title| title.reply().ok());
        let is_mapped = x.get_window_attributes(window).ok().and_then(|attributes| attributes.reply().ok());
        title.is_some_and(|title| title.value.starts_with(b"pt view"))
            && is_mapped.is_some_and(|a| a.map_state == x11rb::protocol::xproto::MapState::VIEWABLE)
    })
}
