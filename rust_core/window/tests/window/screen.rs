//! An X server for a test, and the example program on it.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, ImageFormat, MapState, PropMode, WindowClass,
    KEY_PRESS_EVENT, KEY_RELEASE_EVENT,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

pub(crate) const WIDTH_PX: u32 = 1280;
pub(crate) const HEIGHT_PX: u32 = 800;
pub(crate) const PATIENCE: Duration = Duration::from_secs(300);

/// A process that ends with the test.
pub(crate) struct Process(pub(crate) Child);

impl Process {
    pub(crate) fn start(command: &mut Command) -> Self {
        let name = format!("{command:?}");
        let child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        Self(child)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The example program, and the file that its standard error goes to.
pub(crate) struct Shown {
    pub(crate) process: Process,
    log: tempfile::NamedTempFile,
}

impl Shown {
    pub(crate) fn start(command: &mut Command) -> Self {
        let log = tempfile::NamedTempFile::new().unwrap();
        let process = Process::start(command.stderr(log.reopen().unwrap()));
        Self { process, log }
    }

    pub(crate) fn log_text(&self) -> String {
        std::fs::read_to_string(self.log.path()).unwrap()
    }
}

/// Polls until there is an answer; fails the test when there is none in time.
pub(crate) fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(answer) = poll() {
            return answer;
        }
        assert!(Instant::now() < deadline, "waited {PATIENCE:?} for {what}");
        sleep(Duration::from_millis(50));
    }
}

/// A virtual screen; `server` lives as long as it.
pub(crate) struct Screen {
    pub(crate) display: String,
    pub(crate) connection: RustConnection,
    pub(crate) root: u32,
    _manager: Option<Process>,
    server: Process,
}

impl Screen {
    pub(crate) fn start(with_manager: bool) -> Self {
        let size = format!("{WIDTH_PX}x{HEIGHT_PX}x24");
        Self::start_with(with_manager, &["-screen", "0", &size])
    }

    pub(crate) fn start_with(with_manager: bool, arguments: &[&str]) -> Self {
        Self::start_server(with_manager, Command::new("Xvfb").args(arguments))
    }

