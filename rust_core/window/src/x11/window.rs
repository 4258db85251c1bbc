//! The open window on an X server.

use std::os::fd::BorrowedFd;
use std::sync::Arc;
use std::time::Instant;

use rustix::event::{PollFd, PollFlags};
use x11rb::connection::Connection;
use x11rb::protocol::randr::{ConnectionExt as _, NotifyMask};
use x11rb::protocol::xproto::{StackMode, Window};
use x11rb::protocol::Event;
use x11rb::wrapper::ConnectionExt as _;

use super::awake::Awake;
use super::keyboard::Keyboard;
use super::modes::ModeCheck;
use super::refresh::RefreshWatch;
use super::session::X11Session;
use super::transfer::Transfer;
use crate::dead_man::WindowRole;
use crate::error::WindowError;
use crate::monitor::MonitorInfo;
use crate::on_screen::OnScreen;
use crate::refresh::Refresh;
use crate::system_window::{poll_until, SystemEvent, SystemWindow, WindowOptions};
use crate::watch::{MonitorWatch, WindowAction};

/// A window on an X server, over one monitor.
pub(crate) struct X11Window {
    session: X11Session,
    window: Window,
    delete: Option<u32>,
    watch: MonitorWatch,
    transfer: Transfer,
    keyboard: Keyboard,
    awake: Awake,
    refresh: RefreshWatch,
    /// `true` if no window manager places it.
    placed_by_itself: bool,
    has_keyboard: bool,
    size_px: (u32, u32),
    mode_check: ModeCheck,
    role: WindowRole,
}

impl X11Window {
    /// Opens the window on the monitor that the options choose.
    pub(crate) fn open(options: &WindowOptions) -> Result<Self, WindowError> {
        let session = X11Session::open()?;
        let mut monitors = session.monitors();
        let mut monitor = monitors.swap_remove(options.monitor.resolve(&monitors)?);
        let mut mode_check = ModeCheck { set_mode: options.set_mode, last_warning: None };
        if session.check_mode(&monitor.name, &mut mode_check) {
            let name = monitor.name.clone();
            monitor = session.monitors().into_iter().find(|info| info.name == name).unwrap_or(monitor);
        }
        log::info!("{} on monitor {monitor}", options.source);
        let modes = session.output_modes(&monitor.name);
        let is_unknown_to_managers = monitor.is_virtual || (modes.is_none() && session.has_randr());
        // Managers keep windows that they do not manage in front of all others.
        let is_unmanaged = is_unknown_to_managers || options.role.is_in_front();
        let placed_by_itself = is_unmanaged || !session.has_fullscreen_manager();
        let window = session.create_window(options, &monitor, placed_by_itself)?;
        let now = Instant::now();
        if session.has_randr() {
            let changes = NotifyMask::SCREEN_CHANGE | NotifyMask::CRTC_CHANGE | NotifyMask::OUTPUT_CHANGE;
            session.connection.randr_select_input(session.root(), changes).map_err(X11Session::lost)?;
        }
        session.map(window, &monitor, placed_by_itself)?;
        Ok(Self {
            window,
            delete: session.atom("WM_DELETE_WINDOW"),
            transfer: Transfer::new(&session, window)?,
            keyboard: Keyboard::read(&session),
            awake: Awake::start(&session, now),
            refresh: RefreshWatch::new(&session, window, modes.and_then(|modes| modes.refresh_period())),
            placed_by_itself,
            has_keyboard: !placed_by_itself,
            size_px: monitor.size_px,
            watch: MonitorWatch::new(monitor, now),
            mode_check,
            role: options.role.clone(),
            session,
        })
    }

    /// Handles one event of the server.
    fn translate(&mut self, event: Event) -> Option<SystemEvent> {
        match event {
            Event::Expose(event) if event.count == 0 => Some(SystemEvent::Expose),
            Event::ConfigureNotify(event) if event.window == self.window => {
                self.size_px = (event.width.into(), event.height.into());
                Some(SystemEvent::Expose)
            }
            Event::ShmCompletion(event) => {
                self.transfer.complete(&event);
                None
            }
            Event::PresentCompleteNotify(event) => {
                self.refresh.take(&event);
                None
            }
            Event::KeyRelease(event) => {
                self.keyboard.release(&event);
                None
            }
            Event::KeyPress(event) => {
                let is_repeat = self.keyboard.is_repeat(&event);
                self.keyboard.keysym(&event).map(|keysym| SystemEvent::Key { keysym, is_repeat })
            }
            Event::MappingNotify(_) => {
                self.keyboard = Keyboard::read(&self.session);
                None
            }
            Event::ClientMessage(event) if Some(event.data.as_data32()[0]) == self.delete => Some(SystemEvent::Close),
            Event::DestroyNotify(event) if event.window == self.window => Some(SystemEvent::Close),
            Event::RandrNotify(_) | Event::RandrScreenChangeNotify(_) => Some(SystemEvent::Monitors),
            Event::Error(error) => {
                log::debug!("the X server refuses a request: {error:?}");
                None
            }
            _ => None,
        }
    }

    /// Handles the server's pending events. Returns `true` if there were any.
    fn take_events(&mut self, events: &mut Vec<SystemEvent>) -> Result<bool, WindowError> {
        let mut is_any = false;
        while let Some(event) = self.session.connection.poll_for_event().map_err(X11Session::lost)? {
            is_any = true;
            let event = self.translate(event);
            // A change of monitors comes in several events, of which one is enough.
            events.extend(event.filter(|event| *event != SystemEvent::Monitors || !events.contains(event)));
        }
        Ok(is_any)
    }
}

impl SystemWindow for X11Window {
    fn monitor(&self) -> &MonitorInfo {
        self.watch.monitor()
    }

    fn is_there(&self) -> bool {
        self.watch.is_there()
    }

    fn come_to_front(&mut self) -> Result<(), WindowError> {
        self.session.withdraw(self.window)?;
        self.has_keyboard = !self.placed_by_itself;
        self.session.map(self.window, self.watch.monitor(), self.placed_by_itself)
    }

    fn size_px(&self) -> (u32, u32) {
        if self.watch.is_there() {
            self.size_px
        } else {
            (0, 0)
        }
    }

    fn is_ready(&self) -> bool {
        self.transfer.is_ready()
    }

    fn present(&mut self, pixels: &[u32], on_screen: Option<Arc<dyn OnScreen>>) -> Result<(), WindowError> {
        if self.role.is_black() {
            // The server paints the background. It has mapped the window when it answers.
            self.session.connection.sync().map_err(X11Session::lost)?;
            on_screen.iter().for_each(|listener| listener.shown());
            return Ok(());
        }
        self.transfer.send(&self.session, pixels, self.size_px, on_screen)
    }

    fn wait(&mut self, wake: BorrowedFd<'_>, until: Instant) -> Result<Vec<SystemEvent>, WindowError> {
        let mut events = Vec::new();
        if !self.take_events(&mut events)? {
            self.session.connection.flush().map_err(X11Session::lost)?;
            let server = self.session.connection.stream();
            let mut fds = [PollFd::new(server, PollFlags::IN), PollFd::from_borrowed_fd(wake, PollFlags::IN)];
            poll_until(&mut fds, until)?;
            self.take_events(&mut events)?;
        }
        Ok(events)
    }

    fn refresh(&self) -> Option<Refresh> {
        self.refresh.refresh()
    }

    fn next_check(&self) -> Instant {
        self.watch.next_check()
    }

    fn check(&mut self, now: Instant) -> Result<bool, WindowError> {
        let monitors = self.session.monitors();
        if monitors.is_empty() {
            // Distinguishes a server without monitors from a broken connection.
            self.session.connection.sync().map_err(X11Session::lost)?;
        }
        let place = self.session.place_of(self.window);
        let found = self.watch.check(now, &monitors, place);
        match found.action {
            WindowAction::Leave => {}
            WindowAction::Hide => {
                self.session.withdraw(self.window)?;
                self.has_keyboard = !self.placed_by_itself;
            }
            WindowAction::CoverAgain if place.is_none() => {
                // A window manager that is starting may have unmapped the window.
                self.session.map(self.window, self.watch.monitor(), self.placed_by_itself)?;
            }
            WindowAction::CoverAgain => {
                // A black window stays below the process's own.
                let stacking = if self.role.is_black() { None } else { Some(StackMode::ABOVE) };
                self.session.cover_again(self.window, self.watch.monitor(), self.placed_by_itself, stacking)?;
            }
        }
        if self.role.is_in_front() {
            self.session.raise(self.window)?;
        }
        if self.watch.is_there() && self.role.takes_keyboard() {
            // A window manager that hears of the process's death later passes the keyboard on.
            let may_lose_it = self.role.is_black() && self.watch.is_settling(now);
            self.has_keyboard = (self.has_keyboard && !may_lose_it) || self.session.focus(self.window);
            if found.has_settled && !self.has_keyboard {
                log::warn!("the window does not get the keyboard; end with Ctrl-C instead of Escape");
            }
        }
        if self.watch.is_there() && !self.role.is_black() {
            let name = self.watch.monitor().name.clone();
            self.session.check_mode(&name, &mut self.mode_check);
        }
        self.awake.keep(&self.session, now);
        self.refresh.request(&self.session);
        Ok(found.is_changed)
    }
}

impl Drop for X11Window {
    fn drop(&mut self) {
        self.awake.end(&self.session);
    }
}