    /// Starts this X server.
    pub(crate) fn start_server(with_manager: bool, command: &mut Command) -> Self {
        let command = command.args(["-displayfd", "1", "-nolisten", "tcp"]);
        let mut server = Process::start(command.stdout(Stdio::piped()).stderr(Stdio::null()));
        let mut number = String::new();
        BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&display)).unwrap();
        let root = connection.setup().roots[screen].root;
        let manager = with_manager.then(|| {
            Process::start(Command::new("openbox").env("DISPLAY", &display).stdout(Stdio::null()).stderr(Stdio::null()))
        });
        let started = Self { display, connection, root, _manager: manager, server };
        if with_manager {
            wait_for("openbox to manage the screen", || started.is_managed().then_some(()));
            started.wait_for_manager();
        }
        started
    }

    /// Kills the server.
    pub(crate) fn stop(&mut self) {
        self.server.0.kill().unwrap();
        self.server.0.wait().unwrap();
    }

    fn is_managed(&self) -> bool {
        let atom = self.connection.intern_atom(false, b"_NET_SUPPORTING_WM_CHECK").unwrap();
        let atom = atom.reply().unwrap().atom;
        let any = x11rb::protocol::xproto::AtomEnum::ANY;
        let property = self.connection.get_property(false, self.root, atom, any, 0, 1).unwrap();
        property.reply().unwrap().value_len > 0
    }

    /// Waits until openbox maps windows: while it starts, it loses requests for that.
    fn wait_for_manager(&self) {
        let window = self.unmapped_window((30, 20));
        wait_for("openbox to map a window", || {
            self.connection.map_window(window).unwrap().check().unwrap();
            let attributes = self.connection.get_window_attributes(window).unwrap().reply().unwrap();
            (attributes.map_state == MapState::VIEWABLE).then_some(())
        });
        self.connection.destroy_window(window).unwrap().check().unwrap();
    }

    pub(crate) fn show(&self, arguments: &[&str]) -> Shown {
        let mut command = Command::new(example());
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        Shown::start(command.args(arguments))
    }

    /// Runs xrandr on this screen.
    pub(crate) fn xrandr(&self, arguments: &[&str]) {
        let output = Command::new("xrandr").args(arguments).env("DISPLAY", &self.display).output().unwrap();
        assert!(output.status.success(), "xrandr {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// A pattern's pixel at each corner of a part of the screen, as they are there.
    pub(crate) fn corners(&self, (left, top): (u32, u32), (width, height): (u32, u32)) -> [u32; 4] {
        let pixels = self.pixels();
        [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]
            .map(|(u, v)| pixels[((top + v) * WIDTH_PX + left + u) as usize])
    }

    /// The pixels of the root window, `0x00RRGGBB`.
    pub(crate) fn pixels(&self) -> Vec<u32> {
        self.pixels_at((0, 0), (WIDTH_PX, HEIGHT_PX))
    }

    /// The pixels of a part of the root window, `0x00RRGGBB`. A screen of depth 30 has ten bits a channel.
    pub(crate) fn pixels_at(&self, (left, top): (i16, i16), (width, height): (u32, u32)) -> Vec<u32> {
        let (width, height) = (width as u16, height as u16);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, left, top, width, height, !0).unwrap();
        let image = image.reply().unwrap();
        let pixels = image.data.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
        let eight_bits = |pixel: u32, shift: u32| ((pixel >> shift & 1023) * 255 + 511) / 1023;
        let narrow = |pixel| eight_bits(pixel, 20) << 16 | eight_bits(pixel, 10) << 8 | eight_bits(pixel, 0);
        pixels.map(|pixel| if image.depth == 30 { narrow(pixel) } else { pixel & 0x00ff_ffff }).collect()
    }

    /// Opens a window as any program does.
    pub(crate) fn plain_window(&self, title: &str, size: (u16, u16)) -> u32 {
        let window = self.unmapped_window(size);
        let (name, kind) = (AtomEnum::WM_NAME, AtomEnum::STRING);
        self.connection.change_property8(PropMode::REPLACE, window, name, kind, title.as_bytes()).unwrap();
        self.connection.map_window(window).unwrap().check().unwrap();
        window
    }

    fn unmapped_window(&self, (width, height): (u16, u16)) -> u32 {
        let window = self.connection.generate_id().unwrap();
        let (class, attributes) = (WindowClass::INPUT_OUTPUT, CreateWindowAux::new().background_pixel(0xff));
        let root = self.root;
        let create = self.connection.create_window(24, window, root, 5, 5, width, height, 0, class, 0, &attributes);
        create.unwrap().check().unwrap();
        window
    }

    /// Moves a window, as its program does.
    pub(crate) fn move_window(&self, window: u32, (x, y): (i32, i32), (width, height): (u32, u32)) {
        let place = ConfigureWindowAux::new().x(x).y(y).width(width).height(height);
        self.connection.configure_window(window, &place).unwrap().check().unwrap();
    }

    /// A window's place on the screen and its size.
    pub(crate) fn place_of(&self, window: u32) -> ((i16, i16), (u16, u16)) {
        let size = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let at = self.connection.translate_coordinates(window, self.root, 0, 0).unwrap().reply().unwrap();
        ((at.dst_x, at.dst_y), (size.width, size.height))
    }

    /// Presses and releases the key that types `keysym`.
    pub(crate) fn press(&self, keysym: u32) {
        self.hold(keysym, || {});
    }

    /// Holds the key that types `keysym` down meanwhile.
    pub(crate) fn hold(&self, keysym: u32, meanwhile: impl FnOnce()) {
        let (first, last) = (self.connection.setup().min_keycode, self.connection.setup().max_keycode);
        let mapping = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap();
        let mapping = mapping.reply().unwrap();
        let per_key = usize::from(mapping.keysyms_per_keycode);
        let place = mapping.keysyms.chunks(per_key).position(|keysyms| keysyms.contains(&keysym));
        let keycode = first + u8::try_from(place.unwrap()).unwrap();
        let send = |event| {
            let request = self.connection.xtest_fake_input(event, keycode, 0, self.root, 0, 0, 0);
            request.unwrap().check().unwrap();
        };
        send(KEY_PRESS_EVENT);
        meanwhile();
        send(KEY_RELEASE_EVENT);
    }

    /// Presses a key until the program ends: the window has the keyboard only once it has settled.
    pub(crate) fn quit(&self, window: &mut Shown, key: u32) -> ExitStatus {
        wait_for("the key to end the program", || {
            self.press(key);
            window.process.0.try_wait().unwrap()
        })
    }

    pub(crate) fn wait_for_pixels(&self, window: &mut Shown, expected: &[u32]) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let pixels = self.pixels();
            if pixels == expected {
                return;
            }
            let ended = window.process.0.try_wait().unwrap();
            if ended.is_some() || Instant::now() > deadline {
                let wrong = pixels.iter().zip(expected).filter(|(got, want)| got != want).count();
                panic!(
                    "{wrong} of {} pixels on the screen are not the picture's; the program {}; the windows are {:#?}; \
                     its log {}",
                    expected.len(),
                    ended.map_or("runs".to_owned(), |status| format!("ended with {status}")),
                    self.windows(),
                    window.log_text(),
                );
            }
            sleep(Duration::from_millis(100));
        }
    }

    /// The windows on the screen from the lowest to the topmost, one line each, for a failing test's message.
    pub(crate) fn windows(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut open = vec![(self.root, 0)];
        while let Some((window, depth)) = open.pop() {
            let attributes = self.connection.get_window_attributes(window).unwrap().reply();
            let geometry = self.connection.get_geometry(window).unwrap().reply();
            if let (Ok(attributes), Ok(at)) = (attributes, geometry) {
                let (state, own_place) = (attributes.map_state, attributes.override_redirect);
                let place = format!("{}x{}{:+}{:+}", at.width, at.height, at.x, at.y);
                lines.push(format!("{:depth$}{window:#x} {place} {state:?} override-redirect {own_place}", ""));
            }
            let children = self.connection.query_tree(window).unwrap().reply();
            let children = children.map(|tree| tree.children).unwrap_or_default();
            open.extend(children.into_iter().rev().map(|child| (child, depth + 2)));
        }
        lines
    }
}

/// The example that cargo built beside this test.
pub(crate) fn example() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let profile = test.parent().and_then(|deps| deps.parent()).unwrap();
    let example = profile.join("examples").join("window_pattern");
    assert!(example.exists(), "{} is built with the tests", example.display());
    example
}

/// The screen with a pattern of this size at its top left, the rest black.
pub(crate) fn expected(width_px: u32, height_px: u32) -> Vec<u32> {
    let mut pixels = Vec::new();
    for v in 0..HEIGHT_PX {
        for u in 0..WIDTH_PX {
            let blue = (16 * (u / 256) + v / 256) % 256;
            let color = (u % 256) << 16 | (v % 256) << 8 | blue;
            pixels.push(if u < width_px && v < height_px { color } else { 0 });
        }
    }
    pixels
}

/// The corners of a pattern of this size.
pub(crate) fn pattern_corners((width, height): (u32, u32)) -> [u32; 4] {
    let all = expected(width, height);
    [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)].map(|(u, v)| all[(v * WIDTH_PX + u) as usize])
}

pub(crate) const ESCAPE: u32 = 0xff1b;
pub(crate) const LETTER_Q: u32 = 0x0071;
pub(crate) const SPACE: u32 = 0x0020;
pub(crate) const LEFT: u32 = 0xff51;
pub(crate) const LETTER_B: u32 = 0x0062;
pub(crate) const LETTER_N: u32 = 0x006e;
